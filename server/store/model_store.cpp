#include "server/store/model_store.h"

#include <fcntl.h>
#include <sys/file.h>

#include <atomic>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.h"
#include "server/store/directory_blob_store.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;

FileHandle lock_folder(const fs::path& data) {
    FileHandle lock(::open((data / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640));
    if (!lock) throw IoError("cannot write in the data directory " + data.string());
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0)
        throw IoError("the data directory " + data.string() + " is in use by another server");
    return lock;
}

/// Runs file system work and turns its exception into ours.
template <class Work>
auto io(const Work& work) {
    try {
        return work();
    } catch (const fs::filesystem_error& error) {
        if (error.code() == std::errc::no_space_on_device) throw DiskFull(error.what());
        throw IoError(error.what());
    }
}

std::vector<fs::path> entries(const fs::path& folder) {
    return {fs::directory_iterator(folder), fs::directory_iterator()};
}

}  // namespace

ModelPaths model_paths(const fs::path& data, const std::string& id) {
    if (!is_model_id(id)) throw InputError("\"" + id + "\" is not a model id: expected 26 of a-z and 2-7");
    const fs::path folder = data / "models" / id;
    return {.folder = folder,
            .capture = folder / "capture.zip",
            .thumbnails = folder / "thumbnails.zip",
            .live_log = folder / "log.live",
            .sealed_log = folder / "model.arl",
            .lease = folder / "lease"};
}

ModelStore::ModelStore(fs::path data) : data_(std::move(data)) {
    io([&] {
        fs::create_directories(data_ / "models");
        fs::create_directories(data_ / "uploads");
    });
    lock_ = lock_folder(data_);
}

fs::path ModelStore::catalog_file() const { return data_ / "catalog.sqlite"; }

fs::path ModelStore::upload_file(const std::string& name) const { return data_ / "uploads" / name; }

void ModelStore::adopt_upload(const fs::path& upload, const std::string& id) {
    const fs::path capture = paths(id).capture;
    DirectoryBlobStore(data_ / "models").adopt(id + "/" + capture.filename().string(), upload);
}

void ModelStore::remove(const std::string& id) {
    io([&] { fs::remove_all(paths(id).folder); });
}

void ModelStore::remove_leftovers(const std::function<bool(const std::string& id)>& is_known) {
    io([&] {
        for (const fs::path& upload : entries(data_ / "uploads")) fs::remove_all(upload);
        for (const fs::path& model : entries(data_ / "models"))
            if (!is_known(model.filename().string())) fs::remove_all(model);
    });
}

std::optional<LogView> ModelStore::open_log(const std::string& id) const {
    const ModelPaths model = paths(id);
    return anyrate::open_log(model.sealed_log, model.live_log);
}

std::optional<LogView> ModelStore::open_live_log(const std::string& id) const {
    const ModelPaths model = paths(id);
    return anyrate::open_live_log(model.sealed_log, model.live_log);
}

std::uint64_t ModelStore::free_bytes() const {
    return io([&] { return fs::space(data_).available; });
}

void ModelStore::try_to_write() const {
    static std::atomic<std::uint64_t> n_tries{0};  // several may try at a time
    const fs::path file = upload_file("try-" + std::to_string(++n_tries));
    try {
        write_all(create_file(file), as_bytes("x"));
    } catch (const IoError&) {
        std::error_code ignored;  // what matters is said below
        fs::remove(file, ignored);
        throw;
    }
    remove_file(file);
}

}  // namespace anyrate
