#include "server/http/capture_handlers.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "core/capture/relative_name.h"
#include "core/error.h"
#include "server/http/digest.h"
#include "server/http/model_json.h"
#include "server/http/multipart.h"
#include "server/http/problem.h"
#include "server/http/query.h"
#include "server/jobs/capture_verdict.h"
#include "server/store/mapped_file.h"
#include "server/store/model_id.h"
#include "server/store/zip_writer.h"

namespace anyrate {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t max_files = 2000;
constexpr std::size_t max_sentences = 20;
constexpr std::size_t max_path = 200;

Timestamp now() { return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

Response json_response(int status, const ordered_json& json) {
    return {.status = status,
            .headers = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}},
            .body = json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n"};
}

CaptureRecord expect_capture(Service& service, const std::string& id) {
    auto capture = service.captures.find(id);
    if (!capture) throw HttpProblem(404, "there is no capture " + id);
    return std::move(*capture);
}

CaptureVerdict verdict_of(Service& service, const CaptureRecord& capture) {
    std::optional<std::string> cameras;
    const bool has_cameras = std::any_of(capture.files.begin(), capture.files.end(), [](const CaptureFile& file) {
        return file.path == "cameras.json" && file.fault.empty();
    });
    if (has_cameras)
        service.captures.with_files(capture.id, [&](const std::filesystem::path& files) {
            cameras = std::string(as_text(read_file(files / "cameras.json")));
        });
    return judge_capture(capture, cameras);
}

ordered_json to_json(const CaptureFile& file) {
    ordered_json json = {
        {"path", file.path}, {"bytes", file.n_bytes}, {"sha256", file.sha256}, {"accepted", file.fault.empty()}};
    if (!file.fault.empty()) json["fault"] = file.fault;
    if (!file.kind.empty()) json["kind"] = file.kind;
    if (file.width > 0) {
        json["width"] = file.width;
        json["height"] = file.height;
    }
    return json;
}

ordered_json to_json(const CaptureRecord& capture, const CaptureVerdict& verdict) {
    const std::string self = "/v1/captures/" + capture.id;
    ordered_json json = {{"id", capture.id},
                         {"created", iso_time(capture.created)},
                         {"bytes", capture.n_bytes()},
                         {"complete", verdict.is_complete()},
                         {"files", ordered_json::array()},
                         {"missing", verdict.missing},
                         {"faults", ordered_json::array()},
                         {"links", {{"self", self}, {"files", self + "/files"}}}};
    for (const CaptureFile& file : capture.files) json["files"].push_back(to_json(file));
    for (const auto& [path, sentence] : verdict.refused)
        json["faults"].push_back({{"path", path}, {"fault", sentence}});
    return json;
}

/// One sentence a fault, the first twenty.
std::string sentences(const CaptureVerdict& verdict) {
    std::vector<std::string> all;
    for (const auto& [path, sentence] : verdict.refused) all.push_back(path + ": " + sentence);
    for (const std::string& path : verdict.missing) all.push_back(path + ": the file is missing");
    std::string text;
    for (std::size_t i = 0; i < std::min(all.size(), max_sentences); ++i) text += (i ? "; " : "") + all[i];
    if (all.size() > max_sentences) text += "; and " + std::to_string(all.size() - max_sentences) + " more";
    return text;
}

/// @throws HttpProblem 422 with every fault, file by file
void expect_complete(const CaptureVerdict& verdict) {
    if (verdict.is_complete()) return;
    HttpProblem problem(422, sentences(verdict));
    problem.faults = verdict.refused;
    for (const std::string& path : verdict.missing) problem.faults.emplace_back(path, "the file is missing");
    throw problem;
}

/// Equal keys are the same capture, also after a restart.
std::string id_of_key(std::string_view key) {
    const Sha256 digest = sha256(as_bytes("capture " + std::string(key)));
    constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz234567";
    std::string id;
    for (std::size_t i = 0; id.size() < 26; ++i) id += letters[digest[i] & 31];
    return id;
}

/// The path of a part: a browser gives the name of the file, or its path below the chosen folder.
std::string path_of(const FormPart& part) {
    const bool names_folder = part.name == "images" || part.name == "masks";
    const bool has_folder = part.filename.find('/') != std::string::npos;
    if (part.filename.empty()) return expect_capture_path(part.name);
    return expect_capture_path(names_folder && !has_folder ? part.name + "/" + part.filename : part.filename);
}

bool is_zip(const FormPart& part) {
    constexpr std::string_view local_file_header = "PK\x03\x04";
    return as_text(part.bytes).substr(0, local_file_header.size()) == local_file_header;
}

/// The files of a form, judged as if they had arrived one by one. @return what was found of them
std::vector<CaptureFile> write_zip_of_parts(const std::vector<FormPart>& parts, const std::filesystem::path& zip_file) {
    CaptureRecord capture;
    std::optional<std::string> cameras;
    std::set<std::string> paths;
    ZipWriter zip(zip_file);
    for (const FormPart& part : parts) {
        const std::string path = path_of(part);
        if (!paths.insert(path).second) throw HttpProblem(400, path + ": the form has two parts of that name");
        capture.files.push_back(inspect_capture_file(path, part.bytes));
        capture.files.back().sha256 = to_hex(sha256(part.bytes));
        if (path == "cameras.json" && capture.files.back().fault.empty()) cameras = std::string(as_text(part.bytes));
        zip.add(path, part.bytes);
    }
    std::sort(capture.files.begin(), capture.files.end(),
              [](const CaptureFile& a, const CaptureFile& b) { return a.path < b.path; });
    expect_complete(judge_capture(capture, cameras));
    zip.finish();
    return std::move(capture.files);
}

}  // namespace

std::string expect_capture_path(std::string_view path) {
    const auto name = relative_name(path);
    const auto slash = name ? name->find('/') : std::string::npos;
    const bool is_image = name && slash != std::string::npos && name->find('/', slash + 1) == std::string::npos &&
                          (name->substr(0, slash) == "images" || name->substr(0, slash) == "masks") &&
                          !name->ends_with(".json");
    const bool is_list = name && slash == std::string::npos && name->ends_with(".json");
    if (!name || name->size() > max_path || !(is_image || is_list))
        throw HttpProblem(400, "path \"" + std::string(path.substr(0, max_path)) +
                                   "\": expected images/NAME, masks/NAME or NAME.json, 200 bytes at most");
    return *name;
}

Response create_capture(Service& service, const Request& request) {
    expect_only(request, {});
    const std::string_view key = request.headers.find("Idempotency-Key").value_or("");
    if (key.size() > 255) throw HttpProblem(400, "the Idempotency-Key is longer than 255 bytes");
    const CaptureRecord capture = service.captures.create(key.empty() ? new_model_id() : id_of_key(key), now());
    Response response = json_response(201, to_json(capture, verdict_of(service, capture)));
    response.headers.add("Location", "/v1/captures/" + capture.id);
    return response;
}

Response list_captures(Service& service, const Request& request) {
    expect_only(request, {"limit", "after"});
    const auto limit = query_integer(request, "limit", 1, 1000).value_or(100);
    const auto after = request.query.find("after");
    if (after != request.query.end() && !is_model_id(after->second))
        throw HttpProblem(400, "after=" + after->second + ": expected the id of a capture");
    const CapturePage page =
        service.captures.list(static_cast<std::size_t>(limit), after == request.query.end() ? "" : after->second);
    ordered_json json = {{"captures", ordered_json::array()}};
    for (const CaptureRecord& capture : page.captures)
        json["captures"].push_back({{"id", capture.id},
                                    {"created", iso_time(capture.created)},
                                    {"bytes", capture.n_bytes()},
                                    {"n_files", capture.files.size()},
                                    {"links", {{"self", "/v1/captures/" + capture.id}}}});
    if (page.more) json["next"] = "/v1/captures?limit=" + std::to_string(limit) + "&after=" + page.captures.back().id;
    return json_response(200, json);
}

Response show_capture(Service& service, const Request& request) {
    expect_only(request, {});
    const CaptureRecord capture = expect_capture(service, request.captured.at("id"));
    return json_response(200, to_json(capture, verdict_of(service, capture)));
}

Response delete_capture(Service& service, const Request& request) {
    expect_only(request, {});
    const std::string& id = request.captured.at("id");
    if (!service.captures.remove(id)) throw HttpProblem(404, "there is no capture " + id);
    return {.status = 204, .headers = {}, .body = {}};
}

void check_put_capture_file(Service& service, const Request& request) {
    expect_only(request, {});
    expect_capture_path(request.captured.at("path"));
    digest_of_request(request);
    const CaptureRecord capture = expect_capture(service, request.captured.at("id"));
    if (capture.files.size() >= max_files)
        throw HttpProblem(413, "a capture may have " + std::to_string(max_files) + " files, and this one has them");
    if (capture.n_bytes() >= service.max_capture_bytes)
        throw HttpProblem(413, "a capture may have " + std::to_string(service.max_capture_bytes) + " bytes in all");
    if (service.store.free_bytes() < service.min_free_bytes)
        throw HttpProblem(507, "the server's disk is full; delete models or try again later");
}

Response put_capture_file(Service& service, const Request& request) {
    const std::string& id = request.captured.at("id");
    const std::string path = expect_capture_path(request.captured.at("path"));
    const Upload& upload = request.upload.value();
    CaptureFile file;
    Sha256 digest{};
    {
        const MappedFile body(upload.file);
        file = inspect_capture_file(path, body.bytes());
        digest = sha256(body.bytes());
    }
    file.sha256 = to_hex(digest);
    expect_digest(request, digest);
    const CaptureRecord before = expect_capture(service, id);
    if (before.n_bytes() + file.n_bytes > service.max_capture_bytes)
        throw HttpProblem(413, "a capture may have " + std::to_string(service.max_capture_bytes) + " bytes in all");
    const bool is_new = std::none_of(before.files.begin(), before.files.end(),
                                     [&](const CaptureFile& known) { return known.path == path; });
    if (!service.captures.put(id, file, upload.file)) throw HttpProblem(404, "there is no capture " + id);
    return json_response(is_new ? 201 : 200, to_json(file));
}

void expect_complete_capture(Service& service, const std::string& id) {
    expect_complete(verdict_of(service, expect_capture(service, id)));
}

std::string capture_files_json(const std::vector<CaptureFile>& files) {
    auto list = ordered_json::array();
    for (const CaptureFile& file : files) list.push_back(to_json(file));
    return list.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::vector<CaptureFile> judge_uploaded_zip(Service& service, const std::filesystem::path& zip) {
    if (!service.judge_zip) return {};
    JudgedCapture judged;
    try {
        judged = service.judge_zip(zip);
    } catch (const InputError& error) {
        throw HttpProblem(422, error.what());
    }
    expect_complete(judged.verdict);
    return std::move(judged.files);
}

std::vector<CaptureFile> zip_arrived_capture(Service& service, const std::string& id,
                                             const std::filesystem::path& zip_file) {
    const CaptureRecord capture = expect_capture(service, id);
    expect_complete(verdict_of(service, capture));
    ZipWriter zip(zip_file);
    const bool was_there = service.captures.with_files(id, [&](const std::filesystem::path& files) {
        for (const CaptureFile& file : capture.files) zip.add(file.path, MappedFile(files / file.path).bytes());
    });
    if (!was_there) throw HttpProblem(404, "there is no capture " + id);
    zip.finish();
    sync_file(open_if_exists(zip_file));
    return capture.files;
}

std::vector<CaptureFile> zip_form(Service& service, std::string_view content_type, const std::filesystem::path& file) {
    std::filesystem::path zip_file = file;
    zip_file += ".zip";
    try {
        std::vector<CaptureFile> files;
        const MappedFile body(file);
        const auto parts = parse_multipart(body.bytes(), multipart_boundary(content_type));
        if (parts.empty()) throw HttpProblem(400, "the form is empty: expected a zip of a capture, or its files");
        if (parts.size() == 1 && is_zip(parts[0])) {
            replace_file(zip_file, parts[0].bytes);
            files = judge_uploaded_zip(service, zip_file);
        } else {
            files = write_zip_of_parts(parts, zip_file);
        }
        sync_file(open_if_exists(zip_file));
        std::filesystem::rename(zip_file, file);
        return files;
    } catch (...) {
        std::error_code ignored;  // the next start removes it
        std::filesystem::remove(zip_file, ignored);
        throw;
    }
}

}  // namespace anyrate
