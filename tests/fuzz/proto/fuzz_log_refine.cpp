// One u16 (splits), then any bytes as a refine payload; what is accepted is replayed on an octahedron.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/refine_codec.h"

namespace {

const anyrate::BaseMesh octahedron = {
    {{900, 512, 512}, {512, 900, 512}, {512, 512, 900}, {124, 512, 512}, {512, 124, 512}, {512, 512, 124}},
    {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        ByteReader in(std::as_bytes(std::span(data, size)), "input");
        const auto n_splits = in.take<std::uint16_t>();
        const auto records = decode_refine(in.take_bytes(in.remaining()), n_splits, no_previous_face, 8);
        Grid grid;
        grid.bits = 10;
        RefinableMesh mesh(octahedron, grid, {});
        for (const SplitRecord& record : records) mesh.apply(record);
    } catch (const DecodeError&) {
    }
    return 0;
}
