#pragma once
#include <functional>
#include <stop_token>
#include <string>

#include "core/mesh/mesh.h"
#include "core/progressive/model_sink.h"

namespace anyrate {

// The numbers behind these choices are those of a bust of 35,002 vertices, at 10,000: "x" is bytes over the bytes of
// one simplified mesh of the same error in single-rate Draco, measured with flip rule 1 and a base of 1,500,
// where these options had 0.81.
struct EncodeMeshOptions {
    std::string name = "mesh";  ///< of the surface, for what is said of it
    int n_vertices = 10'000;
    int n_coarse = 2'500;        ///< against 1,500: a log of 10,000 takes 0 to 9 % more bytes and errs 2 to 9 % less,
                                 ///< 20 to 30 % less at 2,500
    int step_ratio = 80;         ///< with growth 0.16: x 0.82; 60: x 0.85. With bit price 0.8: x 0.82; 120: x 0.84
    double growth = 0.2;         ///< vertices a batch adds, in parts of what is there; 0.12: x 0.84, 0.3: x 0.82
    double smallest_area = 0.2;  ///< faces below this part of the mean area are not split; 0.1 is the same
    double bit_price = 0.5;      ///< in parts of what a bit brings as part of a split; 0.8: x 0.82. With growth 0.12:
                                 ///< x 0.84; 0, which is a dead zone of 0.75 steps: x 0.89
};

/// Where the encoder is: the mesh so far and its root mean square distance, world units.
struct EncodeProgress {
    int n_vertices = 0;  ///< 0 before there is a mesh
    double rms_distance = 0;
};

enum class EncodeEnd {
    done,
    stopped,          ///< what the sink received is a valid model
    before_the_base,  ///< stopped, and the sink received nothing
};

/// Writes a closed surface as a progressive model: a coarse mesh, then batches of splits where the mesh is farthest
/// off. Every batch starts from the decoded state (closed loop). The distortion that the sink is told is the mean
/// squared distance in squared grid units, half of it from points of the mesh to the surface, half from points of the
/// surface to the mesh; `max` is the largest mean of one face. The same mesh and options give the same calls of the
/// sink for any number of threads.
/// @param mesh  its colours, if it has any, become colours of the model
/// @throws InputError if `mesh` is not one closed manifold piece, or the counts are out of range or too small for it
EncodeEnd encode_mesh(const Mesh& mesh, const EncodeMeshOptions& options, ModelSink& sink,
                      const std::function<void(const EncodeProgress&)>& progress = {}, std::stop_token stop = {});

}  // namespace anyrate
