// Range, If-Range and If-None-Match fields, of representations of several sizes.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <variant>

#include "server/http/range.h"

using namespace anyrate;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view field(reinterpret_cast<const char*>(data), size);
    for (const std::uint64_t bytes : {std::uint64_t(0), std::uint64_t(1), std::uint64_t(1000), UINT64_MAX}) {
        const RangeAnswer answer = parse_range(field, bytes);
        const auto* range = std::get_if<ByteRange>(&answer);
        if (range && (range->begin >= range->end || range->end > bytes)) std::abort();
    }
    matches_etag(field, "\"tag\"");
    if_range_holds(field, "\"tag\"");
    return 0;
}
