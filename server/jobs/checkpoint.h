#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/reconstruction/refinement_journal.h"

namespace anyrate {

/// What is kept once, before the first frame of a log, for whoever may have to go on with it.
struct Checkpoint {
    std::uint64_t log_id = 0;
    RefinementStart start;
};

/// What is kept after the base and after each batch: how far the log was then, and what the refinement remembered.
struct LogMark {
    std::uint64_t n_bytes = 0;      ///< of the live log
    std::uint32_t n_rows = 0;       ///< of its index
    double seconds = 0;             ///< that workers had spent
    std::vector<char> is_rejected;  ///< one flag a face, see refine()
    friend bool operator==(const LogMark&, const LogMark&) = default;
};

// As bytes with a version and a checksum, and back. @throws DecodeError if they are damaged or of another version
std::vector<std::byte> encode_checkpoint(const Checkpoint& checkpoint);
Checkpoint decode_checkpoint(std::span<const std::byte> bytes);
std::vector<std::byte> encode_mark(const LogMark& mark);
LogMark decode_mark(std::span<const std::byte> bytes);

}  // namespace anyrate
