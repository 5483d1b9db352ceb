#include "server/client/push_capture.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/error.h"
#include "server/client/http_client.h"
#include "server/client/zip_folder.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

using std::chrono::steady_clock;

constexpr int max_tries = 4;

nlohmann::json parse_answer(const std::string& body) {
    auto json = nlohmann::json::parse(body, nullptr, false);
    if (!json.is_object()) throw IoError("the server's answer is no JSON object");
    return json;
}

std::string post(const Url& server, const ClientRequest& request) {
    HttpClient client(server);
    const ClientResponse response = client.open(request);
    if (response.status != 202) throw_problem(client, response);
    const std::string id = parse_answer(client.read_text()).value("id", "");
    if (!is_model_id(id)) throw IoError("the server's answer holds no model id");
    return id;
}

std::string post_with_retries(const Url& server, const ClientRequest& request) {
    for (int n = 1;; ++n) {
        try {
            return post(server, request);
        } catch (const IoError&) {
            if (n == max_tries) throw;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(250 << n));
    }
}

RemoteState ask(const Url& server, const std::string& id) {
    HttpClient client(server);
    const ClientResponse response = client.open({.target = "/v1/models/" + id, .headers = {}, .body = {}});
    if (response.status != 200) throw_problem(client, response);
    const auto json = parse_answer(client.read_text());
    return {.state = json.value("state", ""),
            .stage = json.value("stage", ""),
            .error = json.value("error", ""),
            .fraction = json.value("fraction", 0.0),
            .n_vertices = json.value("vertices", std::uint64_t{0}),
            .n_bytes = json.value("bytes", std::uint64_t{0})};
}

}  // namespace

std::string push_capture(const Url& server, const std::filesystem::path& capture, const PushOptions& options) {
    std::optional<TemporaryZip> zip;
    if (std::filesystem::is_directory(capture))
        zip.emplace(zip_capture(capture));
    else if (!std::filesystem::is_regular_file(capture))
        throw InputError(capture.string() + ": expected the folder or the zip of a capture");
    ClientRequest request{.method = "POST", .target = "/v1/models", .headers = {}, .body = zip ? zip->path() : capture};
    if (options.n_vertices) request.target += "?vertices=" + std::to_string(*options.n_vertices);
    request.headers = {{"Content-Type", "application/zip"}, {"Idempotency-Key", new_model_id()}};
    if (!options.token.empty()) request.headers.emplace_back("Authorization", "Bearer " + options.token);
    return post_with_retries(server, request);
}

RemoteState wait_for_model(const Url& server, const std::string& id,
                           const std::function<void(const RemoteState&)>& on_change) {
    auto last_answer = steady_clock::now();
    for (;;) {
        try {
            const RemoteState state = ask(server, id);
            last_answer = steady_clock::now();
            on_change(state);
            if (state.state != "queued" && state.state != "running") return state;
        } catch (const IoError&) {
            if (steady_clock::now() - last_answer > std::chrono::minutes(1)) throw;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
}

}  // namespace anyrate
