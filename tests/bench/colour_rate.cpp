// What the colours of a reconstruction's log take, and how far they are from the colours that were to be coded.
//
// usage: colour_rate CAPTURE [--vertices N] [--coarse N] [--luma STEP] [--chroma STEP] [--bit-price P] [--cameras FILE]
// prints {"vertices", "bits_per_vertex": of the sealed log's colour frames with their framing, "of_the_base": the same
// of the base alone, "mean_error", "rms_error": of a channel, 0 to 255}
#include <cmath>

#include "core/capture/load_capture.h"
#include "core/reconstruction/reconstruct.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;

/// Writes a log, and keeps the colours as they came.
class Recorder final : public ModelSink {
public:
    explicit Recorder(const ColourCoding& coding)
        : writer_(
              1, [this](std::span<const std::byte> b) { log_.insert(log_.end(), b.begin(), b.end()); }, coding) {}

    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override {
        return writer_.start(grid, rules, base);
    }
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override {
        wished_.assign(colours.begin(), colours.end());
        writer_.base_attributes(colours, distortion);
    }
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override {
        wished_.insert(wished_.end(), new_colours.begin(), new_colours.end());
        writer_.batch(records, state, new_colours, distortion);
    }
    void finish() override { writer_.finish(); }

    std::vector<std::byte> sealed() const { return seal_log(log_, writer_.rows()); }
    std::span<const Rgb8> wished() const { return wished_; }

private:
    std::vector<std::byte> log_;
    std::vector<Rgb8> wished_;
    LogWriter writer_;
};

bench::Json rate_and_error(const Recorder& recorder) {
    const std::vector<std::byte> log = recorder.sealed();
    double n_bytes = 0, of_base = 0, n_base = 0;
    for (const FrameInfo& frame : read_layout(log).frames) {
        if (frame.type != FrameType::colour) continue;
        n_bytes += static_cast<double>(frame_header_size) + frame.payload_bytes;
        if (frame.n_splits > 0) continue;
        of_base = n_bytes;
        n_base = frame.n_vertices_after;
    }
    const Mesh mesh = decode_mesh(log, VertexBudget{0xFFFFFFFF});
    double absolute = 0, squared = 0;
    for (std::size_t v = 0; v < mesh.colours.size(); ++v) {
        const Rgb8 &coded = mesh.colours[v], &wished = recorder.wished()[v];
        for (const int error : {coded.r - wished.r, coded.g - wished.g, coded.b - wished.b}) {
            absolute += std::abs(error);
            squared += error * error;
        }
    }
    const double n = mesh.n_vertices();
    return {{"vertices", mesh.n_vertices()},
            {"bits_per_vertex", 8 * n_bytes / n},
            {"of_the_base", 8 * of_base / n_base},
            {"mean_error", absolute / (3 * n)},
            {"rms_error", std::sqrt(squared / (3 * n))}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Measures the rate and the error of a reconstruction's colours.");
    std::string folder;
    LoadOptions load;
    ReconstructOptions options;
    ColourCoding coding;
    app.add_option("CAPTURE", folder, "folder or zip")->required();
    app.add_option("--vertices", options.n_vertices, "of the log")->capture_default_str();
    app.add_option("--coarse", options.n_coarse, "of its base")->capture_default_str();
    app.add_option("--luma", coding.steps.luma, "quantiser step")->capture_default_str();
    app.add_option("--chroma", coding.steps.chroma, "quantiser step")->capture_default_str();
    app.add_option("--bit-price", coding.bit_price, "mean error that a bit is worth")->capture_default_str();
    app.add_option("--cameras", load.cameras_file, "name of the camera file")->capture_default_str();
    return bench::run_tool(app, argc, argv, [&] {
        Recorder recorder(coding);
        reconstruct(load_capture(folder, load), options, recorder);
        return rate_and_error(recorder);
    });
}
