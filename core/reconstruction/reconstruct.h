#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/capture/capture.h"
#include "core/progressive/model_sink.h"
#include "core/reconstruction/photo_backend.h"
#include "core/reconstruction/refinement_journal.h"
#include "core/reconstruction/sampling.h"

namespace anyrate {

enum class Method {
    refine,   ///< the method: optimise, simplify to the coarse mesh, split where most error is left
    flow,     ///< the paper's baseline: remesh to the full count, then plain surface flow
    uniform,  ///< refine, but splitting the largest faces instead of the most distorted
};

struct ReconstructOptions {
    int n_vertices = 10'000;
    int n_coarse = 2'500;
    std::uint64_t seed = 1;
    Method method = Method::refine;
    bool follows_images = false;                ///< see RefineOptions; so does Method::uniform
    Sampling sampling = Sampling::adaptive;     ///< of step 2; step 3 and every Psi that is told sample adaptively
    double samples_per_px = 1.0;                ///< C of Eq. 7 in the surface flow (`Method::flow`)
    BackendFactory backend = make_cpu_backend;  ///< who computes photo-consistency
};

enum class Stage { hull, poisson, remesh, optimise, refine };
const char* stage_name(Stage stage);

struct Progress {
    Stage stage = Stage::hull;
    double fraction = 0;  ///< of this stage, 0..1
    int n_vertices = 0;   ///< of the mesh so far, 0 before there is one
    double psi = 0;       ///< Eq. 10, squared 8-bit colour units
};
using ProgressFn = std::function<void(const Progress&)>;

struct CurvePoint {
    int n_vertices = 0;
    double psi = 0;
};

struct ReconstructResult {
    std::vector<CurvePoint> curve;   ///< one per batch, the base first
    std::vector<double> iterations;  ///< Method::flow: Psi before each of its iterations and at the end
    bool stopped = false;            ///< the stop token ended it early; what the sink received is a valid model
};

/// The whole method: hull, Poisson, remesh, then the loop visibility - photo-consistency - flow - refine - emit.
/// On the CPU the same capture and options give the same calls of the sink for any number of threads; so does a capture
/// that differs in the world's unit and origin alone, but for the grid's.
/// @param capture  its colours are given back as soon as they have been prepared for sampling: move it here
/// @param journal  if there is one, a reconstruction that is stopped gives the sink nothing that an undisturbed one
///                 would not, neither a base in a hurry nor finish(): it is there to be resumed
/// @throws InputError if the silhouettes have no common inside, or the counts are out of range
ReconstructResult reconstruct(Capture capture, const ReconstructOptions& options, ModelSink& sink,
                              const ProgressFn& progress = {}, std::stop_token stop = {},
                              RefinementJournal* journal = nullptr);

/// Goes on with a reconstruction whose journal was kept: the sink is called as reconstruct() would have called it from
/// there on. The capture and the options must be the same, the point one of that reconstruction.
/// @param point  nullopt: the sink takes the base once more, and all that follows
/// @throws InputError if the capture cannot be the one that `start` came from
ReconstructResult resume(Capture capture, const ReconstructOptions& options, const RefinementStart& start,
                         std::optional<RefinementPoint> point, ModelSink& sink, const ProgressFn& progress,
                         std::stop_token stop, RefinementJournal& journal);

}  // namespace anyrate
