// What the shaders of a round of optimise_surface() share (gpu_optimiser.cpp writes it). In double precision but for the
// images' terms, and every sum in a fixed order, so that a round goes as on the CPU.

//
// Read the bounds of a loop before it: Mesa's llvmpipe 22.3 takes a value that was read in a loop's condition for 0
// behind the loop, in every invocation that left the loop before the others did.

// The mesh's connections, and where they begin among the items: lists of ints, those of a thing that differ in length
// from thing to thing behind a list of where each begins.
layout(std140, binding = 0) uniform Head {
    int n_active, n_faces, n_vertices;  // that may move; that the images are asked about; of the surface
    int active_at;                      // vertex of each active one
    int ring_begin_at, ring_faces_at;   // of every vertex: its faces, ascending
    int faces_at;                       // the faces that the images are asked about, ascending
    int slots_at;                       // of every face its place among those, or -1
    int row_begin_at, rows_at;  // of every active vertex its neighbours, ascending: vertex, place among the active or -1,
                                // valence
};
layout(std430, binding = 0) readonly buffer Structure { int items[]; };
layout(std430, binding = 1) readonly buffer Triangles { int triangles[]; };
layout(std430, binding = 2) MAYBE_COHERENT buffer Positions { double positions[]; };  // of all vertices
layout(std430, binding = 3) buffer Normals { double normals[]; };                     // of all vertices
layout(std430, binding = 4) MAYBE_COHERENT buffer Data { double data[]; };            // of the active ones, by field

// Whether a dispatch takes place: what glDispatchComputeIndirect() reads.
struct Gate {
    uint n_groups, is_open, one;
};

layout(std430, binding = 5) MAYBE_COHERENT buffer Control {
    double damping;        // of the next trial
    double energy;         // where the step starts
    double bending;        // weight of a squared umbrella
    double first_samples;  // at the start of the round
    double credible;       // distortion of a sample, see robust_terms.h; 0: there are no samples
    // OptimiseOptions and RoundRules:
    double silhouette, bending_part, noisy_bending, noisy_psi, clean_psi, noise_psi, outlier, weak_evidence;
    double converged;
    double least_curvature;  // that noise alone makes, a sample
    double more_damping, less_damping, least_damping, reach_px, beyond_px;
    int n_taken, n_refused;    // steps of the round, trials of the step
    int falls;                 // whether a step was taken by which the energy falls by enough to go on
    int n_steps, most_trials;  // of the round, of a step
    int n_trial_gates, n_gates;  // of a trial, the first of them assembles; behind them those of the round's last step
    int is_faint;              // whether phi is curved less than noise alone would make it
    Gate gates[];
};

// Fields of Data.
#define LIMIT 0          // longest step
#define WEIGHT 1         // of a squared pixel of silhouette
#define CONTOUR 2        // silhouettes: energy, derivative, second derivative
#define UMBRELLA 5       // along the normal
#define REST 6           // the umbrella that costs nothing
#define START 7          // where the step starts: position, normal
#define START_NORMAL 10
#define GRADIENT 13      // of images and silhouettes where the step starts
#define HESSIAN 14       // of the vertex by itself, of images and silhouettes
#define BENT 15          // umbrella less its rest where the step starts
#define DIAGONAL 16
#define DISPLACEMENT 17
#define RESIDUAL 18
#define PRECONDITIONED 19
#define DIRECTION 20
#define APPLIED 21
#define BENDING 22

double field(int which, int i) { return data[which * n_active + i]; }
void set_field(int which, int i, double value) { data[which * n_active + i] = value; }

dvec3 position(int v) { return dvec3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]); }
dvec3 normal(int v) { return dvec3(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]); }
ivec3 triangle(int f) { return ivec3(triangles[3 * f], triangles[3 * f + 1], triangles[3 * f + 2]); }

int active_vertex(int i) { return items[active_at + i]; }
int ring_begin(int v) { return items[ring_begin_at + v]; }
int ring_face(int k) { return items[ring_faces_at + k]; }
int row_begin(int i) { return items[row_begin_at + i]; }
int neighbour(int e) { return items[rows_at + 3 * e]; }
int active_neighbour(int e) { return items[rows_at + 3 * e + 1]; }
int valence_of_neighbour(int e) { return items[rows_at + 3 * e + 2]; }
