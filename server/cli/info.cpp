#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "proto/log_reader.h"
#include "server/cli/commands.h"
#include "server/cli/read_log.h"

namespace anyrate {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions {
    std::filesystem::path model;
    bool json = false;
};

bool has_index_row(FrameType type) {
    return type == FrameType::base || type == FrameType::refine || type == FrameType::colour;
}

/// Mean distortion after each frame of `layout`; none for frames without a row, and where the log has no index.
std::vector<std::optional<double>> frame_distortions(const LogLayout& layout) {
    std::vector<std::optional<double>> distortions;
    std::size_t row = 0;
    for (const FrameInfo& frame : layout.frames) {
        std::optional<double> distortion;
        if (has_index_row(frame.type) && row < layout.index.size()) {
            const double mean = layout.index[row++].mean_distortion;
            if (std::isfinite(mean)) distortion = mean;
        }
        distortions.push_back(distortion);
    }
    return distortions;
}

Json frames_json(const LogLayout& layout) {
    const auto distortions = frame_distortions(layout);
    Json frames = Json::array();
    for (std::size_t i = 0; i < layout.frames.size(); ++i) {
        const FrameInfo& frame = layout.frames[i];
        frames.push_back({{"type", frame_type_name(frame.type)},
                          {"vertices", frame.n_vertices_after},
                          {"end", frame.end()},
                          {"bytes", frame_header_size + frame.payload_bytes},
                          {"distortion", distortions[i] ? Json(*distortions[i]) : Json(nullptr)}});
    }
    return frames;
}

Json layout_json(const LogLayout& layout, std::size_t n_bytes) {
    const Header& header = layout.header;
    return {{"bytes", n_bytes},
            {"whole_bytes", layout.whole_bytes},
            {"version", std::to_string(header.major) + "." + std::to_string(header.minor)},
            {"log_id", header.log_id},
            {"sealed", header.sealed},
            {"ended", layout.ended},
            {"header_bytes", header_size},
            {"frames_begin", layout.frames_begin},
            {"grid_bits", header.grid.bits},
            {"grid_unit", header.grid.unit},
            {"step_ratio", header.rules.step_ratio},
            {"flip_rule", static_cast<int>(header.rules.flip_rule)},
            {"smoothing", static_cast<int>(header.rules.ring_smoothing)},
            {"base_vertices", header.n_base_vertices},
            {"base_faces", header.n_base_faces},
            {"frames", frames_json(layout)}};
}

void print_layout(const LogLayout& layout, std::size_t n_bytes, const char* name) {
    const Header& header = layout.header;
    std::printf("%s: version %d.%d, %zu bytes, %s%s\n", name, header.major, header.minor, n_bytes,
                header.sealed ? "sealed" : "live", layout.ended ? "" : ", not ended");
    std::printf("grid of %d bits, one unit is %.6g of the world; steps are edge / %d\n", header.grid.bits,
                header.grid.unit, header.rules.step_ratio);
    std::printf("%-8s %10s %10s %12s %12s\n", "frame", "vertices", "bytes", "end", "distortion");
    const auto distortions = frame_distortions(layout);
    for (std::size_t i = 0; i < layout.frames.size(); ++i) {
        const FrameInfo& frame = layout.frames[i];
        std::printf("%-8s %10u %10zu %12llu ", frame_type_name(frame.type), frame.n_vertices_after,
                    frame_header_size + frame.payload_bytes, static_cast<unsigned long long>(frame.end()));
        distortions[i] ? std::printf("%12.3f\n", *distortions[i]) : std::printf("%12s\n", "-");
    }
}

int info(const InfoOptions& options) {
    const auto log = read_log(options.model);
    const LogLayout layout = naming_log(options.model, [&] { return read_layout(log); });
    warn_if_cut(layout, log.size(), options.model);
    if (options.json) {
        std::printf("%s\n", layout_json(layout, log.size()).dump(1).c_str());
    } else {
        print_layout(layout, log.size(), log_name(options.model));
    }
    return 0;
}

}  // namespace

void add_info(CLI::App& app, Command& command) {
    auto options = std::make_shared<InfoOptions>();
    CLI::App* sub = app.add_subcommand("info", "list the frames of a model");
    sub->add_option("MODEL", options->model, "the log of a model (.arl); - is the standard input")->required();
    sub->add_flag("--json", options->json, "as JSON");
    sub->callback([options, &command] { command = [options] { return info(*options); }; });
}

}  // namespace anyrate
