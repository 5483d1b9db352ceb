#include "tests/unit/capture/capture_on_disk.h"

#include <archive.h>
#include <archive_entry.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "core/error.h"

namespace anyrate {
namespace {

const Vec3 sphere_centre(3, -2, 5);

/// A camera 5 units from the sphere's centre at this angle of the ring, a little above it, looking at it.
Camera camera_on_ring(double angle_rad, int width, int height) {
    Camera camera;
    const Vec3 forward = -Vec3(std::cos(angle_rad), std::sin(angle_rad), 0.3).normalized();
    const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
    camera.R << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    camera.t = -camera.R * (sphere_centre - 5.0 * forward);
    camera.K << 60, 0.25, width / 2.0 + 1.5, 0, 55, height / 2.0 - 0.75, 0, 0, 1;
    camera.width = width;
    camera.height = height;
    return camera;
}

/// Colour and mask of every pixel whose centre's ray hits the sphere.
void photograph(View& view) {
    const Camera& camera = view.camera;
    view.image = ColourImage(camera.width, camera.height, {30, 40, 50});
    view.mask = MaskImage(camera.width, camera.height);
    const Vec3 from = camera.centre() - sphere_centre;
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const Vec3 ray = (camera.R.transpose() * (camera.K.inverse() * Vec3(x, y, 1))).normalized();
            const double half_b = from.dot(ray), d = half_b * half_b - (from.squaredNorm() - 1.0);
            if (d < 0) continue;
            const Vec3 normal = from + (-half_b - std::sqrt(d)) * ray;
            const auto level = [](double n) { return static_cast<std::uint8_t>(std::lround(128 + 100 * n)); };
            view.image(x, y) = {level(normal.x()), level(normal.y()), level(normal.z())};
            view.mask(x, y) = 255;
        }
    }
}

}  // namespace

Capture sphere_photographs(int n_views, int wider) {
    Capture capture{"sphere", {}};
    for (int i = 0; i < n_views; ++i) {
        View view;
        view.name = "images/00" + std::to_string(i) + ".png";
        view.camera = camera_on_ring(2.0 * std::numbers::pi * i / n_views, 48 + (i % 2) * wider, 36);
        photograph(view);
        capture.views.push_back(std::move(view));
    }
    return capture;
}

TemporaryFolder::TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "anyrate-test-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

CaptureOnDisk::CaptureOnDisk(const Capture& capture) { save_capture(capture, path()); }

nlohmann::json CaptureOnDisk::cameras() const { return nlohmann::json::parse(read("cameras.json")); }

void CaptureOnDisk::set_cameras(const nlohmann::json& cameras, const std::string& file) const {
    write(file, cameras.dump(1));
}

std::string CaptureOnDisk::read(const std::string& file) const {
    std::ifstream in(path() / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void CaptureOnDisk::write(const std::string& file, const std::string& bytes) const {
    write_bytes(path() / file, bytes);
}

void CaptureOnDisk::truncate(const std::string& file, double fraction_left) const {
    const std::string bytes = read(file);
    write(file, bytes.substr(0, static_cast<std::size_t>(static_cast<double>(bytes.size()) * fraction_left)));
}

std::string refusal(const std::filesystem::path& capture, const LoadOptions& options) {
    try {
        load_capture(capture, options);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

bool says(const std::string& message, std::initializer_list<std::string> parts) {
    std::istringstream lines(message);
    for (std::string line; std::getline(lines, line);) {
        const auto is_there = [&](const std::string& part) { return line.find(part) != std::string::npos; };
        if (std::all_of(parts.begin(), parts.end(), is_there)) return true;
    }
    return false;
}

std::size_t n_lines(const std::string& text) {
    return text.empty() ? 0 : 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

std::string make_zip(const std::vector<ZipEntry>& entries) {
    std::string zip(1 << 16, '\0');
    for (const ZipEntry& entry : entries) zip.resize(zip.size() + entry.bytes.size() + 2 * entry.name.size() + 1024);
    archive* writer = archive_write_new();
    archive_write_set_format_zip(writer);
    std::size_t n_used = 0;
    archive_write_set_bytes_in_last_block(writer, 1);
    archive_write_open_memory(writer, zip.data(), zip.size(), &n_used);
    for (const ZipEntry& entry : entries) {
        archive_entry* header = archive_entry_new();
        archive_entry_set_pathname(header, entry.name.c_str());
        archive_entry_set_perm(header, 0644);
        archive_entry_set_filetype(header, entry.link_to.empty() ? AE_IFREG : AE_IFLNK);
        if (!entry.link_to.empty()) archive_entry_set_symlink(header, entry.link_to.c_str());
        if (entry.link_to.empty()) archive_entry_set_size(header, static_cast<la_int64_t>(entry.bytes.size()));
        if (archive_write_header(writer, header) != ARCHIVE_OK) throw std::runtime_error(archive_error_string(writer));
        archive_write_data(writer, entry.bytes.data(), entry.bytes.size());
        archive_entry_free(header);
    }
    archive_write_close(writer);
    archive_write_free(writer);
    zip.resize(n_used);
    return zip;
}

std::vector<ZipEntry> files_under(const std::filesystem::path& folder, const std::string& top) {
    std::vector<ZipEntry> entries;
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
        if (!file.is_regular_file()) continue;
        std::ifstream in(file.path(), std::ios::binary);
        entries.push_back({top + std::filesystem::relative(file.path(), folder).generic_string(),
                           {std::istreambuf_iterator<char>(in), {}}});
    }
    return entries;
}

void write_bytes(const std::filesystem::path& file, const std::string& bytes) {
    std::ofstream out(file, std::ios::binary);
    out << bytes;
    if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace anyrate
