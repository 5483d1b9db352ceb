#include "server/http/capture_verdict.h"

#include <algorithm>
#include <set>

#include "core/capture/cameras_json.h"
#include "core/capture/faults.h"
#include "core/capture/image_header.h"
#include "core/capture/load_capture.h"
#include "core/capture/relative_name.h"
#include "core/error.h"
#include "server/http/problem.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

constexpr std::size_t max_path = 200;
constexpr std::size_t least_views = 3;

bool ends_with(std::string_view text, std::string_view end) {
    return text.size() > end.size() && text.substr(text.size() - end.size()) == end;
}

bool is_image_path(const std::string& path) { return !ends_with(path, ".json"); }

std::span<const std::uint8_t> as_uint8(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

void inspect_image(CaptureFile& file, std::span<const std::byte> bytes) {
    const auto header = read_image_header(as_uint8(bytes));
    if (!header) {
        file.fault = "expected a PNG or JPEG with its size near the front; this is neither, or it is cut off";
        return;
    }
    file.kind = header->kind == ImageKind::png ? "png" : "jpeg";
    file.width = header->width;
    file.height = header->height;
    const std::int64_t n_pixels = std::int64_t(header->width) * header->height;
    if (n_pixels > LoadOptions{}.max_pixels)
        file.fault = std::to_string(header->width) + " x " + std::to_string(header->height) +
                     " pixels: expected at most " + std::to_string(LoadOptions{}.max_pixels) + " in all";
    else if (header->kind == ImageKind::jpeg && !jpeg_is_complete(as_uint8(bytes)))
        file.fault = "a JPEG that is cut off: the marker that ends an image is not there";
}

void inspect_cameras(CaptureFile& file, std::span<const std::byte> bytes) {
    file.kind = "json";
    try {
        Faults faults;
        const CameraList cameras = parse_cameras(as_text(bytes), file.path, faults);
        faults.throw_if_any();
        if (cameras.entries.size() < least_views)
            file.fault = std::to_string(cameras.entries.size()) + " images are listed: expected at least 3";
    } catch (const InputError& error) {
        file.fault = error.what();
    }
}

const CaptureFile* find(const CaptureRecord& capture, const std::string& path) {
    const auto file = std::find_if(capture.files.begin(), capture.files.end(),
                                   [&](const CaptureFile& candidate) { return candidate.path == path; });
    return file == capture.files.end() ? nullptr : &*file;
}

/// Of one listed photograph: whether its files are here and as large as the list says.
void judge_entry(CaptureVerdict& verdict, const CaptureRecord& capture, const CameraEntry& entry) {
    for (const std::string& path : {entry.file, entry.mask})
        if (!path.empty() && !find(capture, path)) verdict.missing.push_back(path);
    const CaptureFile* image = find(capture, entry.file);
    if (!image || image->width == 0) return;
    const bool is_as_listed =
        entry.width.value_or(image->width) == image->width && entry.height.value_or(image->height) == image->height;
    if (!is_as_listed)
        verdict.refused.emplace_back(entry.file, std::to_string(image->width) + " x " + std::to_string(image->height) +
                                                     " pixels: cameras.json says " +
                                                     std::to_string(entry.width.value_or(image->width)) + " x " +
                                                     std::to_string(entry.height.value_or(image->height)));
}

}  // namespace

std::string expect_capture_path(std::string_view path) {
    const auto name = relative_name(path);
    const auto slash = name ? name->find('/') : std::string::npos;
    const bool is_image = name && slash != std::string::npos && name->find('/', slash + 1) == std::string::npos &&
                          (name->substr(0, slash) == "images" || name->substr(0, slash) == "masks") &&
                          !ends_with(*name, ".json");
    const bool is_list = name && slash == std::string::npos && ends_with(*name, ".json");
    if (!name || name->size() > max_path || !(is_image || is_list))
        throw HttpProblem(400, "path \"" + std::string(path.substr(0, max_path)) +
                                   "\": expected images/NAME, masks/NAME or NAME.json, 200 bytes at most");
    return *name;
}

CaptureFile inspect_capture_file(const std::string& path, std::span<const std::byte> bytes) {
    CaptureFile file{.path = path, .n_bytes = bytes.size(), .sha256 = {}, .fault = {}, .kind = {}};
    if (bytes.empty())
        file.fault = "the file is empty";
    else if (is_image_path(path))
        inspect_image(file, bytes);
    else if (path == "cameras.json")
        inspect_cameras(file, bytes);
    else
        file.kind = "json";
    return file;
}

CaptureVerdict judge_capture(const CaptureRecord& capture, const std::optional<std::string>& cameras_json) {
    CaptureVerdict verdict;
    for (const CaptureFile& file : capture.files)
        if (!file.fault.empty()) verdict.refused.emplace_back(file.path, file.fault);
    if (!cameras_json) {
        if (!find(capture, "cameras.json")) verdict.missing.push_back("cameras.json");
        return verdict;
    }
    Faults faults;
    for (const CameraEntry& entry : parse_cameras(*cameras_json, "cameras.json", faults).entries)
        judge_entry(verdict, capture, entry);
    std::sort(verdict.missing.begin(), verdict.missing.end());
    verdict.missing.erase(std::unique(verdict.missing.begin(), verdict.missing.end()), verdict.missing.end());
    return verdict;
}

}  // namespace anyrate
