#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/colour_codec.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "proto/packet_plan.h"
#include "proto/refine_codec.h"

namespace anyrate {

namespace {

/// A refine frame of the live log and the colours directly behind it.
struct Packet {
    FrameInfo refine;
    std::optional<FrameInfo> colour;
};

/// The mean and largest distortion at a number of vertices.
std::optional<IndexRow> row_at(std::span<const IndexRow> rows, std::uint32_t n_vertices) {
    const auto row = std::ranges::lower_bound(rows, n_vertices, {}, &IndexRow::n_vertices);
    return row != rows.end() && row->n_vertices == n_vertices ? std::optional(*row) : std::nullopt;
}

/// Takes the frames of a live log in order and gives those of its sealed form, from the base on.
class Repacker {
public:
    Repacker(std::span<const std::byte> live, const Header& header, const SealOptions& options)
        : live_(live), header_(header), options_(options) {}

    void take(const FrameInfo& frame) {
        if (frame.type == FrameType::refine) {
            waiting_.push_back({frame, std::nullopt});
        } else if (frame.type == FrameType::colour && frame.n_splits != 0) {
            waiting_.back().colour = frame;
        } else {
            flush();
            put(frame, payload_of(frame));
        }
    }

    /// Writes the packets that wait for more to join them.
    void flush() {
        std::vector<LivePacket> packets;
        for (const auto& [refine, colour] : waiting_) {
            const auto n_bytes = static_cast<std::uint32_t>(frame_header_size) + refine.payload_bytes;
            packets.push_back({refine.n_vertices_before, refine.n_splits, n_bytes, colour.has_value()});
        }
        std::span<const Packet> rest(waiting_);
        const std::uint32_t most = std::min(options_.splits_per_packet, max_splits_per_frame);
        for (const std::size_t n : plan_packets(packets, most, options_.whole_weight)) {
            put_packets(rest.first(n));
            rest = rest.subspan(n);
        }
        waiting_.clear();
    }

    /// An end frame, if the live log has none.
    void put_end(std::uint32_t n_vertices, std::uint32_t state_hash) {
        put({.type = FrameType::end, .n_vertices_before = n_vertices, .state_hash = state_hash}, {});
    }

    std::span<const std::byte> bytes() const { return out_.bytes(); }

    /// One row per base, refine and colour frame, with the distortions of `known` where that has the vertices.
    std::vector<IndexRow> rows(std::span<const IndexRow> known) const {
        constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
        std::vector<IndexRow> rows = rows_;
        for (IndexRow& row : rows) {
            const IndexRow found = row_at(known, row.n_vertices).value_or(IndexRow{0, 0, unknown, unknown});
            row.mean_distortion = found.mean_distortion;
            row.max_distortion = found.max_distortion;
        }
        return rows;
    }

private:
    std::span<const std::byte> payload_of(const FrameInfo& frame) const {
        return live_.subspan(static_cast<std::size_t>(frame.begin) + frame_header_size, frame.payload_bytes);
    }

    std::int32_t n_faces_before(const FrameInfo& refine) const {
        return static_cast<std::int32_t>(header_.n_base_faces +
                                         2 * (refine.n_vertices_before - header_.n_base_vertices));
    }

    void put_packets(std::span<const Packet> packets) {
        const bool starts_batch = (packets[0].refine.flags & frame_flag_new_batch) != 0;
        const std::int32_t face_before = starts_batch ? no_previous_face : previous_face_;
        const std::vector<SplitRecord> records = records_of(packets);
        if (packets.size() == 1) {  // Draco's bytes as they are
            put(packets[0].refine, payload_of(packets[0].refine));
            if (packets[0].colour) put(*packets[0].colour, payload_of(*packets[0].colour));
            return;
        }
        FrameInfo refine = packets[0].refine;
        refine.n_splits = static_cast<std::uint32_t>(records.size());
        refine.state_hash = packets.back().refine.state_hash;
        refine.n_vertices_after = packets.back().refine.n_vertices_after;
        put(refine, encode_refine(records, face_before, n_faces_before(refine)));
        if (!packets[0].colour) return;
        FrameInfo colour = refine;
        colour.type = FrameType::colour;
        colour.flags = frame_flag_ancillary;
        colour.state_hash = packets.back().colour->state_hash;
        put(colour, encode_colour(residuals_of(packets)));
    }

    std::vector<SplitRecord> records_of(std::span<const Packet> packets) {
        std::vector<SplitRecord> all;
        for (const Packet& packet : packets) {
            const bool starts_batch = (packet.refine.flags & frame_flag_new_batch) != 0;
            const auto records =
                decode_refine(payload_of(packet.refine), packet.refine.n_splits,
                              starts_batch ? no_previous_face : previous_face_, n_faces_before(packet.refine));
            previous_face_ = records.back().face;
            all.insert(all.end(), records.begin(), records.end());
        }
        return all;
    }

    std::vector<ColourResidual> residuals_of(std::span<const Packet> packets) const {
        std::vector<ColourResidual> all;
        for (const Packet& packet : packets) {
            const auto residuals = decode_colour(payload_of(*packet.colour), 3 * std::size_t{packet.colour->n_splits});
            all.insert(all.end(), residuals.begin(), residuals.end());
        }
        return all;
    }

    void put(FrameInfo frame, std::span<const std::byte> payload) {
        frame.sequence = next_sequence_++;
        out_.put(encode_frame(frame, payload));
        if (frame.type == FrameType::base || frame.type == FrameType::refine || frame.type == FrameType::colour) {
            rows_.push_back({frame.n_vertices_after, static_cast<std::uint32_t>(out_.bytes().size()), 0, 0});
        }
    }

    std::span<const std::byte> live_;
    const Header& header_;
    SealOptions options_;
    std::vector<Packet> waiting_;
    std::int32_t previous_face_ = no_previous_face;
    std::uint32_t next_sequence_ = 0;
    ByteWriter out_;
    std::vector<IndexRow> rows_;
};

}  // namespace

std::vector<std::byte> seal_log(std::span<const std::byte> live, std::span<const IndexRow> rows,
                                const SealOptions& options) {
    const LogLayout layout = read_layout(live);
    if (layout.header.sealed) throw DecodeError("seal: the log is sealed already");
    if (layout.frames.empty()) throw DecodeError("seal: the log has no whole base");

    Repacker repacker(live, layout.header, options);
    std::uint32_t state_hash = 0;
    for (const FrameInfo& frame : layout.frames) {
        repacker.take(frame);
        if (frame.type == FrameType::base || frame.type == FrameType::refine) state_hash = frame.state_hash;
    }
    repacker.flush();
    if (!layout.ended) repacker.put_end(layout.frames.back().n_vertices_after, state_hash);

    ByteWriter out;
    out.put(sealed_header(live));
    out.put(
        encode_frame({.type = FrameType::index, .sequence = index_sequence}, encode_index_rows(repacker.rows(rows))));
    out.put(repacker.bytes());
    return out.take();
}

}  // namespace anyrate
