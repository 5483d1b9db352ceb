#include "server/jobs/back_up.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "server/store/file.h"
#include "server/store/live_log_file.h"
#include "server/store/model_store.h"
#include "server/store/sqlite_catalog.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t chunk = 1 << 20;

/// The order matters while a worker writes: what speaks of a log before the log, which then has at least as much. The
/// lease stays behind: nobody holds one on the copy, and one that was given out since the catalog was copied would keep
/// out the next.
std::vector<fs::path> in_copying_order(const ModelPaths& paths) {
    std::vector<fs::path> files{paths.capture, paths.thumbnails};
    for (const char* suffix : {".mark", ".checkpoint", ".idx", ""}) {
        fs::path file = paths.live_log;
        file += suffix;
        files.push_back(file);
    }
    files.push_back(paths.sealed_log);
    return files;
}

/// Copies a file as long as it is now. @return its bytes; nullopt if there is none
std::optional<std::uint64_t> copy_bytes(const fs::path& from, const fs::path& to) {
    const FileHandle source = open_if_exists(from);
    if (!source) return std::nullopt;
    const std::uint64_t size = file_size(source);
    const FileHandle copy = create_file(to);
    std::uint64_t n_copied = 0;
    while (n_copied < size) {
        const auto bytes =
            read_at(source, n_copied, static_cast<std::size_t>(std::min<std::uint64_t>(chunk, size - n_copied)));
        if (bytes.empty()) break;  // it was cut, back to whole frames
        write_all(copy, bytes);
        n_copied += bytes.size();
    }
    sync_file(copy);
    return n_copied;
}

/// Copies what is below a folder, but for what goes meanwhile. Files before folders: the list of a capture, which
/// speaks of its files, before them.
void copy_folder(const fs::path& from, const fs::path& to, BackUp& done) {
    fs::create_directories(to);
    std::vector<fs::path> folders;
    std::error_code error;
    for (fs::directory_iterator entry(from, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code gone;
        if (entry->is_directory(gone))
            folders.push_back(entry->path().filename());
        else if (entry->is_regular_file(gone))
            done.n_bytes += copy_bytes(entry->path(), to / entry->path().filename()).value_or(0);
    }
    if (error && error != std::errc::no_such_file_or_directory) throw fs::filesystem_error("cannot list", from, error);
    for (const fs::path& folder : folders) copy_folder(from / folder, to / folder, done);
}

/// Files of captures that arrive one by one, and whatever else stands beside catalog and models.
void copy_rest(const fs::path& data, const fs::path& target, BackUp& done) {
    for (const auto& entry : fs::directory_iterator(data)) {
        const std::string name = entry.path().filename().string();
        if (name == "models" || name == "uploads" || name == "lock" || name.starts_with("catalog.sqlite")) continue;
        if (entry.is_directory())
            copy_folder(entry.path(), target / name, done);
        else
            done.n_bytes += copy_bytes(entry.path(), target / name).value_or(0);
    }
}

/// @return whether the model was there, with its capture, until the end
bool copy_model(const fs::path& data, const fs::path& target, const std::string& id, BackUp& done) {
    const ModelPaths from = model_paths(data, id), to = model_paths(target, id);
    fs::create_directories(to.folder);
    const std::vector<fs::path> sources = in_copying_order(from), copies = in_copying_order(to);
    for (std::size_t i = 0; i < sources.size(); ++i) done.n_bytes += copy_bytes(sources[i], copies[i]).value_or(0);
    sync_folder(to.folder);
    return fs::exists(from.capture) && fs::exists(to.capture);
}

std::vector<std::string> ids_in(Catalog& catalog) {
    std::vector<std::string> ids;
    ModelPage page = catalog.list(1000, Catalog::from_newest);
    for (;;) {
        for (const ModelRecord& model : page.models) ids.push_back(model.id);
        if (!page.more) return ids;
        page = catalog.list(1000, page.models.back().number);
    }
}

BackUp copy_all(const fs::path& data, const fs::path& target) {
    BackUp done;
    fs::create_directories(target / "models");
    fs::create_directories(target / "uploads");
    SqliteCatalog(data / "catalog.sqlite").back_up(target / "catalog.sqlite");
    copy_rest(data, target, done);
    SqliteCatalog catalog(target / "catalog.sqlite");
    for (const std::string& id : ids_in(catalog)) {
        if (copy_model(data, target, id, done)) {
            ++done.n_models;
        } else {
            catalog.remove(id);
            fs::remove_all(model_paths(target, id).folder);
        }
    }
    sync_folder(target / "models");
    sync_folder(target);
    return done;
}

}  // namespace

BackUp back_up(const fs::path& data, const fs::path& target) {
    if (!fs::exists(data / "catalog.sqlite"))
        throw InputError(data.string() + ": expected a data directory, found no catalog.sqlite");
    if (fs::exists(target)) throw InputError(target.string() + " is there already; expected a new name");
    fs::path part = target;
    part += ".part";
    try {
        fs::remove_all(part);
        const BackUp done = copy_all(data, part);
        fs::rename(part, target);
        sync_folder(fs::absolute(target).parent_path());
        return done;
    } catch (const fs::filesystem_error& error) {
        throw IoError(std::string("backup: ") + error.what());
    }
}

}  // namespace anyrate
