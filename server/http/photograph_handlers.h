#pragma once
#include "server/http/service.h"

namespace anyrate {

/// GET /v1/models/{id}/cameras: where the photographs of the model were taken from, and where they are to be had.
Response show_cameras(Service& service, const Request& request);
/// GET /v1/models/{id}/photographs/{number}: one of them, as it was uploaded, by its place in cameras.json from 0.
Response show_photograph(Service& service, const Request& request);

/// GET /v1/models/{id}/thumbnails/{number}: a small JPEG of that photograph, which the model's worker made.
Response show_thumbnail(Service& service, const Request& request);

}  // namespace anyrate
