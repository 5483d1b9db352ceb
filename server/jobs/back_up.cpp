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

/// The order matters while a worker writes: what speaks of a log before the log, which then has at least as much.
std::vector<fs::path> in_copying_order(const ModelPaths& paths) {
    std::vector<fs::path> files{paths.capture};
    for (const char* suffix : {".mark", ".checkpoint", ".idx", ""}) {
        fs::path file = paths.live_log;
        file += suffix;
        files.push_back(file);
    }
    files.push_back(paths.sealed_log);
    files.push_back(paths.lease);
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

/// Files of captures that arrive one by one, and other files that stand beside the catalog.
void copy_rest(const fs::path& data, const fs::path& target, BackUp& done) {
    for (const auto& entry : fs::directory_iterator(data)) {
        const std::string name = entry.path().filename().string();
        if (entry.is_regular_file() && name != "lock" && !name.starts_with("catalog.sqlite"))
            done.n_bytes += copy_bytes(entry.path(), target / name).value_or(0);
    }
    for (const auto& entry : fs::recursive_directory_iterator(data)) {
        const fs::path inside = entry.path().lexically_relative(data);
        const std::string top = inside.begin()->string();
        if (top == "models" || top == "uploads" || !inside.has_parent_path() || !entry.is_regular_file()) continue;
        fs::create_directories((target / inside).parent_path());
        done.n_bytes += copy_bytes(entry.path(), target / inside).value_or(0);
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
    for (bool more = true; more;) {
        const ModelPage page = catalog.list(1000, ids.empty() ? "" : ids.back());
        for (const ModelRecord& model : page.models) ids.push_back(model.id);
        more = page.more;
    }
    return ids;
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
