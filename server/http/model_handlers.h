#pragma once
#include "server/http/service.h"

namespace anyrate {

/// POST /v1/models: a zip body becomes a queued model (202, Location), or the earlier one with the same
/// Idempotency-Key.
/// @throws HttpProblem 400 no zip, 415, 422 the key belongs to another request, 507
Response create_model(Service& service, const Request& request);
/// What of that request can be refused before its body is read.
void check_create_model(Service& service, const Request& request);

/// GET /v1/models?limit=&after=: newest first.
Response list_models(Service& service, const Request& request);
/// GET /v1/models/{id}
Response show_model(Service& service, const Request& request);
/// DELETE /v1/models/{id}: in any state; 204
/// POST /v1/models/{id}/cancel: ends a model that is queued or running; its log stays. @throws HttpProblem 409
Response cancel_model(Service& service, const Request& request);
Response delete_model(Service& service, const Request& request);
/// GET /v1/models/{id}/events
Response watch_model(Service& service, const Request& request);

/// The record that the route's {id} names. @throws HttpProblem 404
ModelRecord expect_model(Service& service, const Request& request);

}  // namespace anyrate
