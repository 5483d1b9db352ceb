#include "core/capture/capture_files.h"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace anyrate {
namespace {

class FolderFiles final : public CaptureFiles {
public:
    explicit FolderFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

    std::optional<std::uint64_t> size(const std::string& name) const override {
        std::error_code error;
        if (!std::filesystem::is_regular_file(folder_ / name, error)) return std::nullopt;
        const auto n_bytes = std::filesystem::file_size(folder_ / name, error);
        if (error) return std::nullopt;
        return n_bytes;
    }

    std::vector<std::uint8_t> read(const std::string& name, std::size_t at_most) const override {
        std::ifstream file(folder_ / name, std::ios::binary);
        const auto n_bytes = size(name);
        if (!file || !n_bytes) throw IoError((folder_ / name).string() + ": cannot be opened for reading");
        std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(*n_bytes, at_most)));
        file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!file) throw IoError((folder_ / name).string() + ": cannot be read");
        return bytes;
    }

private:
    std::filesystem::path folder_;
};

class ZipFiles final : public CaptureFiles {
public:
    /// @param top  what stands before every name of the capture inside the zip: "" or "folder/"
    ZipFiles(ZipContents contents, std::string top) : contents_(std::move(contents)), top_(std::move(top)) {}

    std::optional<std::uint64_t> size(const std::string& name) const override {
        const auto entry = contents_.find(top_ + name);
        if (entry == contents_.end()) return std::nullopt;
        return entry->second.size();
    }

    std::vector<std::uint8_t> read(const std::string& name, std::size_t at_most) const override {
        const std::vector<std::uint8_t>& data = contents_.at(top_ + name);
        return {data.begin(), data.begin() + static_cast<std::ptrdiff_t>(std::min(data.size(), at_most))};
    }

private:
    ZipContents contents_;
    std::string top_;
};

std::vector<std::string> names_of(const ZipContents& contents) {
    std::vector<std::string> names;
    for (const auto& [name, data] : contents) names.push_back(name);
    return names;
}

}  // namespace

std::string top_folder(const std::vector<std::string>& names, const std::string& zip_name,
                       const std::string& cameras_file) {
    if (std::find(names.begin(), names.end(), cameras_file) != names.end()) return "";
    std::vector<std::string> tops;
    for (const std::string& name : names) {
        const std::size_t slash = name.find('/');
        if (slash == std::string::npos || name.substr(slash + 1) != cameras_file) continue;
        if (name.substr(0, slash) != "__MACOSX") tops.push_back(name.substr(0, slash + 1));
    }
    if (tops.size() > 1)
        throw InputError(zip_name + ": " + cameras_file + " lies both in " + tops[0] + " and in " + tops[1] +
                         "; expected one capture");
    return tops.empty() ? "" : tops.front();
}

std::unique_ptr<CaptureFiles> open_capture_files(const std::filesystem::path& path, const std::string& cameras_file,
                                                 const ZipLimits& limits) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status)) return std::make_unique<FolderFiles>(path);
    if (!std::filesystem::is_regular_file(status))
        throw InputError(path.string() + ": nothing to read there; expected a capture's folder or zip file");
    ZipContents contents = read_zip(path, limits);
    std::string top = top_folder(names_of(contents), path.filename().string(), cameras_file);
    return std::make_unique<ZipFiles>(std::move(contents), std::move(top));
}

}  // namespace anyrate
