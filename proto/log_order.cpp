#include "proto/log_order.h"

#include <string>

#include "core/error.h"

namespace anyrate {

namespace {

void require(const FrameInfo& frame, bool holds, const std::string& expectation) {
    if (holds) return;
    throw DecodeError(std::string(frame_type_name(frame.type)) + " frame " + std::to_string(frame.sequence) +
                      " at offset " + std::to_string(frame.begin) + ": expected " + expectation);
}

bool is_known(FrameType type) { return type <= FrameType::colour; }

}  // namespace

LogOrder::LogOrder(const Header& header)
    : n_base_vertices_(header.n_base_vertices), stage_(header.sealed ? Stage::index : Stage::base) {}

void LogOrder::accept(FrameInfo& frame) {
    require(frame, stage_ != Stage::ended, "nothing behind the end frame");
    check_flags(frame);
    const bool is_index = frame.type == FrameType::index;
    const std::uint32_t sequence = is_index ? index_sequence : next_sequence_;
    require(frame, frame.sequence == sequence, "sequence number " + std::to_string(sequence));
    require(frame, is_index == (stage_ == Stage::index), "an index exactly behind the header of a sealed log");
    require(frame, is_index || (frame.type == FrameType::base) == (stage_ == Stage::base), "the base first, and once");
    check_type(frame);

    if (!is_index) ++next_sequence_;
    const bool is_geometry = frame.type == FrameType::base || frame.type == FrameType::refine;
    if (frame.type == FrameType::base) n_vertices_ = n_base_vertices_;
    if (frame.type == FrameType::refine) n_vertices_ += 3 * frame.n_splits;
    if (is_geometry) state_hash_ = frame.state_hash;
    batch_started_ |= frame.type == FrameType::refine;
    frame.n_vertices_after = n_vertices_;
    colourable_ = is_geometry ? std::optional(frame) : std::nullopt;
    stage_ = is_index ? Stage::base : frame.type == FrameType::end ? Stage::ended : Stage::body;
}

void LogOrder::check_flags(const FrameInfo& frame) const {
    const bool ancillary = (frame.flags & frame_flag_ancillary) != 0;
    if (!is_known(frame.type)) {
        require(frame, ancillary, "a known frame type, or one that geometry does not need");
        return;
    }
    require(frame, ancillary == (frame.type == FrameType::colour), "the ancillary flag on colour frames only");
    const std::uint8_t others = frame.flags & static_cast<std::uint8_t>(~frame_flag_ancillary);
    require(frame, others == 0 || (others == frame_flag_new_batch && frame.type == FrameType::refine),
            "no flag that this version does not know");
}

void LogOrder::check_type(const FrameInfo& frame) const {
    switch (frame.type) {
        case FrameType::index:
        case FrameType::base:
            require(frame, frame.n_vertices_before == 0 && frame.n_splits == 0, "no vertices before and no splits");
            break;
        case FrameType::refine:
            require(frame, frame.n_vertices_before == n_vertices_,
                    std::to_string(n_vertices_) + " vertices before, got " + std::to_string(frame.n_vertices_before));
            require(frame, n_vertices_ + 3 * frame.n_splits <= std::uint32_t{max_log_vertices},
                    "at most 2^24 vertices");
            require(frame, batch_started_ || (frame.flags & frame_flag_new_batch) != 0,
                    "the first packet to start a batch");
            break;
        case FrameType::colour:
            require(frame,
                    colourable_ && frame.n_vertices_before == colourable_->n_vertices_before &&
                        frame.n_splits == colourable_->n_splits,
                    "the base or refine frame that it colours directly before");
            break;
        case FrameType::end:
            require(frame,
                    frame.n_vertices_before == n_vertices_ && frame.n_splits == 0 && frame.payload_bytes == 0 &&
                        frame.state_hash == state_hash_,
                    "the vertices and the hash of the log, and no payload");
            break;
    }
}

}  // namespace anyrate
