#include "core/capture/load_capture.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/capture/cameras_json.h"
#include "core/capture/capture_files.h"
#include "core/capture/check_camera.h"
#include "core/capture/faults.h"
#include "core/capture/halve_view.h"
#include "core/capture/image_io.h"
#include "core/capture/object_position.h"
#include "core/capture/relative_name.h"
#include "core/capture/undistort.h"
#include "core/error.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

/// One view on its way in, and what is wrong with it so far. Only a sound one goes on to the next step.
struct Candidate {
    CameraEntry entry;
    std::string mask_file;  // empty: the image's alpha channel
    ImageHeader image_header, mask_header;
    View view;
    Faults faults;

    bool is_sound() const { return entry.is_well_formed && faults.empty(); }
};

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

CameraList read_cameras(const CaptureFiles& files, const std::string& path, const std::string& name, Faults& faults) {
    const auto n_bytes = files.size(name);
    if (!n_bytes) throw_fault(name, "missing from " + path + "; expected the list of images and their cameras");
    if (*n_bytes > max_cameras_bytes)
        throw_fault(name, std::to_string(*n_bytes) + " bytes; expected at most " + std::to_string(max_cameras_bytes));
    const std::vector<std::uint8_t> bytes = files.read(name);
    return parse_cameras({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, name, faults);
}

void check_list(const CameraList& list, const std::string& cameras_file, Faults& faults) {
    if (list.entries.size() < 3)
        faults.add(cameras_file, std::to_string(list.entries.size()) + " views; expected at least 3");
    std::map<std::string, int> n_uses;
    for (const CameraEntry& entry : list.entries)
        if (!entry.file.empty() && ++n_uses[entry.file] == 2)
            faults.add(cameras_file, "lists " + entry.file + " more than once; expected every image once");
}

/// The header of an image file, read before its pixels.
std::optional<ImageHeader> check_header(const CaptureFiles& files, const std::string& name, const LoadOptions& options,
                                        Faults& faults) {
    const auto n_bytes = files.size(name);
    if (!n_bytes) {
        faults.add(name, "missing; expected an image file");
        return std::nullopt;
    }
    if (*n_bytes > options.max_image_bytes()) {
        faults.add(name,
                   std::to_string(*n_bytes) + " bytes; expected at most " + std::to_string(options.max_image_bytes()));
        return std::nullopt;
    }
    constexpr std::size_t n_front_bytes = 1 << 16;  // nearly always enough
    auto header = read_image_header(files.read(name, n_front_bytes));
    if (!header && *n_bytes > n_front_bytes) header = read_image_header(files.read(name));
    if (!header) {
        faults.add(name, "neither a PNG nor a JPEG with a size in its header; expected an image file");
        return std::nullopt;
    }
    const std::int64_t n_pixels = std::int64_t{header->width} * header->height;
    if (n_pixels > options.max_pixels) {
        faults.add(name, size_text(header->width, header->height) + " pixels; expected at most " +
                             std::to_string(options.max_pixels) + " in all");
        return std::nullopt;
    }
    return header;
}

/// The mask's file by the rules of load_capture(); empty if only an alpha channel is left.
std::string find_mask(const CaptureFiles& files, const CameraEntry& entry) {
    if (!entry.mask.empty()) return entry.mask == entry.file ? "" : entry.mask;
    const std::string same_name = "masks/" + entry.file.substr(entry.file.rfind('/') + 1);
    if (files.size(same_name)) return same_name;
    const std::string as_png = same_name.substr(0, same_name.rfind('.')) + ".png";
    return files.size(as_png) ? as_png : "";
}

/// Finds the view's files, and checks what can be told without decoding them.
void check_files(Candidate& candidate, const CaptureFiles& files, const LoadOptions& options) {
    const CameraEntry& entry = candidate.entry;
    if (entry.file.empty()) return;
    const auto image = check_header(files, entry.file, options, candidate.faults);
    if (image) {
        const int width = entry.width.value_or(image->width), height = entry.height.value_or(image->height);
        if (image->width != width || image->height != height)
            candidate.faults.add(entry.file, size_text(image->width, image->height) + " pixels, but " +
                                                 options.cameras_file + " says " + size_text(width, height));
        candidate.image_header = *image;
    }
    candidate.mask_file = find_mask(files, entry);
    if (candidate.mask_file.empty()) return;
    const auto mask = check_header(files, candidate.mask_file, options, candidate.faults);
    if (!mask) return;
    if (image && (mask->width != image->width || mask->height != image->height))
        candidate.faults.add(candidate.mask_file, size_text(mask->width, mask->height) + " pixels; expected " +
                                                      size_text(image->width, image->height) + " as " + entry.file);
    candidate.mask_header = *mask;
}

std::int64_t pixels_together(const std::vector<Candidate>& candidates) {
    std::int64_t n_pixels = 0;
    for (const Candidate& candidate : candidates)
        n_pixels += std::int64_t{candidate.image_header.width} * candidate.image_header.height;
    return n_pixels;
}

/// @return whether all the images together are within the limit
bool check_capture_pixels(std::int64_t n_pixels, std::int64_t max_pixels, const std::string& cameras_file,
                          Faults& faults) {
    if (n_pixels <= max_pixels) return true;
    faults.add(cameras_file, "lists images of " + std::to_string(n_pixels) + " pixels together; expected at most " +
                                 std::to_string(max_pixels));
    return false;
}

void check_mask(const MaskImage& mask, const std::string& file, Faults& faults) {
    const auto is_object = [](std::uint8_t value) { return value != 0; };
    if (std::none_of(mask.pixels.begin(), mask.pixels.end(), is_object))
        faults.add(file, "an empty mask; expected some pixels other than 0, the object");
    else if (std::all_of(mask.pixels.begin(), mask.pixels.end(), is_object))
        faults.add(file, "a mask without background; expected pixels of 0 around the object");
}

/// Decodes the image and its alpha channel; false, and a fault, if it has none.
bool decode_with_alpha(const std::vector<std::uint8_t>& bytes, Candidate& candidate) {
    CutOut cut_out = decode_cut_out(bytes, candidate.image_header);
    if (!cut_out.mask) {
        candidate.faults.add(candidate.entry.file,
                             "has no mask; expected one in its entry, in masks/, or an alpha channel");
        return false;
    }
    candidate.view.image = std::move(cut_out.image);
    candidate.view.mask = std::move(*cut_out.mask);
    return true;
}

/// How often the images have to be halved so that no more pixels are kept.
int halvings_to_keep(std::int64_t max_pixels, std::int64_t n_pixels) {
    int n_halvings = 0;
    for (; n_pixels > max_pixels; n_pixels /= 4) ++n_halvings;
    return n_halvings;
}

/// Decodes the image and the mask of a sound candidate.
void decode_view(Candidate& candidate, const CaptureFiles& files, int n_halvings) {
    const std::string& image_file = candidate.entry.file;
    const std::string& mask_file = candidate.mask_file.empty() ? image_file : candidate.mask_file;
    const std::string* decoding = &image_file;
    try {
        const std::vector<std::uint8_t> bytes = files.read(image_file);
        if (candidate.mask_file.empty()) {
            if (!decode_with_alpha(bytes, candidate)) return;
        } else {
            candidate.view.image = decode_colour(bytes, candidate.image_header);
            decoding = &mask_file;
            candidate.view.mask = decode_mask(files.read(mask_file), candidate.mask_header);
        }
    } catch (const InputError& error) {
        candidate.faults.add(*decoding, error.what());
        return;
    }
    if (!candidate.entry.distortion.is_none()) undistort(candidate.view, candidate.entry.distortion);
    check_mask(candidate.view.mask, mask_file, candidate.faults);
    constexpr int smallest_side = 16;
    for (int i = 0; i < n_halvings; ++i)
        if (std::min(candidate.view.image.width, candidate.view.image.height) >= 2 * smallest_side)
            halve(candidate.view);
}

std::vector<Candidate> make_candidates(CameraList list, const CaptureFiles& files, const LoadOptions& options) {
    std::vector<Candidate> candidates(list.entries.size());
    const auto make = [&](std::size_t i) {
        Candidate& candidate = candidates[i];
        candidate.entry = std::move(list.entries[i]);
        candidate.view.name = candidate.entry.file;
        check_files(candidate, files, options);
        const auto camera = to_camera(candidate.entry, list.pixel_center, candidate.faults);
        if (camera) candidate.view.camera = *camera;
        candidate.view.camera.width = candidate.image_header.width;
        candidate.view.camera.height = candidate.image_header.height;
    };
    parallel_for(candidates.size(), make, 1);
    return candidates;
}

/// What only all the views together can tell; says nothing if too few of them are sound.
void check_views_together(const std::vector<Candidate>& candidates, const std::string& cameras_file, Faults& faults) {
    std::vector<const View*> views;
    std::vector<Camera> cameras;
    for (const Candidate& candidate : candidates) {
        if (!candidate.is_sound() || candidate.view.mask.pixels.empty()) continue;
        views.push_back(&candidate.view);
        cameras.push_back(candidate.view.camera);
    }
    if (views.size() < 3) return;
    Faults no_baseline;
    check_baseline(cameras, cameras_file, no_baseline);
    if (no_baseline.empty()) check_object_position(views, cameras_file, faults);
    faults.append(no_baseline);
}

std::string name_of(const std::filesystem::path& path) {
    std::error_code error;
    const std::filesystem::path absolute = std::filesystem::weakly_canonical(path, error);
    const std::filesystem::path& known = error ? path : absolute;
    return (std::filesystem::is_directory(known, error) ? known.filename() : known.stem()).string();
}

}  // namespace

Capture load_capture(const std::filesystem::path& folder_or_zip, const LoadOptions& options) {
    const auto cameras_file = relative_name(options.cameras_file);
    if (!cameras_file)
        throw_fault(options.cameras_file, "not a name inside the capture; expected one like cameras.json");
    const auto files = open_capture_files(folder_or_zip, *cameras_file, options.zip);

    Faults faults;
    CameraList list = read_cameras(*files, folder_or_zip.string(), *cameras_file, faults);
    check_list(list, *cameras_file, faults);
    std::vector<Candidate> candidates = make_candidates(std::move(list), *files, options);
    const std::int64_t n_pixels = pixels_together(candidates);
    const int n_halvings = halvings_to_keep(options.max_kept_pixels, n_pixels);
    const auto decode = [&](std::size_t i) {
        if (candidates[i].is_sound()) decode_view(candidates[i], *files, n_halvings);
    };
    if (check_capture_pixels(n_pixels, options.max_capture_pixels, *cameras_file, faults))
        parallel_for(candidates.size(), decode, 1);

    check_views_together(candidates, *cameras_file, faults);
    for (const Candidate& candidate : candidates) faults.append(candidate.faults);
    faults.throw_if_any();

    Capture capture{name_of(folder_or_zip), {}, n_halvings};
    for (Candidate& candidate : candidates) capture.views.push_back(std::move(candidate.view));
    return capture;
}

}  // namespace anyrate
