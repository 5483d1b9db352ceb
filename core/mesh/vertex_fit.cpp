#include "core/mesh/vertex_fit.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/normals.h"
#include "core/mesh/triangle_shape.h"

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

Vec3 product(const Symmetric3& m, const Vec3& v) {
    return {m[0] * v[0] + m[3] * v[1] + m[5] * v[2], m[3] * v[0] + m[1] * v[1] + m[4] * v[2],
            m[5] * v[0] + m[4] * v[1] + m[2] * v[2]};
}

/// The quadratic function of the active vertices' displacements that the faces' add up to.
class Quadratic {
public:
    /// @param directions  unit, one per vertex of the mesh: in which it may move
    Quadratic(const Mesh& mesh, std::span<const std::int32_t> active, std::span<const FaceQuadratic> faces,
              std::span<const Vec3> directions, double damping)
        : gradient_(active.size(), 0.0), diagonal_(active.size(), 0.0), damping_(damping) {
        std::vector<std::int32_t> index(mesh.vertices.size(), -1);
        for (std::size_t i = 0; i < active.size(); ++i) index[at(active[i])] = static_cast<std::int32_t>(i);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            Term term;
            for (std::size_t k = 0; k < 3; ++k) term.vertices[k] = index[at(mesh.triangles[f][k])];
            if (std::ranges::max(term.vertices) < 0) continue;
            const auto direction = [&](std::size_t k) -> const Vec3& { return directions[at(mesh.triangles[f][k])]; };
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t l = (k + 1) % 3;
                term.hessian[k] = direction(k).dot(product(faces[f].hessian[k], direction(k)));
                term.hessian[3 + k] = direction(k).dot(product(faces[f].hessian[3 + k], direction(l)));
            }
            terms_.push_back(term);
            for (std::size_t k = 0; k < 3; ++k) {
                if (term.vertices[k] < 0) continue;
                gradient_[at(term.vertices[k])] += direction(k).dot(faces[f].gradient[k]);
                diagonal_[at(term.vertices[k])] += term.hessian[k];
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

/// Half the second derivative of the squared distance by a move of each vertex alone.
/// @param directions  unit, one per vertex of the mesh
std::vector<double> displacement_costs(const Mesh& mesh, std::span<const FaceQuadratic> faces,
                                       std::span<const Vec3> directions) {
    std::vector<double> costs(mesh.vertices.size(), 0.0);
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t v = at(mesh.triangles[f][k]);
            costs[v] += 0.5 * directions[v].dot(product(faces[f].hessian[k], directions[v]));
        }
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

/// Damped more than a move along a normal: where the surface hardly bends, distances tell little of where a vertex is
/// to go.
constexpr Moves slide{.most_edges = 0.15, .damping = 0.3, .faces = not_crushed};

/// Of a vertex whose faces have no area the normal is none.
bool is_unit(const Vec3& normal) { return std::abs(normal.squaredNorm() - 1) < 1e-6; }

/// Moves the active vertices along the directions.
/// @param directions  unit, one per vertex of the mesh
/// @param faces       as measured; afterwards the gradients are those where the vertices stand now
void fit_along(std::span<const Vec3> directions, Mesh& mesh, std::span<const std::int32_t> active,
               std::vector<FaceQuadratic>& faces, const Moves& moves) {
    const std::vector<double> u = Quadratic(mesh, active, faces, directions, moves.damping).minimum();
    const std::vector<double> edges = mean_edge_lengths(mesh);
    const std::vector<Vec3> before(mesh.vertices);
    for (std::size_t i = 0; i < active.size(); ++i) {
        const std::size_t v = at(active[i]);
        const double most = moves.most_edges * edges[v];
        mesh.vertices[v] += std::clamp(u[i], -most, most) * directions[v];
    }
    take_back_beyond(moves.faces, mesh, before);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto moved = [&](std::size_t k) -> Vec3 {
            const std::size_t v = at(mesh.triangles[f][k]);
            return mesh.vertices[v] - before[v];
        };
        for (std::size_t k = 0; k < 3; ++k)
            faces[f].gradient[k] += product(faces[f].hessian[k], moved(k)) +
                                    product(faces[f].hessian[3 + k], moved((k + 1) % 3)) +
                                    product(faces[f].hessian[3 + (k + 2) % 3], moved((k + 2) % 3));
    }
}

}  // namespace

std::vector<double> fit_vertices(Mesh& mesh, std::span<const std::int32_t> active, SurfaceMeter& meter,
                                 const FitOptions& options) {
    std::vector<FaceQuadratic> faces = meter.quadratics(mesh);
    const std::vector<Vec3> normals = vertex_normals(mesh);
    if (options.slides) {
        std::vector<Vec3> directions(normals.size(), Vec3::Zero());
        for (std::size_t v = 0; v < normals.size(); ++v)
            if (is_unit(normals[v])) directions[v] = normals[v].unitOrthogonal();
        fit_along(directions, mesh, active, faces, slide);
        for (std::size_t v = 0; v < normals.size(); ++v) directions[v] = normals[v].cross(directions[v]);
        fit_along(directions, mesh, active, faces, slide);
    }
    const std::vector<double> costs = displacement_costs(mesh, faces, normals);
    fit_along(normals, mesh, active, faces,
              {.most_edges = options.most_edges, .damping = options.damping, .faces = not_turned});
    return costs;
}

}  // namespace anyrate
