#include "server/http/photograph_handlers.h"

#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/capture/cameras_json.h"
#include "core/capture/capture_files.h"
#include "core/capture/faults.h"
#include "core/capture/image_header.h"
#include "core/capture/zip_archive.h"
#include "core/error.h"
#include "server/http/file_response.h"
#include "server/http/model_handlers.h"
#include "server/http/problem.h"
#include "server/http/query.h"
#include "server/jobs/thumbnails.h"

namespace anyrate {
namespace {

constexpr const char* cameras_file = "cameras.json";

/// A model's capture as it lies in its zip, of which no more is unpacked than is asked for.
struct OpenCapture {
    std::filesystem::path zip;
    std::string top;  ///< the folder that the capture lies in: "" or "folder/"
    CameraList cameras;
};

std::vector<std::string> names_in(const std::filesystem::path& zip) {
    std::vector<std::string> names;
    visit_zip(zip, zip.filename().string(), {}, {}, [&](const std::string& name) {
        names.push_back(name);
        return false;
    });
    return names;
}

/// @return nullopt if the zip has no such file @throws InputError it cannot be unpacked
std::optional<std::vector<std::uint8_t>> read_member(const std::filesystem::path& zip, const std::string& file) {
    std::optional<std::vector<std::uint8_t>> bytes;
    visit_zip(
        zip, zip.filename().string(), {},
        [&](const std::string&, std::vector<std::uint8_t> data) { bytes = std::move(data); },
        [&](const std::string& name) { return name == file; });
    return bytes;
}

/// @throws HttpProblem 404 also if it cannot be unpacked
std::vector<std::uint8_t> expect_member(const std::filesystem::path& zip, const std::string& file) {
    try {
        if (auto bytes = read_member(zip, file)) return std::move(*bytes);
    } catch (const InputError& error) {
        throw HttpProblem(404, error.what());
    }
    throw HttpProblem(404, zip.filename().string() + " has no file " + file);
}

/// The number of the photograph that the request names. @throws HttpProblem 404
std::size_t expect_number(const Request& request) {
    const std::string& text = request.captured.at("number");
    std::size_t number = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size())
        throw HttpProblem(404, "photograph \"" + text + "\": expected a number from 0");
    return number;
}

Response picture(ImageKind kind, const std::vector<std::uint8_t>& bytes) {
    return {.headers = {{"Content-Type", kind == ImageKind::png ? "image/png" : "image/jpeg"},
                        {"Cache-Control", cache_control(true)},
                        {"Content-Security-Policy", "default-src 'none'"}},
            .body = std::string(bytes.begin(), bytes.end())};
}

/// The capture of the model that the request names. @throws HttpProblem 404 also for one that is no sound capture
OpenCapture open_capture(Service& service, const Request& request) {
    const ModelRecord model = expect_model(service, request);
    try {
        OpenCapture capture{service.store.paths(model.id).capture, {}, {}};
        if (!std::filesystem::is_regular_file(capture.zip)) throw InputError("its capture is not here");
        capture.top = top_folder(names_in(capture.zip), capture.zip.filename().string(), cameras_file);
        const auto json = read_member(capture.zip, capture.top + cameras_file);
        if (!json || json->size() > max_cameras_bytes)
            throw InputError(std::string(cameras_file) + " is missing or too large");
        Faults faults;
        capture.cameras =
            parse_cameras({reinterpret_cast<const char*>(json->data()), json->size()}, cameras_file, faults);
        return capture;
    } catch (const InputError& error) {
        throw HttpProblem(404, "model " + model.id + " has no photographs to show: " + error.what());
    }
}

nlohmann::ordered_json matrix(const std::optional<Mat3>& value) {
    auto rows = nlohmann::ordered_json::array();
    for (int row = 0; row < 3; ++row) rows.push_back({(*value)(row, 0), (*value)(row, 1), (*value)(row, 2)});
    return rows;
}

/// @param model  its address @param number  of the photograph
nlohmann::ordered_json camera_json(const CameraEntry& entry, const std::string& model, std::size_t number) {
    nlohmann::ordered_json json = {{"name", entry.file},
                                   {"photograph", model + "/photographs/" + std::to_string(number)},
                                   {"thumbnail", model + "/thumbnails/" + std::to_string(number)}};
    json["width"] = entry.width ? nlohmann::ordered_json(*entry.width) : nullptr;
    json["height"] = entry.height ? nlohmann::ordered_json(*entry.height) : nullptr;
    json["K"] = matrix(entry.K);
    json["R"] = matrix(entry.R);
    json["t"] = {(*entry.t)(0), (*entry.t)(1), (*entry.t)(2)};
    return json;
}

}  // namespace

Response show_cameras(Service& service, const Request& request) {
    expect_only(request, {});
    const OpenCapture capture = open_capture(service, request);
    const Vec2& centre = capture.cameras.pixel_center;
    nlohmann::ordered_json json = {{"pixel_center", {centre(0), centre(1)}},
                                   {"cameras", nlohmann::ordered_json::array()}};
    const std::string model = "/v1/models/" + request.captured.at("id");
    for (std::size_t i = 0; i < capture.cameras.entries.size(); ++i) {
        const CameraEntry& entry = capture.cameras.entries[i];
        if (!entry.is_well_formed || !entry.K || !entry.R || !entry.t) continue;
        json["cameras"].push_back(camera_json(entry, model, i));
    }
    return {.headers = {{"Content-Type", "application/json"}, {"Cache-Control", cache_control(true)}},
            .body = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"};
}

Response show_photograph(Service& service, const Request& request) {
    expect_only(request, {});
    const std::size_t number = expect_number(request);
    const OpenCapture capture = open_capture(service, request);
    const auto& entries = capture.cameras.entries;
    if (number >= entries.size())
        throw HttpProblem(404, "photograph " + std::to_string(number) + " of only " + std::to_string(entries.size()));
    const std::vector<std::uint8_t> bytes = expect_member(capture.zip, capture.top + entries[number].file);
    const auto header = read_image_header(bytes);
    if (!header) throw HttpProblem(404, entries[number].file + " is neither PNG nor JPEG");
    return picture(header->kind, bytes);
}

Response show_thumbnail(Service& service, const Request& request) {
    expect_only(request, {});
    const ModelRecord model = expect_model(service, request);
    const std::string name = thumbnail_name(expect_number(request));
    const std::filesystem::path zip = service.store.paths(model.id).thumbnails;
    if (!std::filesystem::is_regular_file(zip))
        throw HttpProblem(404, "model " + model.id + " has no thumbnails: its photographs have not been loaded yet");
    return picture(ImageKind::jpeg, expect_member(zip, name));
}

}  // namespace anyrate
