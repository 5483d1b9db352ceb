// How fast the C++ reader of logs is, on one thread; the counterpart of replay.mjs.
//
// usage: replay MODEL.arl [--seconds S=2]
// prints {"machine", "log", "replay", "decode", "packet"}:
//   replay   splits a second of the operation alone, on records that Draco decoded before: median of the passes
//   decode   the whole reader, bytes to coloured mesh with all checksums and hashes: vertices a second, median
//   packet   milliseconds that Draco takes for the refine packet nearest to 512 splits, median
// Timings are those of the machine as it is.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <thread>

#include "core/error.h"
#include "proto/base_codec.h"
#include "proto/log_reader.h"
#include "proto/refine_codec.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;
using Clock = std::chrono::steady_clock;

double milliseconds(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

/// Median milliseconds of passes for so many seconds, at least of one. What `prepare` does for each is not counted.
template <class Prepare>
double median_time(double seconds, Prepare&& prepare) {
    std::vector<double> times;
    const Clock::time_point start = Clock::now();
    do {
        auto pass = prepare();
        const Clock::time_point before = Clock::now();
        pass();
        times.push_back(milliseconds(Clock::now() - before));
    } while (milliseconds(Clock::now() - start) < 1000 * seconds);
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::ranges::nth_element(times, middle);
    return *middle;
}

bench::Json machine() {
    std::ifstream cpus("/proc/cpuinfo");
    std::string line, name = "unknown";
    while (std::getline(cpus, line))
        if (line.starts_with("model name")) {
            name = line.substr(std::min(line.find(':') + 2, line.size()));
            break;
        }
    double load = 0;
    if (getloadavg(&load, 1) != 1) load = std::numeric_limits<double>::quiet_NaN();
    return {{"cpu", name}, {"cores", std::thread::hardware_concurrency()}, {"load_average", load}};
}

/// A refine packet and what stands before it.
struct Packet {
    std::span<const std::byte> payload;
    std::size_t n_splits = 0;
    std::int32_t previous_face = no_previous_face, n_faces = 0;

    std::vector<SplitRecord> decode() const { return decode_refine(payload, n_splits, previous_face, n_faces); }
};

bench::Json measure(std::span<const std::byte> log, double seconds) {
    const LogLayout layout = read_layout(log);
    const auto payload_of = [&](const FrameInfo& frame) {
        return log.subspan(static_cast<std::size_t>(frame.begin) + frame_header_size, frame.payload_bytes);
    };
    const auto base_frame = std::ranges::find(layout.frames, FrameType::base, &FrameInfo::type);
    if (base_frame == layout.frames.end()) throw InputError("expected a log with its base");
    const RefinableMesh base(decode_base(payload_of(*base_frame), layout.header), layout.header.grid,
                             layout.header.rules);
    std::vector<Packet> packets;
    std::vector<SplitRecord> records;
    for (const FrameInfo& frame : layout.frames) {
        if (frame.type != FrameType::refine) continue;
        const bool starts_batch = (frame.flags & frame_flag_new_batch) != 0 || records.empty();
        packets.push_back({payload_of(frame), frame.n_splits, starts_batch ? no_previous_face : records.back().face,
                           base.n_faces() + 6 * static_cast<std::int32_t>(records.size())});
        const std::vector<SplitRecord> decoded = packets.back().decode();
        records.insert(records.end(), decoded.begin(), decoded.end());
    }
    if (records.empty()) throw InputError("expected a log with refinements");
    const Packet near512 = *std::ranges::min_element(
        packets, {}, [](const Packet& packet) { return std::abs(static_cast<std::int64_t>(packet.n_splits) - 512); });

    const double replay = median_time(seconds, [&] {
        return [mesh = base, &records]() mutable {
            for (const SplitRecord& record : records) mesh.apply(record);
        };
    });
    const double decode = median_time(
        seconds, [&] { return [&] { decode_mesh(log, VertexBudget{std::numeric_limits<std::uint32_t>::max()}); }; });
    const double packet = median_time(seconds, [&] { return [&] { near512.decode(); }; });

    const auto per_second = [](std::size_t n, double time) {
        return std::lround(1000 * static_cast<double>(n) / time);
    };
    const std::size_t n_vertices = layout.header.n_base_vertices + 3 * records.size();
    return {{"machine", machine()},
            {"log", {{"splits", records.size()}, {"vertices", n_vertices}, {"bytes", log.size()}}},
            {"replay", {{"splits_per_second", per_second(records.size(), replay)}}},
            {"decode", {{"milliseconds", decode}, {"vertices_per_second", per_second(n_vertices, decode)}}},
            {"packet", {{"splits", near512.n_splits}, {"milliseconds", packet}}}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Measures how fast a log is decoded and replayed.");
    std::string model;
    double seconds = 2;
    app.add_option("MODEL", model, "log (.arl)")->required();
    app.add_option("--seconds", seconds, "that each of the three is measured for")->check(CLI::NonNegativeNumber);
    return bench::run_tool(app, argc, argv, [&] {
        std::ifstream file(model, std::ios::binary);
        const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
        if (!file) throw InputError(model + ": cannot be read");
        return measure(std::as_bytes(std::span(bytes)), seconds);
    });
}
