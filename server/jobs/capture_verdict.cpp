#include "server/jobs/capture_verdict.h"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "core/capture/cameras_json.h"
#include "core/capture/capture_files.h"
#include "core/capture/check_camera.h"
#include "core/capture/faults.h"
#include "core/capture/image_header.h"
#include "core/capture/load_capture.h"
#include "core/capture/zip_archive.h"
#include "core/error.h"
#include "server/store/file.h"
#include "server/store/sha256.h"

namespace anyrate {
namespace {

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
    if (bytes.size() > LoadOptions{}.max_image_bytes())
        file.fault = std::to_string(bytes.size()) + " bytes: expected at most " +
                     std::to_string(LoadOptions{}.max_image_bytes());
    else if (n_pixels > LoadOptions{}.max_pixels)
        file.fault = std::to_string(header->width) + " x " + std::to_string(header->height) +
                     " pixels: expected at most " + std::to_string(LoadOptions{}.max_pixels) + " in all";
    else if (header->kind == ImageKind::jpeg && !jpeg_is_complete(as_uint8(bytes)))
        file.fault = "a JPEG that is cut off: the marker that ends an image is not there";
    else if (header->kind == ImageKind::png && !png_is_whole(as_uint8(bytes)))
        file.fault = "a damaged PNG: expected whole chunks with their checksums up to the last, IEND";
}

void inspect_cameras(CaptureFile& file, std::span<const std::byte> bytes) {
    file.kind = "json";
    if (bytes.size() > max_cameras_bytes) {
        file.fault = std::to_string(bytes.size()) + " bytes: expected at most " + std::to_string(max_cameras_bytes);
        return;
    }
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

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

/// The mask's file by the rules of load_capture(); nullptr if only an alpha channel is left.
const CaptureFile* find_mask(const CaptureRecord& capture, const CameraEntry& entry) {
    if (!entry.mask.empty()) return entry.mask == entry.file ? nullptr : find(capture, entry.mask);
    const std::string same_name = "masks/" + entry.file.substr(entry.file.rfind('/') + 1);
    if (const CaptureFile* mask = find(capture, same_name)) return mask;
    return find(capture, same_name.substr(0, same_name.rfind('.')) + ".png");
}

/// Of one listed photograph: whether its files are here, as large as the list says, and alike.
void judge_entry(CaptureVerdict& verdict, const CaptureRecord& capture, const CameraEntry& entry) {
    for (const std::string& path : {entry.file, entry.mask})
        if (!path.empty() && !find(capture, path)) verdict.missing.push_back(path);
    const CaptureFile* image = find(capture, entry.file);
    if (!image || image->width == 0) return;
    const int width = entry.width.value_or(image->width), height = entry.height.value_or(image->height);
    if (width != image->width || height != image->height)
        verdict.refused.emplace_back(entry.file, size_text(image->width, image->height) +
                                                     " pixels: cameras.json says " + size_text(width, height));
    const CaptureFile* mask = find_mask(capture, entry);
    if (!mask || mask->width == 0) return;
    if (mask->width != image->width || mask->height != image->height)
        verdict.refused.emplace_back(mask->path, size_text(mask->width, mask->height) + " pixels: expected " +
                                                     size_text(image->width, image->height) + " as " + entry.file);
}

/// What only all the entries together can tell.
void judge_list(CaptureVerdict& verdict, const CaptureRecord& capture, const CameraList& list) {
    Faults faults;
    std::vector<Camera> cameras;
    std::set<std::string> seen;
    std::int64_t n_pixels = 0;
    for (const CameraEntry& entry : list.entries) {
        if (!seen.insert(entry.file).second)
            verdict.refused.emplace_back("cameras.json", "lists " + entry.file + " twice: expected every image once");
        if (const CaptureFile* image = find(capture, entry.file))
            n_pixels += std::int64_t{image->width} * image->height;
        if (const auto camera = to_camera(entry, list.pixel_center, faults)) cameras.push_back(*camera);
    }
    if (cameras.size() >= least_views) check_baseline(cameras, "cameras.json", faults);
    for (const Fault& fault : faults.all()) verdict.refused.emplace_back(fault.file, fault.sentence);
    if (n_pixels > LoadOptions{}.max_capture_pixels)
        verdict.refused.emplace_back("cameras.json", "lists images of " + std::to_string(n_pixels) +
                                                         " pixels together: expected at most " +
                                                         std::to_string(LoadOptions{}.max_capture_pixels));
}

constexpr const char* zip_name = "capture.zip";  // what the job calls it

bool is_list(const std::string& name) { return name == "cameras.json" || ends_with(name, "/cameras.json"); }

/// What a zip holds, before it is known which folder of it is the capture.
struct ZipFiles {
    std::vector<CaptureFile> files;            ///< by their names in the zip
    std::map<std::string, std::string> lists;  ///< texts of those called cameras.json
};

ZipFiles inspect_zip(const std::filesystem::path& zip) {
    ZipFiles found;
    visit_zip(zip, zip_name, {}, [&](const std::string& name, const std::vector<std::uint8_t>& data) {
        const auto bytes = std::as_bytes(std::span(data));
        found.files.push_back(is_list(name) ? inspect_capture_file("cameras.json", bytes)
                                            : inspect_capture_file(name, bytes));
        found.files.back().path = name;
        found.files.back().sha256 = to_hex(sha256(bytes));
        if (is_list(name) && found.files.back().fault.empty()) found.lists[name] = as_text(bytes);
    });
    return found;
}

/// The files below a folder of the zip, by their names in it.
CaptureRecord capture_in(std::vector<CaptureFile> files, const std::string& top) {
    CaptureRecord capture;
    for (CaptureFile& file : files) {
        if (!file.path.starts_with(top)) continue;
        file.path.erase(0, top.size());
        capture.files.push_back(std::move(file));
    }
    std::sort(capture.files.begin(), capture.files.end(),
              [](const CaptureFile& a, const CaptureFile& b) { return a.path < b.path; });
    return capture;
}

/// Leaves only what the job will read.
void keep_listed(CaptureRecord& capture, const std::optional<std::string>& cameras_json) {
    std::set<std::string> wanted{"cameras.json"};
    Faults known;
    if (cameras_json) {
        for (const CameraEntry& entry : parse_cameras(*cameras_json, "cameras.json", known).entries) {
            wanted.insert(entry.file);
            if (const CaptureFile* mask = find_mask(capture, entry)) wanted.insert(mask->path);
        }
    }
    std::erase_if(capture.files, [&](const CaptureFile& file) { return !wanted.contains(file.path); });
}

}  // namespace

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
    const CameraList list = parse_cameras(*cameras_json, "cameras.json", faults);
    for (const CameraEntry& entry : list.entries) judge_entry(verdict, capture, entry);
    judge_list(verdict, capture, list);
    std::sort(verdict.missing.begin(), verdict.missing.end());
    verdict.missing.erase(std::unique(verdict.missing.begin(), verdict.missing.end()), verdict.missing.end());
    return verdict;
}

JudgedCapture judge_zip(const std::filesystem::path& zip) {
    ZipFiles found = inspect_zip(zip);
    std::vector<std::string> names;
    for (const CaptureFile& file : found.files) names.push_back(file.path);
    const std::string top = top_folder(names, zip_name, "cameras.json");
    const auto list = found.lists.find(top + "cameras.json");
    const auto cameras = list == found.lists.end() ? std::nullopt : std::optional(list->second);
    CaptureRecord capture = capture_in(std::move(found.files), top);
    keep_listed(capture, cameras);
    CaptureVerdict verdict = judge_capture(capture, cameras);
    return {std::move(capture.files), std::move(verdict)};
}

}  // namespace anyrate
