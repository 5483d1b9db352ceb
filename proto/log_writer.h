#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/progressive/model_sink.h"
#include "proto/colour_rounding.h"
#include "proto/header.h"
#include "proto/index.h"

namespace anyrate {

/// Takes the next bytes of a log; called once per whole header or frame. It may throw IoError.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Encodes a model as it is made: header, base, colours, then refine and colour frames, each handed to the byte sink as
/// soon as it is whole (the live form of proto/FORMAT.md, no index). After each frame rows() has one more row.
/// Calls out of order, records that do not lead to the given state, and faces that do not ascend are InputErrors; after
/// any exception the log is whole up to its last frame, and the writer is of no more use.
class LogWriter final : public ModelSink {
public:
    /// @param log_id   identity of the model, also its ETag; any value
    /// @param on_bytes receives the live log, in order
    LogWriter(std::uint64_t log_id, ByteSink on_bytes, const ColourCoding& colour = {});
    /// Goes on behind a batch, or behind the base's attributes, of a live log that another writer began: the sink gets
    /// what comes next.
    /// @param front  the log up to there, from its first byte
    /// @param rows   of its frames, as that writer gave them
    /// @param bit_price  of colours, as that writer had it; their steps stand in the log
    /// @throws DecodeError if `front` is no such log, or the rows are not those of its frames
    LogWriter(std::span<const std::byte> front, std::span<const IndexRow> rows, ByteSink on_bytes,
              double bit_price = ColourCoding{}.bit_price);
    ~LogWriter() override;

    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override;

    std::span<const IndexRow> rows() const;
    /// As every decoder has it after the last frame. start() must have been called, or the log be continued.
    const RefinableMesh& state() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

struct SealOptions {
    /// Neighbouring packets become one of up to so many splits; 0 leaves every frame as it is.
    std::uint32_t splits_per_packet = 2048;
    /// What a byte of the whole log counts beside one of the expected prefix (plan_packets). Large packets spare
    /// Draco's tables and our frames, but a budget is answered with whole ones. Beside the live logs of four
    /// reconstructions of 10,000 vertices 1 takes 6 to 11 % off the whole and 0.3 to 2 % off the mean prefix; 0.5 takes
    /// 5 to 9 % and 0.5 to 4 % off; 2 would take 7 to 12 % off the whole, and lengthen the prefix of three of them.
    double whole_weight = 1;
};

/// As few packets as a number of splits allows, whatever that does to prefixes.
inline SealOptions largest_packets(std::uint32_t splits_per_packet) {
    return {.splits_per_packet = splits_per_packet, .whole_weight = std::numeric_limits<double>::infinity()};
}

/// The sealed form of a live log: the same refinements in fewer packets, with the index right behind the header and an
/// end frame. A live log that ends early is sealed at its last whole frame (with its colours, if they are there).
/// `rows` gives the distortions, by number of vertices; where there is none it is NaN.
/// @throws DecodeError if `live` is no log
std::vector<std::byte> seal_log(std::span<const std::byte> live, std::span<const IndexRow> rows,
                                const SealOptions& options = {});

}  // namespace anyrate
