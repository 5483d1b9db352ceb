#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "proto/log_reader.h"

namespace anyrate {

/// The bytes of the log a user named; "-" is the standard input.
/// @throws InputError if there is no such file, IoError if it cannot be read
std::vector<std::byte> read_log(const std::filesystem::path& file);

/// How messages call that file.
const char* log_name(const std::filesystem::path& file);

/// What `read` returns. @throws DecodeError as it does, with the file's name in front
template <class Read>
auto naming_log(const std::filesystem::path& file, const Read& read) {
    try {
        return read();
    } catch (const DecodeError& error) {
        throw DecodeError(std::string(log_name(file)) + ": " + error.what());
    }
}

/// Says on the standard error if a log of so many bytes ends inside a frame: what is left of it is its whole frames.
void warn_if_cut(const LogLayout& layout, std::size_t n_bytes, const std::filesystem::path& file);

}  // namespace anyrate
