#pragma once
#include <filesystem>
#include <utility>

namespace anyrate {

/// A zip file that is removed with this object.
class TemporaryZip {
public:
    explicit TemporaryZip(std::filesystem::path path) : path_(std::move(path)) {}
    ~TemporaryZip();
    TemporaryZip(TemporaryZip&& other) noexcept : path_(std::exchange(other.path_, {})) {}
    TemporaryZip& operator=(TemporaryZip&&) = delete;
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// Packs what a capture consists of (images/, masks/, *.json) into a zip in the folder for temporary files, in the
/// order of the names and without compression, for photographs are compressed already.
/// @throws InputError the folder has no such file @throws IoError
TemporaryZip zip_capture(const std::filesystem::path& folder);

}  // namespace anyrate
