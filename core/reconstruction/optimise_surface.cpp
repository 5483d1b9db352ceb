#include "core/reconstruction/optimise_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/reconstruction/optimise_round.h"
#include "core/reconstruction/robust_terms.h"
#include "core/reconstruction/tangential.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr double first_damping = 0.1;   ///< 0.01 overshoots into pits that no step leaves: bowl, Psi 9.5 instead of 5.3
constexpr int most_trials = 4;          ///< of a step, each damped eight times more than the one before
constexpr double max_step_edges = 0.3;  ///< of the mean edge around the vertex: Nghiem et al.'s bound after Eq. 4
constexpr double clean_psi = 20;        ///< squared colour units: of a good surface in good images
constexpr double noise_psi = 2;         ///< of images that show nothing but noise: a good sensor in 8 bits has no less
constexpr double outlier = 30;          ///< usual distortions, see robust_terms.h; 100: nefertiti's ear ends worse
constexpr double noise_curvature = 75;  ///< of phi along a normal, a sample: squared colour units per squared pixel
constexpr double noisy_psi = 600;       ///< where smoothness counts twice and silhouettes thrice
constexpr double noisy_bending = 0.04;  ///< added to the weight of bending there
constexpr double weak_evidence = 0.1;   ///< of the mean curvature of phi: below it a vertex keeps its shape
constexpr double converged = 2e-3;      ///< a round whose energy falls by less than this part has converged
/// Times as many rounds where texture is so faint that it tells less than noise: a surface takes longer to rest there.
/// With a tenth of nefertiti's contrast errors are 8 % less, by twice as many rounds 6 %. Where texture is good twice
/// as many cost a fifth of the time and gain the pot 3 to 6 %, nefertiti and the bowl nothing.
constexpr int faint_rounds = 3;
constexpr double more_damping = 8, less_damping = 4, least_damping = 1e-4;

/// What a squared pixel of contour costs, squared colour units: about what a sample of phi does. On poor texture that
/// is little, and with the price of good images contours, noisy by half a pixel, would rule all surface near them.
double contour_price(double psi) {
    return std::max(psi, std::min(clean_psi, std::max(noise_psi, psi * psi / noise_psi)));
}

/// What the vertices, their one-rings and the batch of faces are while one round lasts.
class Round {
public:
    Round(PhotoBackend& backend, const OptimiseRound& round, std::vector<Vec3>& vertices)
        : backend_(backend),
          silhouettes_(round.silhouettes),
          vertices_(vertices),
          triangles_(round.triangles),
          rings_(round.rings),
          active_(round.active),
          faces_(round.faces),
          options_(round.options) {
        const SurfaceView surface(vertices_, triangles_);
        if (round.is_first) silhouettes_.look(surface);
        backend_.set_surface(surface, options_.level, options_.samples_per_px, round.around);
        const std::vector<double> edges = mean_edge_lengths(surface, rings_);
        const std::vector<double> pixels =
            pixels_around(round, [&](std::int32_t face) { return backend_.pixel_size(face); });
        for (std::size_t i = 0; i < active_.size(); ++i) {
            const double edge = edges[at(active_[i])];
            step_limits_.push_back(std::min(options_.max_step_px * pixels[i], max_step_edges * edge));
            silhouette_weights_.push_back(edge / pixels[i]);  // contour length in pixels; see weigh()
        }
        least_curvature_ = least_curvature(pixels);
        look();
        credible_ = credible_distortion(terms_, noise_psi, outlier);
        make_robust(terms_, credible_);
        weigh();
        energy_ = evaluate();
    }

    /// One damped Gauss-Newton step. The round's last is taken on trust: to look at it only to accept it costs a fourth
    /// of the round, and refusing it gains nothing (nefertiti and pot: no difference, bowl: Psi 5.3 instead of 8.3).
    /// @return whether the energy fell by enough to go on; if not, no other step can be taken in this round
    bool step(double& damping, bool is_last) {
        const SurfaceView surface(vertices_, triangles_);
        const NormalDisplacement quadratic(surface, rings_, normals_, active_, faces_, terms_, silhouette_terms_,
                                           {bending_, rest_, silhouette_weights_});
        const double before = energy_;
        const std::vector<Vec3> start(vertices_);
        const std::vector<Vec3> start_normals(normals_);
        for (int trial = 0; trial < most_trials; ++trial, damping *= more_damping) {
            const std::vector<double> u = quadratic.solve(damping);
            for (std::size_t i = 0; i < active_.size(); ++i) {
                const std::size_t v = at(active_[i]);
                vertices_[v] = start[v] + std::clamp(u[i], -step_limits_[i], step_limits_[i]) * start_normals[v];
            }
            if (is_last) return true;
            look();
            make_robust(terms_, credible_);
            energy_ = evaluate();
            if (energy_ < before) {
                damping = std::max(damping / less_damping, least_damping);
                return energy_ < before * (1 - converged);
            }
        }
        vertices_ = start;
        return false;
    }

    /// See RoundOutcome.
    bool is_faint() const { return is_faint_; }

private:
    /// Terms of all faces and vertices at the current positions.
    void look() {
        const SurfaceView surface(vertices_, triangles_);
        normals_ = vertex_normals(surface, rings_);
        queries_.resize(faces_.size());
        directions_.resize(faces_.size());
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            const Triangle& t = triangles_[at(faces_[i])];
            queries_[i].face = faces_[i];
            for (std::size_t k = 0; k < 3; ++k) {
                queries_[i].corners[k] = vertices_[at(t[k])];
                directions_[i][k] = normals_[at(t[k])];
            }
        }
        terms_ = backend_.terms(queries_, directions_);
        silhouette_terms_ = silhouettes_.terms(surface, rings_, normals_, active_, options_.silhouette_reach_px);
    }

    /// What the round's regularising terms weigh against phi. Where the images disagree even on the best surface (light
    /// that does not turn with the object, highlights, noise), phi is a worse witness: silhouettes and smoothness count
    /// for more. A vertex that the images say much of bends towards flat; one they say nothing of keeps the shape it
    /// has: a prior that pulled there would inflate what no view sees. Its shape is its ring's, not its own: with its
    /// own, pits of the start stay where two views look (cropped photographs of nefertiti: 0.0248 % of the diagonal off
    /// with its own, 0.0186 % with the ring's; bowl 3 % better, others no difference). Where the texture is poor the
    /// curvature of phi is as small as its noise makes it: bending is weighed against no less. With a tenth of its
    /// contrast nefertiti is 0.023 % of the diagonal off with this and contour_price(), 0.069 % without; with all of it
    /// 0.017 %.
    void weigh() {
        double phi = 0;
        for (const TriangleTerms& t : terms_) {
            phi += t.distortion.phi;
            first_samples_ += t.distortion.n_samples;
        }
        const double psi = first_samples_ > 0 ? phi / first_samples_ : 0.0;
        const double noise = psi / noisy_psi;
        for (double& weight : silhouette_weights_)
            weight *= options_.silhouette * (1 + 2 * noise) * (first_samples_ > 0 ? contour_price(psi) : clean_psi);

        std::vector<double> curvature(vertices_.size(), 0.0);
        for (std::size_t i = 0; i < faces_.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) curvature[at(triangles_[at(faces_[i])][k])] += terms_[i].hessian[k];
        double sum = 0;
        int n_with_evidence = 0;
        for (std::int32_t v : active_) {
            sum += curvature[at(v)];
            n_with_evidence += curvature[at(v)] > 0 ? 1 : 0;
        }
        const double mean = n_with_evidence > 0 ? sum / n_with_evidence : 1.0;
        const double samples_per_vertex = first_samples_ / static_cast<double>(active_.size());
        const double least = least_curvature_ * samples_per_vertex;
        is_faint_ = mean < least;
        bending_ = (options_.bending + noisy_bending * noise) * std::max(mean, least);
        rest_ = ring_means(umbrellas({vertices_, triangles_}, rings_, normals_, active_), rings_, active_,
                           vertices_.size());
        for (std::size_t i = 0; i < active_.size(); ++i)
            rest_[i] *= 1 - curvature[at(active_[i])] / (curvature[at(active_[i])] + weak_evidence * mean);
    }

    /// The energy of what look() saw. Samples come and go at the silhouettes, so phi counts as its mean per sample
    /// times the number of samples at the round's start.
    double evaluate() const {
        double phi = 0, n_samples = 0;
        for (const TriangleTerms& t : terms_) {
            phi += t.distortion.phi;
            n_samples += t.distortion.n_samples;
        }
        double energy = n_samples > 0 ? phi / n_samples * first_samples_ : 0.0;
        const std::vector<double> bent = umbrellas({vertices_, triangles_}, rings_, normals_, active_);
        for (std::size_t i = 0; i < active_.size(); ++i)
            energy += silhouette_weights_[i] * silhouette_terms_[i].energy +
                      bending_ * (bent[i] - rest_[i]) * (bent[i] - rest_[i]);
        return energy;
    }

    PhotoBackend& backend_;
    Silhouettes& silhouettes_;
    std::vector<Vec3>& vertices_;
    std::span<const Triangle> triangles_;
    const OneRings& rings_;
    std::span<const std::int32_t> active_, faces_;
    const OptimiseOptions& options_;
    std::vector<double> step_limits_, silhouette_weights_, rest_;
    std::vector<Vec3> normals_;
    std::vector<TriangleQuery> queries_;
    std::vector<std::array<Vec3, 3>> directions_;
    std::vector<TriangleTerms> terms_;
    std::vector<SilhouetteTerm> silhouette_terms_;
    bool is_faint_ = false;
    double credible_ = 0, bending_ = 0, least_curvature_ = 0, first_samples_ = 0, energy_ = 0;
};

void slide(std::vector<Vec3>& vertices, std::span<const Triangle> triangles, const OneRings& rings,
           std::span<const std::int32_t> active, double part) {
    const SurfaceView surface(vertices, triangles);
    const std::vector<Vec3> normals = vertex_normals(surface, rings);
    std::vector<Vec3> moved(vertices);
    for (std::int32_t v : active) moved[at(v)] += part * tangential_laplacian(surface, rings, normals[at(v)], v);
    vertices = std::move(moved);
}

bool has_guessed_corner(const Triangle& t, std::span<const char> is_guessed) {
    return !is_guessed.empty() && std::ranges::any_of(t, [&](std::int32_t v) { return is_guessed[at(v)] != 0; });
}

}  // namespace

RoundRules round_rules() {
    return {.most_trials = most_trials,
            .more_damping = more_damping,
            .less_damping = less_damping,
            .least_damping = least_damping,
            .max_step_edges = max_step_edges,
            .clean_psi = clean_psi,
            .noise_psi = noise_psi,
            .outlier = outlier,
            .noisy_psi = noisy_psi,
            .noisy_bending = noisy_bending,
            .weak_evidence = weak_evidence,
            .converged = converged};
}

std::vector<double> pixels_around(const OptimiseRound& round, const std::function<double(std::int32_t)>& pixel_size) {
    std::vector<double> pixels;
    pixels.reserve(round.active.size());
    for (const std::int32_t v : round.active) {
        const auto faces = round.rings.faces(v);
        double sum = 0;
        for (const std::int32_t f : faces) sum += pixel_size(f);
        pixels.push_back(sum / static_cast<double>(faces.size()));
    }
    return pixels;
}

double least_curvature(std::span<const double> pixels) {
    const double mean = std::accumulate(pixels.begin(), pixels.end(), 0.0) / static_cast<double>(pixels.size());
    return noise_curvature / (mean * mean);
}

RoundOutcome PhotoBackend::optimise_round(const OptimiseRound& round, std::vector<Vec3>& vertices, double damping) {
    Round steps(*this, round, vertices);
    bool falls = false;
    for (int s = 0; s < round.options.steps_per_round; ++s) {
        if (!steps.step(damping, s + 1 == round.options.steps_per_round)) break;
        falls = true;
    }
    return {falls, damping, steps.is_faint()};
}

bool optimise_surface(PhotoBackend& backend, Silhouettes& silhouettes, std::vector<Vec3>& vertices,
                      std::span<const Triangle> triangles, std::span<const std::int32_t> active,
                      std::span<const char> is_guessed, const OptimiseOptions& options, const std::stop_token& stop) {
    const OneRings rings({vertices, triangles});
    std::vector<std::int32_t> all;
    if (active.empty()) {
        all.resize(vertices.size());
        std::iota(all.begin(), all.end(), 0);
        std::erase_if(all, [&](std::int32_t v) { return !is_guessed.empty() && is_guessed[at(v)] != 0; });
        active = all;
    }
    const std::vector<std::int32_t> around = faces_around(rings, active);
    std::vector<std::int32_t> faces = around;
    std::erase_if(faces, [&](std::int32_t f) { return has_guessed_corner(triangles[at(f)], is_guessed); });
    OptimiseRound round{triangles, rings, active, around, faces, options, silhouettes};
    bool moved = false;
    double damping = first_damping;
    int n_rounds = options.rounds;
    for (int r = 0; r < n_rounds && !stop.stop_requested(); ++r) {
        const RoundOutcome outcome = backend.optimise_round(round, vertices, damping);
        round.is_first = false;  // the silhouettes look once: what comes and goes beyond a contour is soon told
        if (r == 0 && outcome.is_faint) n_rounds *= faint_rounds;
        damping = outcome.damping;
        moved = moved || outcome.falls;
        if (!outcome.falls) break;
        if (options.tangential > 0) slide(vertices, triangles, rings, active, options.tangential);
        damping = std::min(damping, 1.0);
    }
    return moved;
}

}  // namespace anyrate
