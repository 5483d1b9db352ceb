#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/progressive/refinable_mesh.h"
#include "proto/frame.h"
#include "proto/header.h"
#include "proto/index.h"

namespace anyrate {

class ColourState;

/// What a log's framing says, without decoding a payload.
struct LogLayout {
    Header header;
    std::vector<IndexRow> index;     ///< of a sealed log; rebuilt from the frames (NaN distortion) where there is none
    std::uint64_t frames_begin = 0;  ///< offset of the first frame (base) in the file
    std::vector<FrameInfo> frames;   ///< whole frames only, in file order (index and end frames too)
    std::uint64_t whole_bytes = 0;   ///< the file is sound up to here; less than its size if it was cut
    bool ended = false;              ///< an end frame was there
};

/// Walks header and frames and checks every checksum. A log that is cut inside a frame gives the frames before it.
/// @throws DecodeError if the header is not whole and sound, or a whole frame's checksum or order is wrong
LogLayout read_layout(std::span<const std::byte> log);

/// Decodes a log frame by frame as bytes arrive.
class ModelDecoder {
public:
    ModelDecoder();
    ~ModelDecoder();
    ModelDecoder(ModelDecoder&&) noexcept;
    ModelDecoder& operator=(ModelDecoder&&) noexcept;

    /// Takes the next bytes of a log, of any length, and replays every frame that is whole by then, but no split beyond
    /// `max_vertices` (the rest of such a frame is kept, for a later raise). @throws DecodeError: the mesh stays
    /// the closed manifold before the split or frame at fault, and every later call throws the same again
    void feed(std::span<const std::byte> bytes);
    /// Sets the vertex budget and replays what it newly allows of the frames that are there. Splits already replayed
    /// stay, so lowering it only holds back later ones. 0xFFFFFFFF, the default, is all. @throws DecodeError
    void set_max_vertices(std::uint32_t max_vertices);

    const Header* header() const;                        ///< nullptr before it has arrived
    const RefinableMesh* state() const;                  ///< nullptr before the base has arrived
    std::optional<std::uint32_t> last_sequence() const;  ///< of the last whole frame
    bool ended() const;
    const ColourState* colours() const;  ///< nullptr before the base has arrived
    /// The mesh so far, with colours. The base must have arrived.
    Mesh mesh() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The mesh of a log at a budget: 0 to 2 vertices below a vertex budget that the log reaches.
/// @throws DecodeError
Mesh decode_mesh(std::span<const std::byte> log, const Budget& budget);

/// Every checksum and state hash. @return the number of frames checked @throws DecodeError naming the frame
std::size_t verify_log(std::span<const std::byte> log);

}  // namespace anyrate
