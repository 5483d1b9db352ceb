// Makes a worse capture of a good one, to see what a reconstruction makes of it. Several perturbations are applied in
// the order of the list below. If CAPTURE is a folder with a gt.ply, OUT gets one in its own world.
//
// usage: perturb_capture CAPTURE -o OUT [--cameras FILE] [--seed N] [--keep-every N] [--texture PART] [--gain PART]
//            [--grow-masks PX] [--pose-noise PX] [--resample FACTOR] [--resolution FACTOR] [--crop PART] [--scale S]
//            [--origin X,Y,Z]
// prints {"views", "masks": share of the pixels}
#include <filesystem>
#include <optional>

#include "core/capture/load_capture.h"
#include "core/error.h"
#include "core/mesh/mesh_io.h"
#include "tests/bench/perturbations.h"
#include "tests/bench/tool.h"

namespace {

using namespace anyrate;

struct Request {
    std::filesystem::path capture, output;
    LoadOptions load;
    std::uint64_t seed = 1;
    int keep_every = 1, grow_masks = 0;
    double texture = 1, gain = 0, pose_noise = 0, resample = 1, resolution = 1, crop = 1, scale = 1;
    std::vector<double> origin = {0, 0, 0};
};

double share_of_object(const Capture& capture) {
    double n_object = 0, n = 0;
    for (const View& view : capture.views)
        for (const auto pixel : view.mask.pixels) {
            n_object += pixel != 0;
            n += 1;
        }
    return n_object / n;
}

bench::Json perturb(const Request& request) {
    Capture capture = load_capture(request.capture, request.load);
    std::optional<Mesh> truth;
    if (std::filesystem::exists(request.capture / "gt.ply")) truth = read_mesh(request.capture / "gt.ply");

    bench::keep_every(capture, request.keep_every);
    if (request.texture < 1) {
        if (!truth)
            throw InputError((request.capture / "gt.ply").string() + ": missing; --texture needs the true surface");
        bench::fade_texture(capture, *truth, request.texture, request.seed);
    }
    if (request.gain > 0) bench::change_gain(capture, request.gain, request.seed);
    if (request.grow_masks != 0) bench::grow_masks(capture, request.grow_masks);
    if (request.pose_noise > 0) bench::disturb_poses(capture, request.pose_noise, request.seed);
    if (request.resample != 1) bench::resample(capture, request.resample, 2);
    if (request.resolution != 1) bench::resample(capture, request.resolution);
    if (request.crop < 1) bench::crop(capture, request.crop, request.seed);
    const Vec3 origin(request.origin[0], request.origin[1], request.origin[2]);
    bench::move_world(capture, request.scale, origin);

    save_capture(capture, request.output);
    if (truth) {
        bench::move_world(*truth, request.scale, origin);
        write_mesh(*truth, request.output / "gt.ply");
    }
    return {{"views", capture.views.size()}, {"masks", share_of_object(capture)}};
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Makes a worse capture of a good one.");
    Request request;
    app.add_option("CAPTURE", request.capture, "folder or zip")->required();
    app.add_option("-o,--output", request.output, "folder to write")->required();
    app.add_option("--cameras", request.load.cameras_file, "name of the camera file")->capture_default_str();
    app.add_option("--seed", request.seed, "of everything random")->capture_default_str();
    app.add_option("--keep-every", request.keep_every, "of the views one in N")->check(CLI::PositiveNumber);
    app.add_option("--texture", request.texture, "0.25: faded to a quarter of its contrast; 0: clay (needs gt.ply)")
        ->check(CLI::Range(0.0, 1.0));
    app.add_option("--gain", request.gain, "0.2: views brighter or darker by up to 20 %")->check(CLI::Range(0.0, 0.9));
    app.add_option("--grow-masks", request.grow_masks, "pixels; negative shrinks")->check(CLI::Range(-20, 20));
    app.add_option("--pose-noise", request.pose_noise, "pixels that every camera is off")
        ->check(CLI::Range(0.0, 100.0));
    app.add_option("--resample", request.resample, "0.75: every other view at 75 %")->check(CLI::Range(0.1, 4.0));
    app.add_option("--resolution", request.resolution, "0.5: every view at half its width and height")
        ->check(CLI::Range(0.1, 4.0));
    app.add_option("--crop", request.crop, "0.7: views cut to 70 % of width and height")->check(CLI::Range(0.1, 1.0));
    app.add_option("--scale", request.scale, "of the world")->check(CLI::PositiveNumber);
    app.add_option("--origin", request.origin, "where the world's old origin comes to lie")
        ->delimiter(',')
        ->expected(3);
    return bench::run_tool(app, argc, argv, [&] { return perturb(request); });
}
