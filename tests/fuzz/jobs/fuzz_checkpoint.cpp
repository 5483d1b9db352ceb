// Any bytes between magic number and checksum of a checkpoint and of a mark; what is accepted encodes to the same bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"
#include "server/jobs/checkpoint.h"

namespace {

using namespace anyrate;

/// The bytes with the magic number of an empty sample in front and their checksum behind.
std::vector<std::byte> framed(std::span<const std::byte> sample, std::span<const std::byte> body) {
    ByteWriter out;
    out.put(sample.first(4));
    out.put(body);
    out.put(crc32c(out.bytes()));
    return out.take();
}

template <class Encode, class Decode>
void check(const std::vector<std::byte>& bytes, const Encode& encode, const Decode& decode) {
    try {
        if (encode(decode(bytes)) != bytes) std::abort();
    } catch (const DecodeError&) {
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto body = std::as_bytes(std::span(data, size));
    check(framed(encode_checkpoint({}), body), encode_checkpoint, decode_checkpoint);
    check(framed(encode_mark({}), body), encode_mark, decode_mark);
    try {
        decode_checkpoint(body);
    } catch (const DecodeError&) {
    }
    return 0;
}
