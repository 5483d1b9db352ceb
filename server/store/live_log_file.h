#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "proto/index.h"
#include "server/store/file.h"

namespace anyrate {

/// A live log on disk and its side index `<live>.idx`. Every append is whole frames and is durable when it returns; the
/// index is replaced atomically, so that a reader always sees rows of frames that are there.
class LiveLogFile {
public:
    /// Creates `live`, or empties it. @throws IoError
    explicit LiveLogFile(std::filesystem::path live);
    ~LiveLogFile();
    LiveLogFile(const LiveLogFile&) = delete;
    LiveLogFile& operator=(const LiveLogFile&) = delete;

    void begin_anew();  ///< Forgets all frames and rows; who reads them keeps their files. @throws IoError
    void append(std::span<const std::byte> frames);                            ///< @throws IoError
    void publish_index(std::uint64_t log_id, std::span<const IndexRow> rows);  ///< @throws IoError
    /// Writes the sealed form (seal_log) to `sealed` atomically. The live files stay: clients that follow them count
    /// their frames, and the sealed form has others. @throws IoError
    void seal(const std::filesystem::path& sealed, std::span<const IndexRow> rows);

private:
    std::filesystem::path path_;
    FileHandle file_;
};

/// `<live>.idx`
std::filesystem::path side_index_of(const std::filesystem::path& live);

}  // namespace anyrate
