#pragma once
#include <functional>
#include <optional>
#include <stop_token>

#include "core/progressive/model_sink.h"
#include "core/reconstruction/reconstruct.h"
#include "core/reconstruction/refinement_step.h"

namespace anyrate {

/// Step 3 of the method: until the rate is met, splits the faces where a split promises most, moves the three new and
/// six old vertices of every split of the batch together, and writes what the decoder will see. The state is always the
/// decoded one (closed loop).
/// The batches bring the state nearer to the fitted surface, of which the images were asked at a size of facets that
/// they tell apart: on coarser ones they disagree wherever the vertices are, on finer ones their noise decides. A batch
/// is fitted while the one before is measured and sent.
/// With RefineOptions::follows_images they are optimised against the images, as the paper has it, and only what lowers
/// the distortion is kept. Differs from the paper, which takes one triangle of largest phi at a time: a batch of
/// independent splits (parallel, and cheap to encode), ranked by the decrease that moving the three middles is expected
/// to bring and by a part of phi, which alone stays high at texture edges that no split can mend.
/// Backend, sink and progress are called on the calling thread, a batch's progress before the sink has anything of the
/// next.
/// @param rejected  one flag a face whose split the images did not bear out, or took the state further from the fitted
///                  surface: all that is remembered from batch to batch besides the state. Whoever gives state and
///                  flags as they were after a batch gets the batches that would have followed, bit for bit.
/// @param known     what measure_without_terms() says of the state, if it was asked already
/// @return the curve, the state's own point first
std::vector<CurvePoint> refine(RefinableMesh& state, PhotoBackend& backend, const RefinementScene& scene,
                               const RefineOptions& options, ModelSink& sink,
                               const std::function<void(const CurvePoint&)>& progress, const std::stop_token& stop,
                               std::vector<char>* rejected = nullptr, std::optional<DistortionPoint> known = {});

}  // namespace anyrate
