#include "proto/log_writer.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/error.h"
#include "proto/base_codec.h"
#include "proto/colour_codec.h"
#include "proto/colour_state.h"
#include "proto/frame.h"
#include "proto/header.h"
#include "proto/log_reader.h"
#include "proto/refine_codec.h"

namespace anyrate {

namespace {

constexpr float unknown = std::numeric_limits<float>::quiet_NaN();

/// A frame that is ready to leave, and the row that goes with it.
struct Outgoing {
    std::vector<std::byte> bytes;
    IndexRow row;
};

void require_rows_of(const LogLayout& layout, std::span<const IndexRow> rows) {
    const auto is_of = [&](const IndexRow& row, const FrameInfo& frame) {
        return row.n_vertices == frame.n_vertices_after && layout.frames_begin + row.end == frame.end();
    };
    if (!std::ranges::equal(rows, layout.frames, is_of))
        throw DecodeError("log writer: expected one row for each of the log's " + std::to_string(layout.frames.size()) +
                          " frames");
}

}  // namespace

/// What the writer knows after the base: the replica replays what was encoded, so every hash is that of a decoder.
struct LogWriter::State {
    std::uint64_t log_id = 0;
    ByteSink on_bytes;
    ColourCoding colour_coding;
    std::optional<RefinableMesh> replica;
    std::optional<ColourState> colours;
    bool has_base_colours = false;
    bool finished = false;
    std::vector<IndexRow> rows;
    std::uint32_t next_sequence = 0;
    std::uint32_t end = 0;  ///< of the last frame, relative to the first

    std::uint32_t n_vertices() const { return static_cast<std::uint32_t>(replica->n_vertices()); }

    void require_open() const {
        if (!replica || finished)
            throw InputError("log writer: expected start() before, and finish() behind, all else");
    }

    Outgoing frame(FrameInfo info, std::span<const std::byte> payload, const DistortionPoint& distortion) {
        info.sequence = next_sequence++;
        Outgoing out{encode_frame(info, payload), {}};
        if (out.bytes.size() > std::numeric_limits<std::uint32_t>::max() - end) {
            throw InputError("log writer: the log exceeds 4 GiB");
        }
        end += static_cast<std::uint32_t>(out.bytes.size());
        out.row = {n_vertices(), end, static_cast<float>(distortion.mean), static_cast<float>(distortion.max)};
        return out;
    }

    void send(const Outgoing& out) {
        on_bytes(out.bytes);
        rows.push_back(out.row);
    }

    /// Takes the colours of a frame as near to the wished ones as bits are worth it: once on trial, to see what its
    /// tables will be, then by these.
    /// @param correct  corrects the frame's vertices in a state, asking for each residual
    template <class Correct>
    std::vector<ColourResidual> correct_colours(std::span<const Rgb8> wished, Correct&& correct) {
        ColourRounding rounding(colour_coding);
        std::vector<ColourResidual> residuals;
        const auto choose = [&](std::size_t i, const Rgb8& prediction) {
            return residuals.emplace_back(rounding.residual(prediction, wished[i]));
        };
        if (colour_coding.bit_price > 0) {
            ColourState trial = *colours;
            correct(trial, choose);
            rounding.learn(residuals);
            residuals.clear();
        }
        correct(*colours, choose);
        return residuals;
    }

    /// Replays one packet and encodes it, with its colours if there are any.
    void packet(std::span<const SplitRecord> records, std::span<const Rgb8> new_colours, std::int32_t previous_face,
                const DistortionPoint& distortion, std::vector<Outgoing>& frames);
};

LogWriter::LogWriter(std::uint64_t log_id, ByteSink on_bytes, const ColourCoding& colour)
    : state_(std::make_unique<State>()) {
    state_->log_id = log_id;
    state_->colour_coding = colour;
    state_->on_bytes = std::move(on_bytes);
}

LogWriter::LogWriter(std::span<const std::byte> front, std::span<const IndexRow> rows, ByteSink on_bytes,
                     double bit_price)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    const LogLayout layout = read_layout(front);
    if (layout.header.sealed || layout.ended || layout.frames.empty() || layout.whole_bytes != front.size())
        throw DecodeError("log writer: expected the front of a live log, whole frames from its base on and no end");
    require_rows_of(layout, rows);
    ModelDecoder decoder;
    decoder.feed(front);
    s.log_id = layout.header.log_id;
    s.colour_coding = {.steps = layout.header.colour_steps, .bit_price = bit_price};
    s.on_bytes = std::move(on_bytes);
    s.replica = *decoder.state();
    s.colours = *decoder.colours();
    s.has_base_colours = layout.frames.size() > 1 && layout.frames[1].type == FrameType::colour;
    s.rows.assign(rows.begin(), rows.end());
    s.next_sequence = layout.frames.back().sequence + 1;
    s.end = rows.back().end;
}

LogWriter::~LogWriter() = default;

BaseMesh LogWriter::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    State& s = *state_;
    if (s.replica) throw InputError("log writer: started twice");
    const RefinableMesh checked(base, grid, rules);  // refuses what Draco would silently repair
    Header header;
    header.log_id = s.log_id;
    header.grid = grid;
    header.rules = rules;
    header.colour_steps = s.colour_coding.steps;
    header.n_base_vertices = static_cast<std::uint32_t>(checked.n_vertices());
    header.n_base_faces = static_cast<std::uint32_t>(checked.n_faces());
    const std::vector<std::byte> header_bytes = encode_header(header);
    const std::vector<std::byte> payload = encode_base(base, grid.base_shift);
    BaseMesh decoded = decode_base(payload, header);

    s.replica.emplace(decoded, grid, rules);
    s.colours.emplace(header.colour_steps);
    s.colours->predict_base(decoded.positions.size());
    s.on_bytes(header_bytes);
    s.send(s.frame({.type = FrameType::base, .state_hash = s.replica->state_hash()}, payload, {unknown, unknown}));
    return decoded;
}

void LogWriter::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    State& s = *state_;
    s.require_open();
    if (s.rows.size() != 1) throw InputError("log writer: the base's attributes come once, directly behind the base");
    s.rows[0].mean_distortion = static_cast<float>(distortion.mean);
    s.rows[0].max_distortion = static_cast<float>(distortion.max);
    if (colours.empty()) return;
    if (colours.size() != s.n_vertices()) {
        throw InputError("log writer: expected " + std::to_string(s.n_vertices()) + " base colours, got " +
                         std::to_string(colours.size()));
    }
    const std::vector<ColourResidual> residuals = s.correct_colours(
        colours,
        [&](ColourState& state, const ColourState::ChooseResidual& choose) { state.correct_base(*s.replica, choose); });
    s.has_base_colours = true;
    s.send(s.frame({.type = FrameType::colour, .flags = frame_flag_ancillary, .state_hash = s.colours->hash()},
                   encode_colour(residuals), distortion));
}

void LogWriter::State::packet(std::span<const SplitRecord> records, std::span<const Rgb8> new_colours,
                              std::int32_t previous_face, const DistortionPoint& distortion,
                              std::vector<Outgoing>& frames) {
    const std::vector<std::byte> payload = encode_refine(records, previous_face, replica->n_faces());
    const std::uint32_t before = n_vertices();
    std::vector<EdgeEnds> ends;
    for (const SplitRecord& record : records) {
        const Triangle corners =
            replica->split_site(record.face)
                ? replica->triangles()[static_cast<std::size_t>(record.face)]
                : throw InputError("batch: face " + std::to_string(record.face) + " cannot be split");
        replica->apply(record);
        for (std::size_t i = 0; i < 3; ++i) ends.push_back({corners[i], corners[(i + 1) % 3]});
    }
    FrameInfo info{.type = FrameType::refine, .n_vertices_before = before, .state_hash = replica->state_hash()};
    info.flags = previous_face == no_previous_face ? frame_flag_new_batch : std::uint8_t{0};
    info.n_splits = static_cast<std::uint32_t>(records.size());
    frames.push_back(frame(info, payload, distortion));

    colours->predict(ends);
    if (new_colours.empty()) return;
    const std::vector<ColourResidual> residuals = correct_colours(
        new_colours,
        [&](ColourState& state, const ColourState::ChooseResidual& choose) { state.correct(before, ends, choose); });
    info.type = FrameType::colour;
    info.flags = frame_flag_ancillary;
    info.state_hash = colours->hash();
    frames.push_back(frame(info, encode_colour(residuals), distortion));
}

void LogWriter::batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                      std::span<const Rgb8> new_colours, const DistortionPoint& distortion) {
    State& s = *state_;
    s.require_open();
    if (records.empty()) return;
    if (new_colours.size() != (s.has_base_colours ? 3 * records.size() : 0)) {
        throw InputError("log writer: expected three colours per split, as the base has colours, or none at all; got " +
                         std::to_string(new_colours.size()) + " for " + std::to_string(records.size()) + " splits");
    }
    const auto descend = [](const SplitRecord& a, const SplitRecord& b) { return a.face >= b.face; };
    if (std::ranges::adjacent_find(records, descend) != records.end()) {
        throw InputError("log writer: expected the faces of a batch to ascend");
    }
    const std::size_t n_packets = (records.size() + max_splits_per_frame - 1) / max_splits_per_frame;
    const DistortionPoint before{s.rows.back().mean_distortion, s.rows.back().max_distortion};
    std::vector<Outgoing> frames;
    std::int32_t previous_face = no_previous_face;
    for (std::size_t k = 0; k < n_packets; ++k) {  // equal shares: a short last packet would cost its own tables
        const std::size_t begin = records.size() * k / n_packets, end = records.size() * (k + 1) / n_packets;
        const auto share = records.subspan(begin, end - begin);
        s.packet(share, new_colours.empty() ? new_colours : new_colours.subspan(3 * begin, 3 * share.size()),
                 previous_face, k + 1 == n_packets ? distortion : before, frames);
        previous_face = share.back().face;
    }
    if (s.replica->state_hash() != state.state_hash() || s.replica->n_vertices() != state.n_vertices()) {
        throw InputError("log writer: the records of the batch do not lead to its state");
    }
    for (const Outgoing& out : frames) s.send(out);
}

void LogWriter::finish() {
    State& s = *state_;
    s.require_open();
    s.finished = true;
    s.on_bytes(
        s.frame({.type = FrameType::end, .n_vertices_before = s.n_vertices(), .state_hash = s.replica->state_hash()},
                {}, {})
            .bytes);
}

std::span<const IndexRow> LogWriter::rows() const { return state_->rows; }

const RefinableMesh& LogWriter::state() const { return *state_->replica; }

}  // namespace anyrate
