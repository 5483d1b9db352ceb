// Any bytes as a header: refused, or a header that encodes again to an equal one.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/error.h"
#include "proto/header.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        const Header header = decode_header(std::as_bytes(std::span(data, size)));
        const Header again = decode_header(encode_header(header));
        if (again.grid != header.grid || again.rules != header.rules || again.log_id != header.log_id) __builtin_trap();
    } catch (const DecodeError&) {
    }
    return 0;
}
