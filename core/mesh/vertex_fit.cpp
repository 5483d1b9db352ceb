#include "core/mesh/vertex_fit.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/normals.h"
#include "core/mesh/triangle_shape.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

constexpr int most_iterations = 40;
constexpr double tolerance = 1e-3;  ///< of the residual's norm: the scalars are quantised anyway

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

double dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

/// The quadratic function of the active vertices' displacements that the faces' add up to.
class Quadratic {
public:
    Quadratic(const Mesh& mesh, std::span<const std::int32_t> active, std::span<const FaceDistance> faces,
              double damping)
        : gradient_(active.size(), 0.0), diagonal_(active.size(), 0.0), damping_(damping) {
        std::vector<std::int32_t> index(mesh.vertices.size(), -1);
        for (std::size_t i = 0; i < active.size(); ++i) index[at(active[i])] = static_cast<std::int32_t>(i);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            Term term;
            for (std::size_t k = 0; k < 3; ++k) term.vertices[k] = index[at(mesh.triangles[f][k])];
            if (std::ranges::max(term.vertices) < 0) continue;
            term.hessian = faces[f].hessian;
            terms_.push_back(term);
            for (std::size_t k = 0; k < 3; ++k) {
                if (term.vertices[k] < 0) continue;
                gradient_[at(term.vertices[k])] += faces[f].gradient[k];
                diagonal_[at(term.vertices[k])] += faces[f].hessian[k];
            }
        }
    }

    /// Where it is least, by conjugate gradients.
    std::vector<double> minimum() const {
        const std::size_t n = gradient_.size();
        std::vector<double> u(n, 0.0), r(n), z(n);
        const auto precondition = [&] {
            for (std::size_t i = 0; i < n; ++i) z[i] = diagonal_[i] > 0 ? r[i] / (diagonal_[i] * (1 + damping_)) : 0.0;
        };
        for (std::size_t i = 0; i < n; ++i) r[i] = -gradient_[i];
        precondition();
        std::vector<double> p = z;
        double rz = dot(r, z);
        const double target = tolerance * tolerance * rz;
        for (int k = 0; k < most_iterations && rz > target; ++k) {
            const std::vector<double> Ap = apply(p);
            const double pAp = dot(p, Ap);
            if (!(pAp > 0)) break;
            const double alpha = rz / pAp;
            for (std::size_t i = 0; i < n; ++i) {
                u[i] += alpha * p[i];
                r[i] -= alpha * Ap[i];
            }
            precondition();
            const double next = dot(r, z), beta = next / rz;
            rz = next;
            for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
        }
        return u;
    }

private:
    struct Term {
        std::array<std::int32_t, 3> vertices{};  ///< places among the active ones, -1: not active
        std::array<double, 6> hessian{};
    };

    std::vector<double> apply(std::span<const double> u) const {
        std::vector<double> out(u.size());
        for (std::size_t i = 0; i < u.size(); ++i) out[i] = damping_ * diagonal_[i] * u[i];
        for (const Term& term : terms_) {
            std::array<double, 3> x{}, y{};
            for (std::size_t k = 0; k < 3; ++k) x[k] = term.vertices[k] < 0 ? 0.0 : u[at(term.vertices[k])];
            for (std::size_t k = 0; k < 3; ++k)
                y[k] = term.hessian[k] * x[k] + term.hessian[3 + k] * x[(k + 1) % 3] +
                       term.hessian[3 + (k + 2) % 3] * x[(k + 2) % 3];
            for (std::size_t k = 0; k < 3; ++k)
                if (term.vertices[k] >= 0) out[at(term.vertices[k])] += y[k];
        }
        return out;
    }

    std::vector<double> gradient_, diagonal_;
    std::vector<Term> terms_;
    double damping_;
};

std::vector<double> mean_edge_lengths(const Mesh& mesh) {
    std::vector<double> sum(mesh.vertices.size(), 0.0), n(mesh.vertices.size(), 0.0);
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {  // closed: every edge is met once from each end
            sum[at(t[k])] += (mesh.vertices[at(t[(k + 1) % 3])] - mesh.vertices[at(t[k])]).norm();
            n[at(t[k])] += 1;
        }
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(1.0, n[v]);
    return sum;
}

std::vector<double> displacement_costs(const Mesh& mesh, std::span<const FaceDistance> faces) {
    std::vector<double> costs(mesh.vertices.size(), 0.0);
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) costs[at(mesh.triangles[f][k])] += 0.5 * faces[f].hessian[k];
    return costs;
}

/// What a move leaves of a face.
struct FaceLimits {
    double least_cosine = 0;  ///< between its normals before and after
    double least_area = 0;    ///< in parts of what it was
};

/// A face that turns by more than 60 degrees, the next measurement would take for one of the other side.
constexpr FaceLimits not_turned{.least_cosine = 0.5};
/// Slides fold and crush faces before they turn them over: without these limits a pot passes through itself in 12
/// pairs.
constexpr FaceLimits not_crushed{.least_cosine = 0.9, .least_area = 0.6};

/// Takes back the moves of faces that are beyond the limits, until none is left.
void take_back_beyond(const FaceLimits& limits, Mesh& mesh, std::span<const Vec3> before) {
    const auto normal_of = [](std::span<const Vec3> v, const Triangle& t) {
        return twice_area_vector(v[at(t[0])], v[at(t[1])], v[at(t[2])]);
    };
    for (bool any = true; any;) {
        any = false;
        for (const Triangle& t : mesh.triangles) {
            const Vec3 was = normal_of(before, t), is = normal_of(mesh.vertices, t);
            if (was.dot(is) >= limits.least_cosine * was.norm() * is.norm() &&
                is.norm() >= limits.least_area * was.norm())
                continue;
            for (const std::int32_t v : t) {
                any = any || mesh.vertices[at(v)] != before[at(v)];
                mesh.vertices[at(v)] = before[at(v)];
            }
        }
    }
}

/// What a round may do.
struct Moves {
    double most_edges = 0;  ///< that a vertex moves, in parts of its mean edge length
    double damping = 0;     ///< see FitOptions
    FaceLimits faces;
};

/// One round: measures, and moves the active vertices along the directions.
/// @param directions  unit, one per vertex of the mesh
/// @return the distances before, one per face
std::vector<FaceDistance> fit_along(Mesh& mesh, std::span<const std::int32_t> active, std::span<const Vec3> directions,
                                    SurfaceMeter& meter, const Moves& moves) {
    std::vector<FaceDistance> distances = meter.measure(mesh, directions);
    const std::vector<double> u = Quadratic(mesh, active, distances, moves.damping).minimum();
    const std::vector<double> edges = mean_edge_lengths(mesh);
    const std::vector<Vec3> before(mesh.vertices);
    for (std::size_t i = 0; i < active.size(); ++i) {
        const std::size_t v = at(active[i]);
        const double most = moves.most_edges * edges[v];
        mesh.vertices[v] += std::clamp(u[i], -most, most) * directions[v];
    }
    take_back_beyond(moves.faces, mesh, before);
    return distances;
}

}  // namespace

std::vector<double> fit_along_normals(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter,
                                      const FitOptions& options) {
    std::vector<double> costs;
    const Moves moves{.most_edges = options.most_edges, .damping = options.damping, .faces = not_turned};
    for (int round = 0; round < options.rounds; ++round) {
        const std::vector<FaceDistance> distances = fit_along(mesh, active, vertex_normals(mesh), meter, moves);
        if (round + 1 == options.rounds) costs = displacement_costs(mesh, distances);
    }
    return costs;
}

void fit_in_tangent_planes(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter) {
    // Damped more: where the surface hardly bends, distances tell little of where a vertex is to go.
    constexpr Moves slides{.most_edges = 0.15, .damping = 0.3, .faces = not_crushed};
    std::vector<Vec3> normals = vertex_normals(mesh), directions(normals.size(), Vec3::Zero());
    for (std::size_t v = 0; v < normals.size(); ++v) {
        const bool has_plane = std::abs(normals[v].squaredNorm() - 1) < 1e-6;
        if (has_plane)
            directions[v] = normals[v].unitOrthogonal();
        else
            normals[v].setZero();
    }
    fit_along(mesh, active, directions, meter, slides);
    for (std::size_t v = 0; v < normals.size(); ++v) directions[v] = normals[v].cross(directions[v]);
    fit_along(mesh, active, directions, meter, slides);
}

}  // namespace anyrate
