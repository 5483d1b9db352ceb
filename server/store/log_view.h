#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "proto/index.h"
#include "server/store/file.h"

namespace anyrate {

/// What of a model's log is durable at one moment. The bytes behind a view never change: a live log only grows, and one
/// that is begun anew or removed leaves the open file as it is.
struct LogView {
    std::shared_ptr<const FileHandle> file;
    std::uint64_t log_id = 0;
    bool sealed = false;             ///< of the sealed form
    bool complete = false;           ///< nothing will be appended: the model is sealed
    std::uint64_t size = 0;          ///< bytes of whole frames, from the start of the file
    std::uint64_t frames_begin = 0;  ///< offset of the base
    std::vector<IndexRow> rows;      ///< one per base, refine and colour frame
};

/// The log of a model: the sealed file if it is there, else the live one with its side index; nullopt if neither has a
/// frame yet. @throws IoError, DecodeError if the file is no log
std::optional<LogView> open_log(const std::filesystem::path& sealed, const std::filesystem::path& live);

/// The log of a model as live clients follow it: the live file, also when the model is sealed, for the sealed form has
/// other packets and with them other sequence numbers. Only where there is no live file, the sealed one.
std::optional<LogView> open_live_log(const std::filesystem::path& sealed, const std::filesystem::path& live);

}  // namespace anyrate
