#include "server/store/directory_blob_store.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t longest_part = 200;

bool is_name_part(std::string_view part) {
    const auto is_plain = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
    };
    return !part.empty() && part.size() <= longest_part && part.front() != '.' && std::ranges::all_of(part, is_plain);
}

void move_to(const fs::path& from, const fs::path& to) {
    if (std::rename(from.c_str(), to.c_str()) != 0)
        throw IoError("cannot rename " + from.string() + ": " + std::strerror(errno));
}

}  // namespace

bool is_blob_name(const std::string& name) {
    const auto slash = name.find('/');
    return slash != std::string::npos && is_name_part(std::string_view(name).substr(0, slash)) &&
           is_name_part(std::string_view(name).substr(slash + 1));
}

DirectoryBlobStore::DirectoryBlobStore(fs::path folder) : folder_(std::move(folder)) {}

void DirectoryBlobStore::put(const std::string& name, std::span<const std::byte> bytes) {
    const fs::path file = file_of(name);
    make_folder_of(file);
    replace_file(file, bytes);
}

void DirectoryBlobStore::adopt(const std::string& name, const fs::path& given) {
    const fs::path file = file_of(name);
    make_folder_of(file);
    move_to(given, file);
    sync_folder(file.parent_path());
}

std::optional<std::uint64_t> DirectoryBlobStore::size(const std::string& name) const {
    const FileHandle file = open_if_exists(file_of(name));
    return file ? std::optional(file_size(file)) : std::nullopt;
}

std::optional<std::vector<std::byte>> DirectoryBlobStore::read(const std::string& name, std::uint64_t offset,
                                                               std::size_t n) const {
    const FileHandle file = open_if_exists(file_of(name));
    return file ? std::optional(read_at(file, offset, n)) : std::nullopt;
}

void DirectoryBlobStore::remove(const std::string& name) { remove_file(file_of(name)); }

std::vector<std::string> DirectoryBlobStore::list(const std::string& model) const {
    if (!is_name_part(model)) throw InputError("\"" + model + "\" is no name of a model");
    std::error_code error;
    std::vector<std::string> names;
    for (fs::directory_iterator entry(folder_ / model, error), end; !error && entry != end; entry.increment(error)) {
        const std::string name = model + "/" + entry->path().filename().string();
        if (is_blob_name(name) && entry->path().extension() != ".part") names.push_back(name);
    }
    if (error && error != std::errc::no_such_file_or_directory)
        throw IoError("cannot read the folder of " + model + ": " + error.message());
    std::ranges::sort(names);
    return names;
}

fs::path DirectoryBlobStore::file_of(const std::string& name) const {
    if (!is_blob_name(name)) throw InputError("\"" + name + "\" is no name of a blob: expected MODEL/FILE");
    return folder_ / name;
}

void DirectoryBlobStore::make_folder_of(const fs::path& file) {
    std::error_code error;
    if (!fs::create_directories(file.parent_path(), error)) {
        if (error) throw IoError("cannot make " + file.parent_path().string() + ": " + error.message());
        return;
    }
    sync_folder(folder_);
}

}  // namespace anyrate
