#include "server/http/log_handlers.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "proto/log_reader.h"
#include "server/http/file_response.h"
#include "server/http/model_handlers.h"
#include "server/http/problem.h"
#include "server/http/query.h"
#include "server/http/range.h"

namespace anyrate {
namespace {

std::string hex(std::uint64_t number) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(number));
    return text;
}

/// A log grows and is sealed, but its first n bytes in one form never change: log id, form and length name the bytes.
std::string etag_of(const LogView& log, std::uint64_t n_bytes, const char* suffix) {
    std::string etag = "\"";
    etag += hex(log.log_id) + (log.sealed ? "-s" : "-l") + std::to_string(n_bytes) + suffix + "\"";
    return etag;
}

/// Whether a tag is that of a live log's first bytes: etag_of() with a length that it has outgrown.
bool is_tag_of_prefix(const LogView& log, std::string_view tag) {
    const std::string none = etag_of(log, 0, "");  // "...-l0"
    const std::string_view stem = std::string_view(none).substr(0, none.size() - 2);
    if (log.sealed || tag.size() < stem.size() + 2 || tag.substr(0, stem.size()) != stem || tag.back() != '"')
        return false;
    const std::string_view digits = tag.substr(stem.size(), tag.size() - stem.size() - 1);
    std::uint64_t n_bytes = 0;
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), n_bytes);
    return end.ec == std::errc() && end.ptr == digits.data() + digits.size() && n_bytes <= log.size;
}

LogView expect_log(Service& service, const Request& request, bool is_live_form = false) {
    const ModelRecord model = expect_model(service, request);
    auto log = is_live_form ? service.store.open_live_log(model.id) : service.store.open_log(model.id);
    const bool has_failed = is_final(model.state) && model.state != ModelState::done;
    // Before the first point of its curve a model has but a preview, which is nothing to keep.
    const bool is_left_preview = has_failed && service.catalog.curve(model.id).empty();
    if (log && !is_left_preview) return std::move(*log);
    if (is_final(model.state))
        throw HttpProblem(404, "model " + model.id + " has no log: it is " + state_name(model.state) +
                                   (model.error.empty() ? "" : ": " + model.error));
    throw HttpProblem(404, "model " + model.id + " has no log yet: it is " + state_name(model.state),
                      {{"Retry-After", "1"}});
}

std::uint64_t prefix_bytes(const LogView& log, const std::optional<Budget>& budget) {
    return budget ? prefix_end(log.rows, *budget, log.frames_begin) : log.size;
}

/// ?form=live asks for what live clients follow, which a sealed model has beside its sealed form.
bool wants_live_form(const Request& request) {
    const auto form = request.query.find("form");
    if (form == request.query.end()) return false;
    if (form->second != "live") throw HttpProblem(400, "form: expected live, got \"" + form->second + "\"");
    return true;
}

bool prefers_json(const Request& request) {
    return request.headers.find("Accept").value_or("").find("application/json") != std::string_view::npos;
}

nlohmann::ordered_json number_or_null(float value) {
    return std::isnan(value) ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
}

std::string index_json(const LogView& log) {
    nlohmann::ordered_json json = {{"log_id", hex(log.log_id)},
                                   {"sealed", log.sealed},
                                   {"frames_begin", log.frames_begin},
                                   {"bytes", log.size},
                                   {"rows", nlohmann::ordered_json::array()}};
    for (const IndexRow& row : log.rows)
        json["rows"].push_back({{"vertices", row.n_vertices},
                                {"end", row.end},
                                {"mean_distortion", number_or_null(row.mean_distortion)},
                                {"max_distortion", number_or_null(row.max_distortion)}});
    return json.dump() + "\n";
}

/// 304 if the client has these bytes already, else 200 with a body that is made now.
template <class MakeBody>
Response made_response(const Request& request, const LogView& log, const std::string& etag, const char* content_type,
                       const MakeBody& make_body) {
    Response response;
    response.headers = {{"ETag", etag}, {"Cache-Control", cache_control(log.sealed)}, {"Vary", "Accept"}};
    if (const auto known = request.headers.find("If-None-Match"); known && matches_etag(*known, etag)) {
        response.status = 304;
        return response;
    }
    response.headers.add("Content-Type", content_type);
    response.body = make_body();
    return response;
}

/// The prefix of a log that answers the request's budget. @param memory  the log's bytes if they are in memory
Response prefix_response(const Request& request, const LogView& log,
                         std::shared_ptr<const std::vector<std::byte>> memory) {
    const std::uint64_t n_bytes = prefix_bytes(log, query_budget(request));
    Representation prefix;
    prefix.bytes = FileBody{log.file, 0, n_bytes, std::move(memory)};
    prefix.content_type = "model/vnd.anyrate";
    prefix.etag = etag_of(log, n_bytes, "");
    prefix.is_immutable = log.sealed;
    prefix.is_tag_of_prefix = [&log](std::string_view tag) { return is_tag_of_prefix(log, tag); };
    return file_response(request, prefix);
}

const char* content_type_of(MeshFormat format) {
    switch (format) {
        case MeshFormat::ply:
            return "application/octet-stream";
        case MeshFormat::obj:
            return "model/obj";
        case MeshFormat::glb:
            return "model/gltf-binary";
    }
    return "application/octet-stream";
}

const char* suffix_of(MeshFormat format) {
    switch (format) {
        case MeshFormat::ply:
            return "-ply";
        case MeshFormat::obj:
            return "-obj";
        case MeshFormat::glb:
            return "-glb";
    }
    return "";
}

}  // namespace

Response serve_log(Service& service, const Request& request) {
    expect_only(request, {"vertices", "bytes", "distortion"});
    const std::uint64_t generation = service.hot_logs.generation();
    LogView log = expect_log(service, request);
    if (!log.sealed) return prefix_response(request, log, nullptr);
    std::string etag = etag_of(log, log.size, "");
    const auto hot = service.hot_logs.keep(request.captured.at("id"), std::move(log), std::move(etag), generation);
    return prefix_response(request, hot->view, hot->bytes);
}

std::optional<Response> serve_hot_log(Service& service, const Request& request) {
    expect_only(request, {"vertices", "bytes", "distortion"});
    const auto hot = service.hot_logs.find(request.captured.at("id"));
    if (!hot) return std::nullopt;
    return prefix_response(request, hot->view, hot->bytes);
}

Response serve_index(Service& service, const Request& request) {
    expect_only(request, {"form"});
    const LogView log = expect_log(service, request, wants_live_form(request));
    if (prefers_json(request))
        return made_response(request, log, etag_of(log, log.size, "-json"), "application/json",
                             [&] { return index_json(log); });
    return made_response(request, log, etag_of(log, log.size, "-idx"), "application/octet-stream",
                         [&] { return std::string(as_text(encode_index(log.log_id, log.rows))); });
}

Response serve_mesh(Service& service, const Request& request, MeshFormat format) {
    expect_only(request, {"vertices", "bytes", "distortion"});
    const auto budget = query_budget(request);
    const LogView log = expect_log(service, request);
    const std::uint64_t n_bytes = prefix_bytes(log, budget);
    // Two vertex budgets inside one packet need the same bytes and give different meshes.
    const auto* vertices = budget ? std::get_if<VertexBudget>(&*budget) : nullptr;
    const std::string suffix = suffix_of(format) + (vertices ? "-v" + std::to_string(vertices->n_vertices) : "");
    return made_response(request, log, etag_of(log, n_bytes, suffix.c_str()), content_type_of(format), [&] {
        const auto prefix = read_at(*log.file, 0, static_cast<std::size_t>(n_bytes));
        const Mesh mesh = decode_mesh(prefix, budget.value_or(VertexBudget{UINT32_MAX}));
        return std::string(as_text(encode_mesh_file(mesh, format)));
    });
}

Response serve_live(Service& service, const Request& request) {
    expect_only(request, {"vertices", "from"});
    LiveBody live;
    live.max_vertices =
        static_cast<std::uint32_t>(query_integer(request, "vertices", 1, UINT32_MAX).value_or(live.max_vertices));
    live.from = static_cast<std::uint32_t>(query_integer(request, "from", 0, UINT32_MAX).value_or(0));
    live.model_id = expect_model(service, request).id;
    return {.status = 101, .headers = {}, .body = live};
}

}  // namespace anyrate
