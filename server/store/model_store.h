#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "server/store/file.h"
#include "server/store/log_view.h"

namespace anyrate {

/// Where the files of one model stand.
struct ModelPaths {
    std::filesystem::path folder;      ///< DATA/models/<id>
    std::filesystem::path capture;     ///< capture.zip, as it was uploaded
    std::filesystem::path thumbnails;  ///< thumbnails.zip, small copies of its photographs, once a worker has loaded it
    std::filesystem::path live_log;    ///< log.live, beside it log.live.idx: what live clients follow
    std::filesystem::path sealed_log;  ///< model.arl, once the model is done
    std::filesystem::path lease;       ///< the latest lease on the log
};

/// @throws InputError if `id` is not shaped like a model id
ModelPaths model_paths(const std::filesystem::path& data, const std::string& id);

/// The data directory: DATA/catalog.sqlite, DATA/models/<id>/..., DATA/uploads/ for bodies that are still arriving.
/// Safe to call from several threads, for different models.
class ModelStore {
public:
    /// Makes what is missing of the folder and holds it for this process.
    /// @throws IoError it cannot be made, or another server holds it
    explicit ModelStore(std::filesystem::path data);

    const std::filesystem::path& data() const { return data_; }
    std::filesystem::path catalog_file() const;
    ModelPaths paths(const std::string& id) const { return model_paths(data_, id); }

    /// A fresh file name for an upload.
    std::filesystem::path upload_file(const std::string& name) const;
    /// Makes the folder of a model with a finished upload as its capture; durable when it returns. @throws IoError
    void adopt_upload(const std::filesystem::path& upload, const std::string& id);
    /// Removes every file of a model; one that is not there is no error. @throws IoError
    void remove(const std::string& id);
    /// Removes uploads that never finished and folders of models that the catalog does not know. @throws IoError
    void remove_leftovers(const std::function<bool(const std::string& id)>& is_known);

    std::optional<LogView> open_log(const std::string& id) const;
    std::optional<LogView> open_live_log(const std::string& id) const;
    /// Bytes a program may still write on this disk. @throws IoError
    std::uint64_t free_bytes() const;
    /// Writes a little in the data directory and takes it away again: what a disk that fails, is full beyond what
    /// free_bytes() can tell or was set to reading only refuses. @throws IoError
    void try_to_write() const;

private:
    std::filesystem::path data_;
    FileHandle lock_;
};

}  // namespace anyrate
