#pragma once
// A small sound capture in a temporary folder, for tests to load, and to break one thing at a time.
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/capture/load_capture.h"

namespace anyrate {

/// A sphere of radius 1 far from the origin, painted by its normals, in the middle of a ring of cameras.
/// Views 0, 2, 4... are 48x36 pixels; the others are `wider` pixels wider.
Capture sphere_photographs(int n_views = 6, int wider = 0);

/// A folder that is gone with its object.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// sphere_photographs(), saved.
class CaptureOnDisk {
public:
    explicit CaptureOnDisk(const Capture& capture = sphere_photographs());

    const std::filesystem::path& path() const { return folder_.path(); }
    nlohmann::json cameras() const;
    void set_cameras(const nlohmann::json& cameras, const std::string& file = "cameras.json") const;

    /// Changes entry `i` of the list in cameras.json.
    template <class Change>
    void change_entry(std::size_t i, const Change& change) const {
        nlohmann::json json = cameras();
        change(json["images"][i]);
        set_cameras(json);
    }

    std::string read(const std::string& file) const;
    void write(const std::string& file, const std::string& bytes) const;
    /// Cuts the file's end off.
    void truncate(const std::string& file, double fraction_left) const;

private:
    TemporaryFolder folder_;
};

/// What load_capture() says when it refuses; empty if it does not.
std::string refusal(const std::filesystem::path& capture, const LoadOptions& options = {});

/// Whether one of the message's lines has all the parts.
bool says(const std::string& message, std::initializer_list<std::string> parts);

std::size_t n_lines(const std::string& text);

struct ZipEntry {
    std::string name, bytes;
    std::string link_to = {};  ///< makes it a symbolic link
};

/// The bytes of a zip file.
std::string make_zip(const std::vector<ZipEntry>& entries);

/// All files under `folder`, each called `top` and its path in there.
std::vector<ZipEntry> files_under(const std::filesystem::path& folder, const std::string& top = "");

void write_bytes(const std::filesystem::path& file, const std::string& bytes);

}  // namespace anyrate
