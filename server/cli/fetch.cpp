#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "server/cli/access_options.h"
#include "server/cli/budget_options.h"
#include "server/cli/commands.h"
#include "server/cli/number_check.h"
#include "server/cli/output_name.h"
#include "server/client/fetch_log.h"
#include "server/client/live_client.h"
#include "server/client/log_target.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

struct FetchCommand {
    std::string url;
    std::filesystem::path output;
    BudgetOptions budget;
    bool live = false;
    std::optional<std::filesystem::path> trace;
    std::uint64_t bytes_per_second = 0;
    int latency_ms = 0;
    AccessOptions access;

    LinkOptions link() const {
        return {.bytes_per_second = bytes_per_second, .latency = std::chrono::milliseconds(latency_ms)};
    }
};

bool has_budget(const BudgetOptions& budget) { return budget.n_vertices || budget.n_bytes || budget.distortion; }

FetchedLog fetch_once(const FetchCommand& request, HttpClient& client, const Url& url, ArrivalTrace& trace) {
    const auto budget = has_budget(request.budget) ? std::optional(request.budget.budget()) : std::nullopt;
    return fetch_log(client, url.target, budget, trace);
}

/// The log as it grew, with the rows of the server's index (a live log has none of its own).
FetchedLog fetch_live(const FetchCommand& request, HttpClient& client, const Url& url, const ServerAccess& access,
                      ArrivalTrace& trace) {
    if (request.budget.n_bytes || request.budget.distortion)
        throw InputError("--live takes --vertices, no other budget: sizes and distortions are not known ahead");
    LiveOptions options{.access = access, .link = request.link()};
    if (request.budget.n_vertices) options.max_vertices = *request.budget.n_vertices;
    FetchedLog fetched{.bytes = follow_live(url, url.target, options, trace), .rows = {}, .frames_begin = 0};
    const LogLayout layout = read_layout(fetched.bytes);
    fetched.frames_begin = layout.frames_begin;
    const auto index = fetch_index(client, index_target(log_target(url.target)));
    fetched.rows = index && index->log_id == layout.header.log_id ? index->rows : layout.index;
    return fetched;
}

void write_log(const FetchCommand& request, const FetchedLog& fetched) {
    // A followed log is sealed as the server's own is: the same bytes if it is whole.
    replace_file(request.output, request.live ? seal_log(fetched.bytes, fetched.rows) : fetched.bytes);
    std::fprintf(stderr, "%s: %zu bytes\n", request.output.c_str(), fetched.bytes.size());
}

void write_decoded(const FetchCommand& request, const FetchedLog& fetched) {
    const Mesh mesh = decode_mesh(fetched.bytes, request.budget.budget());
    write_mesh(mesh, request.output);
    std::fprintf(stderr, "%s: %d vertices, %d faces from %zu bytes\n", request.output.c_str(), mesh.n_vertices(),
                 mesh.n_faces(), fetched.bytes.size());
}

int fetch(const FetchCommand& request) {
    const Url url = parse_url(request.url);
    const ServerAccess access = request.access.access();
    HttpClient client(url, {.access = access, .link = request.link()});
    ArrivalTrace trace;
    const FetchedLog fetched =
        request.live ? fetch_live(request, client, url, access, trace) : fetch_once(request, client, url, trace);
    if (request.output.extension() == ".arl")
        write_log(request, fetched);
    else
        write_decoded(request, fetched);
    if (request.trace) replace_file(*request.trace, as_bytes(trace.to_json(fetched.rows, fetched.frames_begin)));
    return 0;
}

std::string check_output(const std::string& name) {
    if (std::filesystem::path(name).extension() == ".arl") return {};
    return mesh_file_name()(name);
}

}  // namespace

void add_fetch(CLI::App& app, Command& command) {
    auto request = std::make_shared<FetchCommand>();
    CLI::App* sub =
        app.add_subcommand("fetch", "get a model from a server at a budget, with as few bytes as that needs");
    sub->add_option("URL", request->url, "of a model (http(s)://host:port/v1/models/ID) or of an .arl file")
        ->required();
    sub->add_option("-o,--output", request->output, "mesh file (.ply, .obj, .glb) or model (.arl) to write")
        ->required()
        ->check(CLI::Validator(check_output, "FILE.(ply|obj|glb|arl)"));
    request->budget.add_to(*sub);
    sub->add_flag("--live", request->live, "follow a model while it is made (WebSocket)");
    sub->add_option("--trace", request->trace, "write when each frame arrived as JSON");
    sub->add_option("--throttle", request->bytes_per_second, "read as if over a line of so many bytes a second")
        ->check(above_zero());
    sub->add_option("--latency", request->latency_ms, "and with so many milliseconds one way")
        ->check(CLI::Range(0, 60'000));
    request->access.add_to(*sub);
    sub->callback([request, &command] { command = [request] { return fetch(*request); }; });
}

}  // namespace anyrate
