#include <doctest/doctest.h>

#include "core/error.h"
#include "proto/frame.h"
#include "proto/log_order.h"

namespace anyrate {
namespace {

std::vector<std::byte> payload_of(std::size_t n) { return std::vector<std::byte>(n, std::byte{0xAB}); }

Header header_of(bool sealed) {
    Header header;
    header.n_base_vertices = 6;
    header.n_base_faces = 8;
    header.sealed = sealed;
    return header;
}

FrameInfo base() { return {.type = FrameType::base}; }
FrameInfo refine(std::uint32_t sequence, std::uint32_t before, std::uint32_t splits) {
    FrameInfo frame{.type = FrameType::refine, .flags = frame_flag_new_batch, .sequence = sequence};
    frame.n_vertices_before = before;
    frame.n_splits = splits;
    return frame;
}
FrameInfo colour(std::uint32_t sequence, std::uint32_t before, std::uint32_t splits) {
    FrameInfo frame = refine(sequence, before, splits);
    frame.type = FrameType::colour;
    frame.flags = frame_flag_ancillary;
    return frame;
}
FrameInfo end(std::uint32_t sequence, std::uint32_t before) {
    return {.type = FrameType::end, .sequence = sequence, .n_vertices_before = before};
}

}  // namespace

TEST_CASE("Frame: reading gives back what was written, and where it stood") {
    FrameInfo frame = refine(7, 2502, 100);
    frame.state_hash = 0xDEADBEEF;
    const auto bytes = encode_frame(frame, payload_of(33));
    REQUIRE(bytes.size() == frame_header_size + 33);
    const auto read = read_frame(bytes, 1000);
    REQUIRE(read);
    CHECK(read->type == FrameType::refine);
    CHECK(read->flags == frame_flag_new_batch);
    CHECK(read->sequence == 7);
    CHECK(read->n_vertices_before == 2502);
    CHECK(read->n_splits == 100);
    CHECK(read->state_hash == 0xDEADBEEF);
    CHECK(read->begin == 1000);
    CHECK(read->end() == 1000 + bytes.size());
}

TEST_CASE("Frame: every truncation is 'not yet', every flipped bit is an error or 'not yet'") {
    const auto bytes = encode_frame(refine(0, 6, 2), payload_of(20));
    for (std::size_t size = 0; size < bytes.size(); ++size) CHECK_FALSE(read_frame(std::span(bytes).first(size), 0));
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        auto damaged = bytes;
        damaged[bit / 8] ^= std::byte{1} << (bit % 8);
        bool taken = true;
        try {
            taken = read_frame(damaged, 0).has_value();
        } catch (const DecodeError&) {
            taken = false;
        }
        CHECK_FALSE(taken);
    }
}

TEST_CASE("Frame: sizes beyond the limits are refused before the payload has arrived") {
    auto bytes = encode_frame(refine(0, 6, 2), {});
    bytes[6] = std::byte{0x20};  // 2^21 payload bytes
    CHECK_THROWS_AS(read_frame(bytes, 0), DecodeError);
    CHECK_THROWS_AS(read_frame(encode_frame(refine(0, 6, 0), {}), 0), DecodeError);
    CHECK_THROWS_AS(read_frame(encode_frame(refine(0, 6, 2049), {}), 0), DecodeError);
}

TEST_CASE("Log order: base, refinements and colours in turn are accepted and counted") {
    LogOrder order(header_of(false));
    std::vector<FrameInfo> frames = {base(),          colour(1, 0, 0),  refine(2, 6, 2),
                                     colour(3, 6, 2), refine(4, 12, 1), end(5, 15)};
    for (FrameInfo& frame : frames) order.accept(frame);
    CHECK(order.ended());
    CHECK(frames[1].n_vertices_after == 6);
    CHECK(frames[3].n_vertices_after == 12);
    CHECK(frames[5].n_vertices_after == 15);
}

TEST_CASE("Log order: what does not fit is refused and changes nothing") {
    LogOrder order(header_of(false));
    const auto refused = [&](FrameInfo frame) { CHECK_THROWS_AS(order.accept(frame), DecodeError); };
    const auto accepted = [&](FrameInfo frame) { CHECK_NOTHROW(order.accept(frame)); };
    refused(refine(0, 6, 1));  // no base yet
    refused({.type = FrameType::index, .sequence = index_sequence});
    refused({.type = FrameType::base, .sequence = 1});
    accepted(base());
    refused({.type = FrameType::base, .sequence = 1});
    refused(refine(2, 6, 1));  // sequence
    refused(refine(1, 9, 1));  // vertices before
    refused(colour(1, 0, 1));  // not its frame
    FrameInfo continued = refine(1, 6, 1);
    continued.flags = 0;
    refused(continued);  // a batch that goes on before one began
    FrameInfo flagged = refine(1, 6, 1);
    flagged.flags |= 0x02;
    refused(flagged);  // a flag to come
    flagged.flags = frame_flag_new_batch | frame_flag_ancillary;
    refused(flagged);
    accepted(refine(1, 6, 1));
    accepted(colour(2, 6, 1));
    refused(colour(3, 6, 1));  // twice
    refused(end(3, 6));        // vertices
    accepted(end(3, 9));
    refused(refine(4, 9, 1));  // behind the end
}

TEST_CASE("Log order: unknown frames are skipped if geometry does not need them") {
    LogOrder order(header_of(false));
    FrameInfo first = base();
    order.accept(first);
    FrameInfo unknown{.type = static_cast<FrameType>(9), .sequence = 1};
    CHECK_THROWS_AS(order.accept(unknown), DecodeError);
    unknown.flags = frame_flag_ancillary | 0x10;
    CHECK_NOTHROW(order.accept(unknown));
    FrameInfo next = refine(2, 6, 1);
    CHECK_NOTHROW(order.accept(next));
}

TEST_CASE("Log order: a sealed log has its index first") {
    LogOrder order(header_of(true));
    FrameInfo first = base();
    CHECK_THROWS_AS(order.accept(first), DecodeError);
    FrameInfo index{.type = FrameType::index, .sequence = index_sequence};
    order.accept(index);
    CHECK_THROWS_AS(order.accept(index), DecodeError);
    CHECK_NOTHROW(order.accept(first));
}

}  // namespace anyrate
