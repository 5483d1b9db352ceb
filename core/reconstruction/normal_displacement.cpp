#include "core/reconstruction/normal_displacement.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

constexpr int max_cg_iterations = 60;
constexpr double cg_tolerance = 1e-3;  ///< of the residual's norm: the step is damped and clamped anyway

double dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

Vec3 umbrella(const SurfaceView& surface, const OneRings& rings, std::int32_t v) {
    Vec3 mean = Vec3::Zero();
    const auto ring = rings.neighbours(v);
    for (std::int32_t w : ring) mean += surface.vertices[at(w)];
    return mean / static_cast<double>(ring.size()) - surface.vertices[at(v)];
}

/// Entry (a, b) of a triangle's Hessian in the order of TriangleTerms.
std::size_t hessian_slot(std::size_t a, std::size_t b) {
    if (a == b) return a;
    return a + b == 1 ? 3 : a + b == 3 ? 4 : 5;
}

}  // namespace

std::vector<double> umbrellas(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                              std::span<const std::int32_t> vertices) {
    std::vector<double> along(vertices.size());
    parallel_for(vertices.size(), [&](std::size_t i) {
        along[i] = umbrella(surface, rings, vertices[i]).dot(normals[at(vertices[i])]);
    });
    return along;
}

NormalDisplacement::NormalDisplacement(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                                       std::span<const std::int32_t> active, std::span<const std::int32_t> faces,
                                       std::span<const TriangleTerms> terms,
                                       std::span<const SilhouetteTerm> silhouettes, const Regularity& regularity)
    : n_(active.size()), bending_weight_(regularity.bending) {
    std::vector<std::int32_t> active_index(surface.vertices.size(), -1);
    for (std::size_t i = 0; i < n_; ++i) active_index[at(active[i])] = static_cast<std::int32_t>(i);

    gradient_.assign(n_, 0.0);
    own_hessian_.assign(n_, 0.0);
    diagonal_.assign(n_, 0.0);
    face_active_.resize(faces.size());
    face_hessian_.resize(faces.size());
    vertex_faces_.resize(n_);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        face_hessian_[f] = terms[f].hessian;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int32_t i = active_index[at(surface.triangles[at(faces[f])][a])];
            face_active_[f][a] = i;
            if (i < 0) continue;
            vertex_faces_[at(i)].emplace_back(static_cast<std::int32_t>(f), static_cast<std::int32_t>(a));
            gradient_[at(i)] += terms[f].gradient[a];
            diagonal_[at(i)] += terms[f].hessian[a];
        }
    }
    for (std::size_t i = 0; i < n_; ++i) {
        const double w = regularity.silhouette[i];
        gradient_[i] += w * silhouettes[i].gradient;
        own_hessian_[i] = w * silhouettes[i].hessian;
        diagonal_[i] += own_hessian_[i];
    }

    umbrellas_.resize(n_);
    vertex_umbrellas_.resize(n_);
    for (std::size_t i = 0; i < n_; ++i) {
        const std::int32_t v = active[i];
        const auto ring = rings.neighbours(v);
        Umbrella& u = umbrellas_[i];
        u.value = umbrella(surface, rings, v).dot(normals[at(v)]) - regularity.rest[i];
        u.coefficients.emplace_back(static_cast<std::int32_t>(i), -1.0);
        for (std::int32_t w : ring)
            if (const std::int32_t j = active_index[at(w)]; j >= 0)
                u.coefficients.emplace_back(j, normals[at(v)].dot(normals[at(w)]) / static_cast<double>(ring.size()));
        for (const auto& [j, c] : u.coefficients) {
            gradient_[at(j)] += 2 * bending_weight_ * u.value * c;
            diagonal_[at(j)] += 2 * bending_weight_ * c * c;
            vertex_umbrellas_[at(j)].emplace_back(static_cast<std::int32_t>(i), c);
        }
    }
}

std::vector<double> NormalDisplacement::apply(std::span<const double> u, double damping) const {
    std::vector<double> bent(n_), out(n_);
    parallel_for(
        n_,
        [&](std::size_t i) {
            double sum = 0;
            for (const auto& [j, c] : umbrellas_[i].coefficients) sum += c * u[at(j)];
            bent[i] = sum;
        },
        512);
    parallel_for(
        n_,
        [&](std::size_t i) {
            double sum = own_hessian_[i] * u[i] + damping * diagonal_[i] * u[i];
            for (const auto& [f, a] : vertex_faces_[i])
                for (std::size_t b = 0; b < 3; ++b)
                    if (const std::int32_t j = face_active_[at(f)][b]; j >= 0)
                        sum += face_hessian_[at(f)][hessian_slot(at(a), b)] * u[at(j)];
            for (const auto& [row, c] : vertex_umbrellas_[i]) sum += 2 * bending_weight_ * c * bent[at(row)];
            out[i] = sum;
        },
        512);
    return out;
}

std::vector<double> NormalDisplacement::solve(double damping) const {
    std::vector<double> u(n_, 0.0), r(n_), z(n_), p(n_);
    const auto precondition = [&] {
        for (std::size_t i = 0; i < n_; ++i) z[i] = diagonal_[i] > 0 ? r[i] / (diagonal_[i] * (1 + damping)) : 0.0;
    };
    for (std::size_t i = 0; i < n_; ++i) r[i] = -gradient_[i];
    precondition();
    p = z;
    double rz = dot(r, z);
    const double target = cg_tolerance * cg_tolerance * rz;
    for (int k = 0; k < max_cg_iterations && rz > target; ++k) {
        const std::vector<double> Ap = apply(p, damping);
        const double pAp = dot(p, Ap);
        if (!(pAp > 0)) break;
        const double alpha = rz / pAp;
        for (std::size_t i = 0; i < n_; ++i) {
            u[i] += alpha * p[i];
            r[i] -= alpha * Ap[i];
        }
        precondition();
        const double next = dot(r, z);
        const double beta = next / rz;
        rz = next;
        for (std::size_t i = 0; i < n_; ++i) p[i] = z[i] + beta * p[i];
    }
    return u;
}

}  // namespace anyrate
