#include "proto/packet_plan.h"

#include <cmath>
#include <limits>

namespace anyrate {

namespace {

/// What a join spares: a frame, Draco's header and tables. On reconstructions of 10,000 vertices 140 to 145 bytes.
constexpr double spared_bytes = 140;
constexpr double row_bytes = 16;  ///< of the index, one for each frame

/// What a byte of a packet counts, by where the packet starts.
class ByteWeight {
public:
    ByteWeight(std::span<const LivePacket> packets, double whole_weight) : whole_weight_(whole_weight) {
        const LivePacket& last = packets.back();
        end_ = std::log(last.n_vertices_before + 3.0 * last.n_splits);
        range_ = end_ - std::log(static_cast<double>(packets.front().n_vertices_before));
    }

    /// Of every prefix.
    double ahead() const { return std::isinf(whole_weight_) ? 1 : 1 + whole_weight_; }
    /// A prefix reaches the packet with the probability that more vertices are asked for than stand before it.
    double of(const LivePacket& packet) const {
        if (std::isinf(whole_weight_)) return 1;
        return (end_ - std::log(static_cast<double>(packet.n_vertices_before))) / range_ + whole_weight_;
    }

private:
    double whole_weight_, end_ = 0, range_ = 1;
};

}  // namespace

std::vector<std::size_t> plan_packets(std::span<const LivePacket> packets, std::uint32_t max_splits,
                                      double whole_weight) {
    if (packets.empty()) return {};
    const ByteWeight weight(packets, whole_weight);
    // From the back: the least cost of packets i, i + 1, .. and how many form the first group of them.
    std::vector<double> cost(packets.size() + 1, 0.0);
    std::vector<std::size_t> group(packets.size(), 1);
    for (std::size_t i = packets.size(); i-- > 0;) {
        cost[i] = std::numeric_limits<double>::infinity();
        const double rows = (packets[i].has_colours ? 2.0 : 1.0) * row_bytes * weight.ahead();
        double n_bytes = spared_bytes;
        std::uint64_t n_splits = 0;
        for (std::size_t j = i; j < packets.size(); ++j) {
            n_splits += packets[j].n_splits;
            n_bytes += packets[j].n_bytes - spared_bytes;
            const bool joins = n_splits <= max_splits && packets[j].has_colours == packets[i].has_colours;
            if (j > i && !joins) break;
            const double whole = weight.of(packets[i]) * n_bytes + rows + cost[j + 1];
            if (whole > cost[i]) continue;  // of equals the longest
            cost[i] = whole;
            group[i] = j + 1 - i;
        }
    }
    std::vector<std::size_t> groups;
    for (std::size_t i = 0; i < packets.size(); i += group[i]) groups.push_back(group[i]);
    return groups;
}

}  // namespace anyrate
