#include "server/client/push_capture.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/client/http_client.h"
#include "server/store/file.h"
#include "server/store/model_id.h"
#include "server/store/sha256.h"

namespace anyrate {
namespace {

using std::chrono::steady_clock;

constexpr int max_tries = 4;
constexpr std::chrono::seconds patience(60);  // a server judges what was sent before it answers

nlohmann::json parse_answer(const std::string& body) {
    auto json = nlohmann::json::parse(body, nullptr, false);
    if (!json.is_object()) throw IoError("the server's answer is no JSON object");
    return json;
}

/// Asks until the server answers. @throws IoError it did not in any of the tries
template <class Ask>
auto with_retries(const Ask& ask_server) {
    for (int n = 1;; ++n) {
        try {
            return ask_server();
        } catch (const UntrustedServer&) {
            throw;
        } catch (const IoError&) {
            if (n == max_tries) throw;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(250 << n));
    }
}

/// Sends a request and gives the answer's JSON. @throws InputError, IoError its status is none of 2xx
nlohmann::json exchange(HttpClient& client, const ClientRequest& request) {
    const ClientResponse response = client.open(request);
    if (response.status < 200 || response.status > 299) throw_problem(client, response);
    return parse_answer(client.read_text());
}

HttpClient client_of(const Url& server, const ServerAccess& access) {
    return HttpClient(server, {.access = access, .patience = patience});
}

std::string post_model(const Url& server, const ClientRequest& request, const ServerAccess& access) {
    return with_retries([&] {
        HttpClient client = client_of(server, access);
        const std::string id = exchange(client, request).value("id", "");
        if (!is_model_id(id)) throw IoError("the server's answer holds no model id");
        return id;
    });
}

struct LocalFile {
    std::filesystem::path file;
    std::string path;  ///< in the capture
    Sha256 digest{};
};

void add_files(std::vector<LocalFile>& files, const std::filesystem::path& folder, const std::string& prefix) {
    if (!std::filesystem::is_directory(folder)) return;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const bool is_wanted = !prefix.empty() || entry.path().extension() == ".json";
        if (entry.is_regular_file() && is_wanted)
            files.push_back({entry.path(), prefix + entry.path().filename().string(), sha256_of_file(entry.path())});
    }
}

/// What a capture consists of, by path.
std::vector<LocalFile> files_of_capture(const std::filesystem::path& folder) {
    std::vector<LocalFile> files;
    add_files(files, folder, "");
    add_files(files, folder / "images", "images/");
    add_files(files, folder / "masks", "masks/");
    std::sort(files.begin(), files.end(), [](const LocalFile& a, const LocalFile& b) { return a.path < b.path; });
    if (files.empty()) throw InputError(folder.string() + ": expected images/, masks/ and cameras.json, found none");
    return files;
}

/// Equal for equal captures, so that a second try finds what the first one brought.
std::string key_of(const std::vector<LocalFile>& files) {
    std::string list;
    for (const LocalFile& file : files) list += to_hex(file.digest) + " " + file.path + "\n";
    return to_hex(sha256(as_bytes(list)));
}

std::string percent_encoded(const std::string& path) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    std::string text;
    for (const char c : path) {
        const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                              std::string_view("-._~/").find(c) != std::string_view::npos;
        const auto byte = static_cast<unsigned char>(c);
        if (is_plain)
            text += c;
        else
            text += {'%', digits[byte >> 4], digits[byte & 15]};
    }
    return text;
}

/// The paths of a capture's listing that have arrived as they are here.
std::set<std::string> arrived_files(const nlohmann::json& listing, const std::vector<LocalFile>& files) {
    std::map<std::string, std::string> digests;
    for (const auto& file : listing.value("files", nlohmann::json::array()))
        digests[file.value("path", "")] = file.value("sha256", "");
    std::set<std::string> arrived;
    for (const LocalFile& file : files)
        if (const auto known = digests.find(file.path); known != digests.end() && known->second == to_hex(file.digest))
            arrived.insert(file.path);
    return arrived;
}

/// Brings every file that is not there yet. @return the id of the capture
std::string upload_files(const Url& server, const std::vector<LocalFile>& files, const ServerAccess& access) {
    HttpClient client = client_of(server, access);
    ClientRequest begin{.method = "POST", .target = "/v1/captures", .headers = {}, .body = {}};
    begin.headers.emplace_back("Idempotency-Key", key_of(files));
    const auto listing = with_retries([&] { return exchange(client, begin); });
    const std::string id = listing.value("id", "");
    if (!is_model_id(id)) throw IoError("the server's answer holds no id of a capture");
    const auto arrived = arrived_files(listing, files);
    for (const LocalFile& file : files) {
        if (arrived.contains(file.path)) continue;
        ClientRequest put{.method = "PUT",
                          .target = "/v1/captures/" + id + "/files/" + percent_encoded(file.path),
                          .headers = {},
                          .body = file.file};
        put.headers.emplace_back("Content-Digest", "sha-256=:" + to_base64(file.digest) + ":");
        with_retries([&] { return exchange(client, put); });
    }
    return id;
}

/// The model is made: its capture needs not be kept a second time.
void forget_capture(const Url& server, const std::string& id, const ServerAccess& access) {
    try {
        client_of(server, access).open({.method = "DELETE", .target = "/v1/captures/" + id, .headers = {}, .body = {}});
    } catch (const IoError&) {
        // The server removes it itself after some days.
    }
}

RemoteState ask(const Url& server, const std::string& id, const ServerAccess& access) {
    HttpClient client = client_of(server, access);
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
    const bool is_folder = std::filesystem::is_directory(capture);
    if (!is_folder && !std::filesystem::is_regular_file(capture))
        throw InputError(capture.string() + ": expected the folder or the zip of a capture");
    ClientRequest request{.method = "POST", .target = "/v1/models?", .headers = {}, .body = {}};
    request.headers.emplace_back("Idempotency-Key", new_model_id());
    if (options.n_vertices) request.target += "vertices=" + std::to_string(*options.n_vertices) + "&";
    if (!is_folder) {
        request.headers.emplace_back("Content-Type", "application/zip");
        request.body = capture;
        return post_model(server, request, options.access);
    }
    const std::string arrived = upload_files(server, files_of_capture(capture), options.access);
    request.target += "capture=" + arrived;
    const std::string id = post_model(server, request, options.access);
    forget_capture(server, arrived, options.access);
    return id;
}

RemoteState wait_for_model(const Url& server, const std::string& id, const ServerAccess& access,
                           const std::function<void(const RemoteState&)>& on_change) {
    auto last_answer = steady_clock::now();
    for (;;) {
        try {
            const RemoteState state = ask(server, id, access);
            last_answer = steady_clock::now();
            on_change(state);
            if (state.state != "queued" && state.state != "running") return state;
        } catch (const UntrustedServer&) {
            throw;
        } catch (const IoError&) {
            if (steady_clock::now() - last_answer > std::chrono::minutes(1)) throw;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
}

}  // namespace anyrate
