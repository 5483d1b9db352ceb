#include "server/http/model_handlers.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/http/capture_handlers.h"
#include "server/http/digest.h"
#include "server/http/model_json.h"
#include "server/http/multipart.h"
#include "server/http/problem.h"
#include "server/http/query.h"
#include "server/store/model_id.h"
#include "server/store/sha256.h"

namespace anyrate {
namespace {

constexpr std::size_t max_key = 255;

Timestamp now() { return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

Response json_response(int status, std::string json) {
    return {.status = status,
            .headers = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}},
            .body = std::move(json)};
}

ModelOptions query_options(const Request& request) {
    expect_only(request, {"vertices", "coarse", "capture"});
    ModelOptions options;
    options.n_vertices = static_cast<int>(
        query_integer(request, "vertices", 100, 1'000'000).value_or(static_cast<std::uint64_t>(options.n_vertices)));
    const int default_coarse = std::min(options.n_coarse, options.n_vertices);
    options.n_coarse = static_cast<int>(
        query_integer(request, "coarse", 100, 1'000'000).value_or(static_cast<std::uint64_t>(default_coarse)));
    if (options.n_coarse > options.n_vertices)
        throw HttpProblem(400, "coarse=" + std::to_string(options.n_coarse) +
                                   ": expected at most vertices=" + std::to_string(options.n_vertices));
    return options;
}

std::string idempotency_key(const Request& request) {
    const std::string key(request.headers.find("Idempotency-Key").value_or(""));
    if (key.size() > max_key) throw HttpProblem(400, "the Idempotency-Key is longer than 255 bytes");
    return key;
}

std::optional<std::string> query_capture(const Request& request) {
    const auto id = request.query.find("capture");
    return id == request.query.end() ? std::nullopt : std::optional(id->second);
}

/// The media type without its parameters.
std::string_view media_type(const Request& request) {
    const std::string_view field = request.headers.find("Content-Type").value_or("");
    const std::string_view type = field.substr(0, field.find(';'));
    return type.substr(0, type.find_last_not_of(" \t") + 1);
}

void expect_zip(const Upload& upload) {
    constexpr std::string_view local_file_header = "PK\x03\x04";
    const auto start = read_at(open_if_exists(upload.file), 0, local_file_header.size());
    if (upload.n_bytes == 0) throw HttpProblem(400, "the body is empty: expected a zip of a capture");
    if (as_text(start) != local_file_header)
        throw HttpProblem(400, "the body is no zip file: it does not begin with the bytes 50 4B 03 04");
}

/// What must be equal for a repeated key to mean the same request: options and capture, byte for byte. The zip of a
/// form is made of its parts alone, so a boundary that a client makes up anew changes nothing.
std::string fingerprint(const Request& request, const ModelOptions& options) {
    return "vertices=" + std::to_string(options.n_vertices) + "&coarse=" + std::to_string(options.n_coarse) +
           "&sha256=" + to_hex(sha256_of_file(request.upload->file));
}

/// Puts the capture of a request, as a zip, in the place of its body: what arrived file by file, or the parts of a
/// form. @return what was found of each of its files @throws HttpProblem 400, 404, 422
std::vector<CaptureFile> take_capture(Service& service, const Request& request) {
    const Upload& upload = request.upload.value();
    if (digest_of_request(request)) expect_digest(request, sha256_of_file(upload.file));
    if (const auto capture = query_capture(request)) {
        if (upload.n_bytes > 0) throw HttpProblem(400, "a model of capture=" + *capture + " takes no body");
        return zip_arrived_capture(service, *capture, upload.file);
    }
    if (media_type(request) == "multipart/form-data")
        return zip_form(service, *request.headers.find("Content-Type"), upload.file);
    expect_zip(upload);
    return judge_uploaded_zip(service, upload.file);
}

/// What `after=` says: the id of a model, or its number, which `next` has, for the model may be gone when the next page
/// is asked for. @throws HttpProblem 400, 404
std::uint64_t query_number_before(Service& service, const Request& request) {
    const auto after = request.query.find("after");
    if (after == request.query.end()) return Catalog::from_newest;
    if (after->second.find_first_not_of("0123456789") == std::string::npos)
        return query_integer(request, "after", 1, Catalog::from_newest).value();
    if (!is_model_id(after->second))
        throw HttpProblem(400, "after=" + after->second + ": expected what `next` of a page has, or the id of a model");
    if (const auto model = service.catalog.find(after->second)) return model->number;
    throw HttpProblem(404,
                      "there is no model " + after->second + " any more to go on behind: begin with the first page");
}

Response accepted(Service& service, const std::string& id, const std::vector<CaptureFile>& files) {
    const auto model = service.catalog.find(id);
    if (!model) throw HttpProblem(404, "the model of this Idempotency-Key was deleted");
    Response response = json_response(202, new_model_json(*model, capture_files_json(files)));
    response.headers.add("Location", "/v1/models/" + id);
    return response;
}

}  // namespace

void check_create_model(Service& service, const Request& request) {
    query_options(request);
    idempotency_key(request);
    digest_of_request(request);
    if (const auto capture = query_capture(request)) {
        expect_complete_capture(service, *capture);
    } else if (const auto type = media_type(request);
               type != "application/zip" && type != "application/octet-stream" && type != "multipart/form-data") {
        throw HttpProblem(
            415, "Content-Type \"" + std::string(type) + "\": expected application/zip or multipart/form-data");
    }
    if (media_type(request) == "multipart/form-data") multipart_boundary(*request.headers.find("Content-Type"));
    if (service.store.free_bytes() < service.min_free_bytes)
        throw HttpProblem(507, "the server's disk is full; delete models or try again later");
}

Response create_model(Service& service, const Request& request) {
    const ModelOptions options = query_options(request);
    const std::vector<CaptureFile> files = take_capture(service, request);
    const std::string key = idempotency_key(request);
    const std::string meaning = key.empty() ? "" : fingerprint(request, options);
    const std::string id = new_model_id();
    // The capture is in place before the catalog knows of it: a crash in between leaves a folder that the next start
    // removes, never a model without its capture.
    service.store.adopt_upload(request.upload->file, id);
    const Added added = service.catalog.add(
        {.id = id, .options = options, .idempotency_key = key, .request_fingerprint = meaning}, now());
    if (added.kind != Added::Kind::made) service.store.remove(id);
    if (added.kind == Added::Kind::key_reused)
        throw HttpProblem(422, "this Idempotency-Key was used for another request");
    service.on_queued();
    return accepted(service, added.id, files);
}

Response list_models(Service& service, const Request& request) {
    expect_only(request, {"limit", "after"});
    const auto limit = static_cast<std::size_t>(query_integer(request, "limit", 1, 1000).value_or(100));
    const std::uint64_t before = query_number_before(service, request);
    return json_response(200, model_list_json(service.catalog.list(limit, before), limit));
}

Response show_model(Service& service, const Request& request) {
    expect_only(request, {});
    const ModelRecord model = expect_model(service, request);
    return json_response(200, model_json(model, service.catalog.curve(model.id)));
}

Response cancel_model(Service& service, const Request& request) {
    expect_only(request, {});
    const ModelRecord model = expect_model(service, request);
    if (!service.catalog.cancel(model.id, now()))
        throw HttpProblem(409, "model " + model.id + " cannot be cancelled: it is " +
                                   state_name(expect_model(service, request).state));
    service.on_removed(model.id);
    return json_response(200, model_json(expect_model(service, request)));
}

Response delete_model(Service& service, const Request& request) {
    expect_only(request, {});
    const ModelRecord model = expect_model(service, request);
    service.catalog.remove(model.id);
    service.on_removed(model.id);
    service.store.remove(model.id);
    return {.status = 204, .headers = {}, .body = {}};
}

Response watch_model(Service& service, const Request& request) {
    expect_only(request, {});
    return {.headers = {{"Content-Type", "text/event-stream"}, {"Cache-Control", "no-store"}},
            .body = EventsBody{expect_model(service, request).id}};
}

ModelRecord expect_model(Service& service, const Request& request) {
    const std::string& id = request.captured.at("id");
    auto model = is_model_id(id) ? service.catalog.find(id) : std::nullopt;
    if (!model) throw HttpProblem(404, "there is no model " + id);
    return std::move(*model);
}

}  // namespace anyrate
