#pragma once
#include <cstdint>
#include <optional>

#include "proto/frame.h"
#include "proto/header.h"

namespace anyrate {

/// The grammar of a log: which frame may follow which, with sequence numbers and vertex counts that fit together
/// (proto/FORMAT.md, "File" and "Frame"). Knows no payload.
class LogOrder {
public:
    explicit LogOrder(const Header& header);

    /// Takes the next frame and fills in its n_vertices_after. @throws DecodeError if it may not stand here; then
    /// nothing changes
    void accept(FrameInfo& frame);

    bool ended() const { return stage_ == Stage::ended; }
    std::uint32_t n_vertices() const { return n_vertices_; }  ///< after the last frame
    std::uint32_t next_sequence() const { return next_sequence_; }
    std::uint32_t state_hash() const { return state_hash_; }  ///< of the geometry after the last frame

private:
    enum class Stage { index, base, body, ended };
    void check_flags(const FrameInfo& frame) const;
    void check_type(const FrameInfo& frame) const;

    std::uint32_t n_base_vertices_;
    Stage stage_;
    std::uint32_t n_vertices_ = 0;
    std::uint32_t next_sequence_ = 0;
    std::uint32_t state_hash_ = 0;
    bool batch_started_ = false;
    std::optional<FrameInfo> colourable_;  ///< the frame directly before, if it is base or refine
};

}  // namespace anyrate
