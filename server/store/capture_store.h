#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <vector>

#include "server/store/catalog.h"

namespace anyrate {

/// A file of a capture that has arrived, and what was found of it then.
struct CaptureFile {
    std::string path = {};  ///< relative_name(): "images/000.png"
    std::uint64_t n_bytes = 0;
    std::string sha256 = {};    ///< hexadecimal
    std::string fault = {};     ///< why it cannot be used, a sentence; empty if it can
    std::string kind = {};      ///< "png", "jpeg" or "json"; empty if it is none of them
    int width = 0, height = 0;  ///< pixels, of an image
    friend bool operator==(const CaptureFile&, const CaptureFile&) = default;
};

/// A capture that arrives file by file.
struct CaptureRecord {
    std::string id;
    Timestamp created{};
    std::vector<CaptureFile> files;  ///< by path
    std::uint64_t n_bytes() const;
};

/// A page of list().
struct CapturePage {
    std::vector<CaptureRecord> captures;
    bool more = false;  ///< there are others behind the last
};

/// The captures of a data directory: DATA/captures/<id>/files/... and a list of what has arrived, files.json. What a
/// call acknowledges has survived a crash. Safe to call from several threads: who reads a capture waits for nobody but
/// who changes the same one.
class CaptureStore {
public:
    /// Makes DATA/captures. @throws IoError
    explicit CaptureStore(const std::filesystem::path& data);

    /// Begins a capture; one of that id that is there already is left as it is. @throws IoError
    CaptureRecord create(const std::string& id, Timestamp now);
    std::optional<CaptureRecord> find(const std::string& id);  ///< @throws IoError
    /// At most `limit` captures in the order of their ids, from behind `after` ("" for the first): so a page costs what
    /// it shows, however many there are. @throws IoError
    CapturePage list(std::size_t limit, const std::string& after);
    /// Takes an uploaded file, in the place of an earlier one of its path. @param file  its record, path checked
    /// @return false if there is no such capture @throws IoError
    bool put(const std::string& id, const CaptureFile& file, const std::filesystem::path& upload);
    /// @return whether it was there @throws IoError
    bool remove(const std::string& id);
    /// Where the files of a capture are. A change of it waits as long as `use` runs.
    template <class Use>
    bool with_files(const std::string& id, const Use& use) {
        const auto mutex = mutex_of(id);
        const std::shared_lock lock(*mutex);
        if (!is_there(id)) return false;
        use(folder(id) / "files");
        return true;
    }
    /// Removes captures that were begun before `time`. @return how many
    int remove_older(Timestamp time);

private:
    /// The lock of one capture. It lives while anybody has it.
    std::shared_ptr<std::shared_mutex> mutex_of(const std::string& id);
    std::filesystem::path folder(const std::string& id) const;
    bool is_there(const std::string& id) const;
    CaptureRecord read(const std::string& id) const;
    void write(const CaptureRecord& capture) const;

    std::filesystem::path root_;
    std::mutex mutex_;  ///< of the map
    std::map<std::string, std::weak_ptr<std::shared_mutex>> mutexes_;
};

}  // namespace anyrate
