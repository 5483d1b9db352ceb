#pragma once
#include "server/http/service.h"

namespace anyrate {

/// GET / and /models/{id}: the web viewer, which finds by its address what to show; without one a plain page that lists
/// the models and links their logs and meshes.
Response front_page(Service& service, const Request& request);
/// GET /assets/{name}: what the viewer's page loads. @throws HttpProblem 404
Response viewer_asset(Service& service, const Request& request);
/// GET /healthz: the process answers.
Response healthz(const Request& request);
/// GET /metrics: what the server counts, in the Prometheus text format.
Response show_metrics(Service& service, const Request& request);
/// GET /readyz: the catalog answers and the disk has room. @throws HttpProblem 503 saying what is wrong
Response readyz(Service& service, const Request& request);
/// GET /openapi.yaml, /openapi.json: proto/openapi.yaml as it was built in.
Response openapi_yaml(const Request& request);
Response openapi_json(const Request& request);

}  // namespace anyrate
