#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace anyrate {

/// A refine frame of a live log, as far as a plan needs to know it.
struct LivePacket {
    std::uint32_t n_vertices_before = 0, n_splits = 0;
    std::uint32_t n_bytes = 0;  ///< of the frame
    bool has_colours = false;
};

/// Which neighbouring packets become one in the sealed form. A joined packet spares tables and framing, but a budget is
/// answered with whole packets. The plan makes least: expected bytes of a prefix, if the logarithm of the vertices
/// asked for is spread evenly over the log, plus `whole_weight` times the bytes of the whole; how much joining spares
/// is an estimate (the average of four reconstructions).
/// @param packets       of one log, in order
/// @param max_splits    of a joined packet; a single packet may have more
/// @param whole_weight  0 or more; infinite: only the whole counts
/// @return how many packets each group has, in order; all of a group have colours, or none has
std::vector<std::size_t> plan_packets(std::span<const LivePacket> packets, std::uint32_t max_splits,
                                      double whole_weight);

}  // namespace anyrate
