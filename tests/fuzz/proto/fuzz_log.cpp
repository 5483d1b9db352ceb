// Any bytes as a whole log. Checksums are made right first, or hardly any input would get past them; then the log is
// fed at once and byte by byte, which must come to the same, and sealed.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/colour_state.h"
#include "proto/crc32c.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"

namespace {

using namespace anyrate;

constexpr std::uint32_t largest_mesh = 4000;  // vertices; more would only be slow

void put_at(std::vector<std::byte>& bytes, std::size_t offset, std::uint32_t value) {
    ByteWriter word;
    word.put(value);
    std::ranges::copy(word.bytes(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
}

void make_checksums_right(std::vector<std::byte>& log) {
    if (log.size() < header_size) return;
    const std::span<const std::byte> bytes(log);
    ByteReader header(bytes.subspan(12), "header");
    const std::size_t header_bytes = header.take<std::uint32_t>();
    if (header_bytes < header_size || header_bytes > log.size()) return;
    put_at(log, 92, crc32c(bytes.subspan(header_size, header_bytes - header_size), crc32c(bytes.first(92))));
    for (std::size_t begin = header_bytes; begin + frame_header_size <= log.size();) {
        ByteReader frame(bytes.subspan(begin + 4), "frame");
        const std::size_t n = frame.take<std::uint32_t>();
        if (n > log.size() - begin - frame_header_size) return;
        put_at(log, begin + 24, crc32c(bytes.subspan(begin + frame_header_size, n), crc32c(bytes.subspan(begin, 24))));
        begin += frame_header_size + n;
    }
}

struct Outcome {
    std::optional<std::uint32_t> state_hash, colour_hash;  ///< at the end of the input, or where it was refused
    bool refused = false;
    friend bool operator==(const Outcome&, const Outcome&) = default;
};

/// Decodes a log that is fed in pieces of so many bytes.
Outcome decoded(std::span<const std::byte> log, std::size_t piece) {
    ModelDecoder decoder;
    decoder.set_max_vertices(largest_mesh);
    Outcome outcome;
    try {
        for (std::size_t i = 0; i < log.size(); i += piece)
            decoder.feed(log.subspan(i, std::min(piece, log.size() - i)));
    } catch (const DecodeError&) {
        outcome.refused = true;
    }
    if (decoder.state()) outcome.state_hash = decoder.state()->state_hash();
    if (decoder.colours()) outcome.colour_hash = decoder.colours()->hash();
    return outcome;
}

/// What can be decoded can be sealed, in packets of any size, and is the same model then.
void check_sealed(std::span<const std::byte> log, const Outcome& live) {
    for (const std::uint32_t splits_per_packet : {0u, 3u, 512u}) {
        std::vector<std::byte> sealed;
        try {
            sealed = seal_log(log, {}, {.splits_per_packet = splits_per_packet});
        } catch (const InputError&) {
            return;
        }
        if (live.refused) return;
        if (decoded(sealed, sealed.size()) != live) __builtin_trap();
        read_layout(sealed);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto input = std::as_bytes(std::span(data, size));
    std::vector<std::byte> log(input.begin(), input.end());
    make_checksums_right(log);
    const Outcome outcome = decoded(log, std::max<std::size_t>(log.size(), 1));
    if (decoded(log, 1) != outcome) __builtin_trap();
    try {
        read_layout(log);
    } catch (const DecodeError&) {
    }
    check_sealed(log, outcome);
    return 0;
}
