// ModelDecoder: bytes are gathered to frames, frames to geometry packets, and packets replayed as far as the budget
// goes.
#include <deque>
#include <exception>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "proto/base_codec.h"
#include "proto/colour_codec.h"
#include "proto/colour_state.h"
#include "proto/log_order.h"
#include "proto/log_reader.h"
#include "proto/refine_codec.h"

namespace anyrate {

namespace {

/// A refine frame that is being replayed, with its colours once they are there.
struct Packet {
    FrameInfo frame;
    std::vector<std::byte> payload;  ///< until the records are decoded
    std::vector<SplitRecord> records;
    std::vector<EdgeEnds> ends;  ///< of the vertices replayed so far
    std::size_t n_replayed = 0;  ///< splits

    std::uint32_t colour_hash = 0;
    std::vector<ColourResidual> colours;  ///< empty as long as there are none
    std::size_t n_coloured = 0;           ///< vertices

    Packet(const FrameInfo& refine_frame, std::span<const std::byte> bytes)
        : frame(refine_frame), payload(bytes.begin(), bytes.end()) {}
    bool is_replayed() const { return n_replayed == frame.n_splits; }
};

void check_hash(const FrameInfo& frame, const char* what, std::uint32_t computed, std::uint32_t expected) {
    if (computed != expected) {
        throw DecodeError(
            "frame " + std::to_string(frame.sequence) + ": the " + what +
            " hash after it differs from the encoder's; the decoder computes differently or the log is wrong");
    }
}

}  // namespace

struct ModelDecoder::State {
    std::vector<std::byte> buffer;  ///< bytes that are not yet a whole header or frame
    std::uint64_t consumed = 0;     ///< bytes of the log before the buffer
    std::uint32_t max_vertices = std::numeric_limits<std::uint32_t>::max();
    std::exception_ptr failure;

    std::optional<Header> header;
    std::optional<LogOrder> order;
    std::optional<std::uint32_t> last_sequence;
    std::optional<RefinableMesh> mesh;
    std::optional<ColourState> colours;
    bool has_colours = false;
    std::deque<Packet> packets;  ///< not wholly replayed, and the last one, whose colours may come
    std::int32_t previous_face = no_previous_face;

    /// Runs a step that may throw; what was thrown once is thrown again by every later step.
    template <class Step>
    void guarded(Step step) {
        if (failure) std::rethrow_exception(failure);
        try {
            step();
        } catch (...) {
            failure = std::current_exception();
            throw;
        }
    }

    void take_whole_parts();
    std::size_t take_header(std::span<const std::byte> bytes);
    void take_frame(FrameInfo frame, std::span<const std::byte> payload);
    void take_base(const FrameInfo& frame, std::span<const std::byte> payload);
    void take_colours(const FrameInfo& frame, std::span<const std::byte> payload);
    void replay();
    void replay(Packet& packet);
    void colour(Packet& packet);
};

void ModelDecoder::State::take_whole_parts() {
    std::size_t used = 0;
    const auto rest = [&] { return std::span<const std::byte>(buffer).subspan(used); };
    if (!header) used = take_header(rest());
    while (header) {
        const std::optional<FrameInfo> frame = read_frame(rest(), consumed + used);
        if (order->ended() && !rest().empty()) throw DecodeError("bytes behind the end frame of the log");
        if (!frame) break;
        take_frame(*frame, rest().subspan(frame_header_size, frame->payload_bytes));
        used += frame_header_size + frame->payload_bytes;
    }
    buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(used));
    consumed += used;
}

/// @return how many bytes the header took; 0 if it is not whole yet
std::size_t ModelDecoder::State::take_header(std::span<const std::byte> bytes) {
    if (bytes.size() < header_size || bytes.size() < header_bytes_needed(bytes)) return 0;
    header = decode_header(bytes);
    order.emplace(*header);
    return header->header_bytes;
}

void ModelDecoder::State::take_frame(FrameInfo frame, std::span<const std::byte> payload) {
    order->accept(frame);
    switch (frame.type) {
        case FrameType::index:
            decode_index_rows(payload);
            return;  // read for its errors: a decoder needs no index
        case FrameType::base:
            take_base(frame, payload);
            break;
        case FrameType::refine:
            packets.emplace_back(frame, payload);
            replay();
            break;
        case FrameType::colour:
            take_colours(frame, payload);
            break;
        case FrameType::end:
            break;
    }
    last_sequence = frame.sequence;
}

void ModelDecoder::State::take_base(const FrameInfo& frame, std::span<const std::byte> payload) {
    const BaseMesh base = decode_base(payload, *header);
    RefinableMesh decoded(base, header->grid, header->rules);
    check_hash(frame, "state", decoded.state_hash(), frame.state_hash);
    mesh = std::move(decoded);
    colours.emplace(header->colour_steps);
    colours->predict_base(base.positions.size());
}

void ModelDecoder::State::take_colours(const FrameInfo& frame, std::span<const std::byte> payload) {
    has_colours = true;
    if (frame.n_splits != 0) {  // the packet it belongs to is the last one, as LogOrder has checked
        packets.back().colours = decode_colour(payload, 3 * std::size_t{frame.n_splits});
        packets.back().colour_hash = frame.state_hash;
        replay();
        return;
    }
    const std::vector<ColourResidual> residuals = decode_colour(payload, colours->colours().size());
    colours->correct_base(*mesh, [&](std::size_t v, const Rgb8&) { return residuals[v]; });
    check_hash(frame, "colour", colours->hash(), frame.state_hash);
}

void ModelDecoder::State::replay() {
    while (!packets.empty()) {
        Packet& packet = packets.front();
        replay(packet);
        colour(packet);
        if (!packet.is_replayed() || packets.size() == 1) return;
        packets.pop_front();
    }
}

void ModelDecoder::State::replay(Packet& packet) {
    if (packet.records.empty()) {
        const bool starts_batch = (packet.frame.flags & frame_flag_new_batch) != 0;
        packet.records = decode_refine(packet.payload, packet.frame.n_splits,
                                       starts_batch ? no_previous_face : previous_face, mesh->n_faces());
        previous_face = packet.records.back().face;
        packet.payload = {};
    }
    const bool was_replayed = packet.is_replayed();
    while (!packet.is_replayed() && std::int64_t{mesh->n_vertices()} + 3 <= std::int64_t{max_vertices}) {
        const SplitRecord& record = packet.records[packet.n_replayed];
        const Triangle corners = mesh->triangles()[static_cast<std::size_t>(record.face)];
        mesh->apply(record);
        ++packet.n_replayed;
        for (std::size_t i = 0; i < 3; ++i) packet.ends.push_back({corners[i], corners[(i + 1) % 3]});
        colours->predict(std::span(packet.ends).last(3));
    }
    if (packet.is_replayed() && !was_replayed) {
        check_hash(packet.frame, "state", mesh->state_hash(), packet.frame.state_hash);
    }
}

void ModelDecoder::State::colour(Packet& packet) {
    if (packet.colours.empty() || packet.n_coloured == packet.ends.size()) return;
    const std::size_t done = packet.n_coloured;
    colours->correct(packet.frame.n_vertices_before + done, std::span(packet.ends).subspan(done),
                     [&](std::size_t i, const Rgb8&) { return packet.colours[done + i]; });
    packet.n_coloured = packet.ends.size();
    if (packet.n_coloured == packet.colours.size()) {
        check_hash(packet.frame, "colour", colours->hash(), packet.colour_hash);
    }
}

ModelDecoder::ModelDecoder() : state_(std::make_unique<State>()) {}
ModelDecoder::~ModelDecoder() = default;
ModelDecoder::ModelDecoder(ModelDecoder&&) noexcept = default;
ModelDecoder& ModelDecoder::operator=(ModelDecoder&&) noexcept = default;

void ModelDecoder::feed(std::span<const std::byte> bytes) {
    state_->guarded([&] {
        state_->buffer.insert(state_->buffer.end(), bytes.begin(), bytes.end());
        state_->take_whole_parts();
    });
}

void ModelDecoder::set_max_vertices(std::uint32_t max_vertices) {
    state_->guarded([&] {
        state_->max_vertices = max_vertices;
        state_->replay();
    });
}

const Header* ModelDecoder::header() const { return state_->header ? &*state_->header : nullptr; }
const RefinableMesh* ModelDecoder::state() const { return state_->mesh ? &*state_->mesh : nullptr; }
std::optional<std::uint32_t> ModelDecoder::last_sequence() const { return state_->last_sequence; }
bool ModelDecoder::ended() const { return state_->order && state_->order->ended(); }
const ColourState* ModelDecoder::colours() const { return state_->colours ? &*state_->colours : nullptr; }

Mesh ModelDecoder::mesh() const {
    if (!state_->mesh) throw DecodeError("log: expected a base, which has not arrived");
    Mesh mesh = state_->mesh->to_mesh();
    if (state_->has_colours) mesh.colours.assign(state_->colours->colours().begin(), state_->colours->colours().end());
    return mesh;
}

}  // namespace anyrate
