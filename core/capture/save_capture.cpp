#include <cstddef>
#include <fstream>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "core/capture/cameras_json.h"
#include "core/capture/image_io.h"
#include "core/capture/load_capture.h"
#include "core/error.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

void write_file(const std::filesystem::path& path, std::span<const char> bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) throw IoError(path.string() + ": cannot be written");
}

void write_file(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    write_file(path, std::span(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void make_folder(const std::filesystem::path& path) {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) throw IoError(path.string() + ": cannot be made (" + error.message() + ")");
}

std::string numbered(const std::string& folder, std::size_t i) {
    const std::string digits = std::to_string(i);
    return folder + "/" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits + ".png";
}

}  // namespace

void save_capture(const Capture& capture, const std::filesystem::path& folder) {
    make_folder(folder / "images");
    make_folder(folder / "masks");
    std::vector<std::string> files, masks;
    for (std::size_t i = 0; i < capture.views.size(); ++i) {
        files.push_back(numbered("images", i));
        masks.push_back(numbered("masks", i));
    }
    const auto write_view = [&](std::size_t i) {
        write_file(folder / files[i], encode_png(capture.views[i].image));
        write_file(folder / masks[i], encode_png(capture.views[i].mask));
    };
    parallel_for(capture.views.size(), write_view, 1);
    write_file(folder / "cameras.json", format_cameras(capture.views, files, masks));
}

}  // namespace anyrate
