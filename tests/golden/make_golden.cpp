// Writes the golden files of the stream into a folder: make_golden FOLDER
//   octahedron.arl        live form, the worked example of proto/FORMAT.md
//   icosphere.arl         sealed form, some hundred splits with colours, the frames of the live form as they are
//   icosphere-packed.arl  the same refinements in packets of up to 128 splits
//   icosphere.json        for a list of vertex budgets: vertices, faces, state hash and the CRC-32C of positions,
//                         triangles and colours that every reader must find in both
//   cube.arl, cube.json   the same of a cube that is rounded off, by flip rule 2 and smoothing 2, packed
//   sphere.arl, sphere.json  the same of a bumpy sphere, by flip rule 3 and smoothing 2
#include <fstream>
#include <iostream>
#include <string>

#include "core/error.h"
#include "proto/bytes.h"
#include "proto/crc32c.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "tests/golden/sample_models.h"

namespace anyrate {
namespace {

void write_file(const std::string& path, std::span<const std::byte> bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) throw IoError(path + ": cannot be written");
}

void write_file(const std::string& path, const std::string& text) { write_file(path, std::as_bytes(std::span(text))); }

/// One row of the JSON list.
std::string expectation(std::span<const std::byte> log, std::uint32_t budget) {
    ModelDecoder decoder;
    decoder.set_max_vertices(budget);
    decoder.feed(log);
    ByteWriter positions, triangles, colours;
    for (const GridPoint& p : decoder.state()->positions()) {
        for (const std::int32_t x : {p.x, p.y, p.z}) positions.put(static_cast<std::uint32_t>(x));
    }
    for (const Triangle& t : decoder.state()->triangles()) {
        for (const std::int32_t v : t) triangles.put(static_cast<std::uint32_t>(v));
    }
    for (const Rgb8& c : decoder.mesh().colours) {
        for (const std::uint8_t x : {c.r, c.g, c.b}) colours.put(x);
    }
    const auto number = [](const char* name, std::uint64_t value) {
        return "\"" + std::string(name) + "\": " + std::to_string(value);
    };
    return "  {" + number("budget", budget) + ", " +
           number("vertices", static_cast<std::uint64_t>(decoder.state()->n_vertices())) + ", " +
           number("faces", static_cast<std::uint64_t>(decoder.state()->n_faces())) + ", " +
           number("stateHash", decoder.state()->state_hash()) + ",\n   " +
           number("positionsCrc", crc32c(positions.bytes())) + ", " +
           number("trianglesCrc", crc32c(triangles.bytes())) + ", " + number("coloursCrc", crc32c(colours.bytes())) +
           "}";
}

/// The JSON list.
std::string expectations(std::span<const std::byte> log, std::initializer_list<std::uint32_t> budgets) {
    std::string json;
    for (const std::uint32_t budget : budgets) json += (json.empty() ? "[\n" : ",\n") + expectation(log, budget);
    return json + "\n]\n";
}

void make_golden(const std::string& folder) {
    write_file(folder + "/octahedron.arl", samples::octahedron_log().live);

    const samples::SampleLog sample = samples::icosphere_log();
    const std::vector<std::byte> sealed = seal_log(sample.live, sample.rows, {.splits_per_packet = 0});
    write_file(folder + "/icosphere.arl", sealed);
    write_file(folder + "/icosphere-packed.arl", seal_log(sample.live, sample.rows, largest_packets(128)));
    write_file(folder + "/icosphere.json",
               expectations(sealed, {42, 44, 45, 100, 101, 102, 103, 250, 333, 500, 777, 1000, 1000000}));

    const samples::SampleLog cube = samples::cube_log();
    const std::vector<std::byte> packed = seal_log(cube.live, cube.rows, largest_packets(128));
    write_file(folder + "/cube.arl", packed);
    write_file(folder + "/cube.json", expectations(packed, {98, 101, 102, 103, 158, 200, 333, 500, 700, 1000000}));

    const samples::SampleLog sphere = samples::sphere_log();
    const std::vector<std::byte> packed_sphere = seal_log(sphere.live, sphere.rows, largest_packets(128));
    write_file(folder + "/sphere.arl", packed_sphere);
    write_file(folder + "/sphere.json",
               expectations(packed_sphere, {42, 44, 45, 46, 100, 101, 333, 500, 700, 1000, 1000000}));
}

}  // namespace
}  // namespace anyrate

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: make_golden FOLDER\n";
        return 2;
    }
    try {
        anyrate::make_golden(argv[1]);
    } catch (const std::exception& error) {
        std::cerr << "make_golden: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
