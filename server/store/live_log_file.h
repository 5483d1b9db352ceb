#pragma once
#include <filesystem>
#include <optional>

#include "server/store/file.h"
#include "server/store/lease_file.h"
#include "server/store/log_store.h"

namespace anyrate {

/// Where the files of one log stand.
struct LogPaths {
    std::filesystem::path live;    ///< beside it its side index `<live>.idx` and its notes `<live>.<name>`
    std::filesystem::path sealed;  ///< empty: the log will not be sealed
};

/// A live log on disk and its side index. The index is replaced atomically, so that a reader always sees rows of frames
/// that are there.
class LiveLogFile final : public LogAppender {
public:
    /// Opens the log, or makes an empty one. @param lease  nullopt: nobody else writes it @throws IoError
    LiveLogFile(LogPaths paths, std::optional<LeaseFile> lease);
    ~LiveLogFile() override;

    std::vector<std::byte> read() const override;
    std::optional<SideIndex> read_index() const override;
    void begin_anew() override;
    void cut(std::uint64_t n_bytes) override;
    void append(std::span<const std::byte> frames) override;
    void publish_index(std::uint64_t log_id, std::span<const IndexRow> rows) override;
    void seal(std::span<const IndexRow> rows) override;
    void keep_note(const std::string& name, std::span<const std::byte> bytes) override;
    std::optional<std::vector<std::byte>> note(const std::string& name) const override;
    void drop_note(const std::string& name) override;

private:
    void guarded(const std::function<void()>& work) const;
    std::filesystem::path note_file(const std::string& name) const;
    void shorten(std::uint64_t n_bytes);

    LogPaths paths_;
    std::optional<LeaseFile> lease_;
    FileHandle file_;
    std::uint64_t n_bytes_ = 0;
};

/// `<live>.idx`
std::filesystem::path side_index_of(const std::filesystem::path& live);

}  // namespace anyrate
