#pragma once
#include "core/mesh/mesh_io.h"
#include "server/http/service.h"

namespace anyrate {

/// GET /v1/models/{id}/log: the stream so far, or with a budget exactly the prefix that answers it.
Response serve_log(Service& service, const Request& request);
/// The same without a wait, for a sealed log that is in memory; nullopt for any other.
std::optional<Response> serve_hot_log(Service& service, const Request& request);
/// GET /v1/models/{id}/index: the side index (FORMAT.md), or the same rows as JSON if the client prefers that.
Response serve_index(Service& service, const Request& request);
/// GET /v1/models/{id}/mesh.*: the mesh that the stream decodes to, at a budget.
Response serve_mesh(Service& service, const Request& request, MeshFormat format);
/// GET /v1/models/{id}/live: asks for the WebSocket.
Response serve_live(Service& service, const Request& request);

}  // namespace anyrate
