#include "server/http/service.h"

#include <exception>
#include <utility>

#include "server/http/capture_handlers.h"
#include "server/http/log_handlers.h"
#include "server/http/model_handlers.h"
#include "server/http/pages.h"
#include "server/http/photograph_handlers.h"
#include "server/http/problem.h"

namespace anyrate {

Router make_router(Service& service) {
    const auto with_service = [&service](Response (*handler)(Service&, const Request&)) {
        return [&service, handler](const Request& request) { return handler(service, request); };
    };
    const auto mesh = [&service](MeshFormat format) {
        return [&service, format](const Request& request) { return serve_mesh(service, request, format); };
    };
    return Router({
        {"GET", "/", with_service(front_page)},
        {"GET", "/models/{id}", with_service(front_page)},
        {"GET", "/assets/{name}", with_service(viewer_asset)},
        {"GET", "/healthz", healthz},
        {"GET", "/readyz", with_service(readyz)},
        {"GET", "/metrics", with_service(show_metrics)},
        {"GET", "/openapi.yaml", openapi_yaml},
        {"GET", "/openapi.json", openapi_json},
        {.method = "POST",
         .pattern = "/v1/models",
         .handle = with_service(create_model),
         .takes_upload = true,
         .check = [&service](const Request& request) { check_create_model(service, request); }},
        {"POST", "/v1/captures", with_service(create_capture)},
        {"GET", "/v1/captures", with_service(list_captures)},
        {"GET", "/v1/captures/{id}", with_service(show_capture)},
        {"DELETE", "/v1/captures/{id}", with_service(delete_capture)},
        {.method = "PUT",
         .pattern = "/v1/captures/{id}/files/{path...}",
         .handle = with_service(put_capture_file),
         .takes_upload = true,
         .check = [&service](const Request& request) { check_put_capture_file(service, request); }},
        {"GET", "/v1/models", with_service(list_models)},
        {"GET", "/v1/models/{id}", with_service(show_model)},
        {"POST", "/v1/models/{id}/cancel", with_service(cancel_model)},
        {"DELETE", "/v1/models/{id}", with_service(delete_model)},
        {.method = "GET",
         .pattern = "/v1/models/{id}/log",
         .handle = with_service(serve_log),
         .answer_at_once = [&service](const Request& request) { return serve_hot_log(service, request); }},
        {"GET", "/v1/models/{id}/index", with_service(serve_index)},
        {"GET", "/v1/models/{id}/live", with_service(serve_live)},
        {"GET", "/v1/models/{id}/events", with_service(watch_model)},
        {.method = "GET", .pattern = "/v1/models/{id}/cameras", .handle = with_service(show_cameras), .is_heavy = true},
        {.method = "GET",
         .pattern = "/v1/models/{id}/photographs/{number}",
         .handle = with_service(show_photograph),
         .is_heavy = true},
        {.method = "GET",
         .pattern = "/v1/models/{id}/thumbnails/{number}",
         .handle = with_service(show_thumbnail),
         .is_heavy = true},
        {.method = "GET", .pattern = "/v1/models/{id}/mesh.ply", .handle = mesh(MeshFormat::ply), .is_heavy = true},
        {.method = "GET", .pattern = "/v1/models/{id}/mesh.obj", .handle = mesh(MeshFormat::obj), .is_heavy = true},
        {.method = "GET", .pattern = "/v1/models/{id}/mesh.glb", .handle = mesh(MeshFormat::glb), .is_heavy = true},
    });
}

Response answer(const Router& router, Request request) {
    try {
        const Route& route = router.find(request);
        if (route.check) route.check(request);
        return route.handle(request);
    } catch (...) {
        return problem_response(to_problem(std::current_exception()));
    }
}

}  // namespace anyrate
