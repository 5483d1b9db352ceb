#include "core/reconstruction/normal_displacement.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A product with fewer rows is done before other threads have woken up.
constexpr std::size_t rows_at_a_time = 2048;

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

/// Where each of `n` things stands in an ascending list of some of them, -1 where it does not.
std::vector<std::int32_t> inverse_of(std::span<const std::int32_t> list, std::size_t n) {
    std::vector<std::int32_t> place(n, -1);
    for (std::size_t i = 0; i < list.size(); ++i) place[at(list[i])] = static_cast<std::int32_t>(i);
    return place;
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

std::vector<double> ring_means(std::span<const double> values, const OneRings& rings,
                               std::span<const std::int32_t> vertices, std::size_t n_vertices) {
    const std::vector<std::int32_t> place = inverse_of(vertices, n_vertices);
    std::vector<double> means(vertices.size());
    parallel_for(vertices.size(), [&](std::size_t i) {
        double sum = values[i];
        int n = 1;
        for (const std::int32_t w : rings.neighbours(vertices[i]))
            if (const std::int32_t k = place[at(w)]; k >= 0) {
                sum += values[at(k)];
                ++n;
            }
        means[i] = sum / n;
    });
    return means;
}

NormalDisplacement::NormalDisplacement(const SurfaceView& surface, const OneRings& rings, std::span<const Vec3> normals,
                                       std::span<const std::int32_t> active, std::span<const std::int32_t> faces,
                                       std::span<const TriangleTerms> terms,
                                       std::span<const SilhouetteTerm> silhouettes, const Regularity& regularity)
    : n_(active.size()), bending_weight_(regularity.bending), begin_(n_ + 1, 0), gradient_(n_), diagonal_(n_) {
    const std::vector<std::int32_t> active_index = inverse_of(active, surface.vertices.size());
    const std::vector<std::int32_t> face_slot = inverse_of(faces, surface.triangles.size());
    for (std::size_t i = 0; i < n_; ++i) {
        const auto ring = rings.neighbours(active[i]);
        const auto n_active = std::ranges::count_if(ring, [&](std::int32_t w) { return active_index[at(w)] >= 0; });
        begin_[i + 1] = begin_[i] + 1 + static_cast<std::size_t>(n_active);
    }
    entries_.resize(begin_.back());
    std::vector<double> bent(n_);
    parallel_for(n_, [&](std::size_t i) {
        const std::int32_t v = active[i];
        const std::span<Entry> own(entries_.data() + begin_[i], begin_[i + 1] - begin_[i]);
        const auto ring = rings.neighbours(v);
        bent[i] = umbrella(surface, rings, v).dot(normals[at(v)]) - regularity.rest[i];
        own[0] = {static_cast<std::int32_t>(i), 0, -1, -1};
        std::size_t n = 1;
        for (std::int32_t w : ring) {
            if (active_index[at(w)] < 0) continue;
            const double cosine = normals[at(v)].dot(normals[at(w)]);
            own[n++] = {active_index[at(w)], 0, cosine / static_cast<double>(ring.size()),
                        cosine / static_cast<double>(rings.valence(w))};
        }
        for (std::int32_t face : rings.faces(v)) {
            if (face_slot[at(face)] < 0) continue;
            const Triangle& t = surface.triangles[at(face)];
            const TriangleTerms& of_face = terms[at(face_slot[at(face)])];
            const auto corner = static_cast<std::size_t>(std::ranges::find(t, v) - t.begin());
            gradient_[i] += of_face.gradient[corner];
            for (std::size_t k = 0; k < 3; ++k) {
                const auto entry = std::ranges::find(own, active_index[at(t[k])], &Entry::vertex);
                if (entry != own.end()) entry->hessian += of_face.hessian[hessian_slot(corner, k)];
            }
        }
        gradient_[i] += regularity.silhouette[i] * silhouettes[i].gradient;
        own[0].hessian += regularity.silhouette[i] * silhouettes[i].hessian;
    });
    parallel_for(n_, [&](std::size_t i) {
        diagonal_[i] = row(i).front().hessian;
        for (const Entry& e : row(i)) {
            gradient_[i] += 2 * bending_weight_ * bent[at(e.vertex)] * e.transpose;
            diagonal_[i] += 2 * bending_weight_ * e.transpose * e.transpose;
        }
    });
}

void NormalDisplacement::apply(std::span<const double> u, double damping, std::span<double> bent,
                               std::span<double> out) const {
    parallel_for(
        n_,
        [&](std::size_t i) {
            double umbrella = 0, hessian = damping * diagonal_[i] * u[i];
            for (const Entry& e : row(i)) {
                umbrella += e.umbrella * u[at(e.vertex)];
                hessian += e.hessian * u[at(e.vertex)];
            }
            bent[i] = umbrella;
            out[i] = hessian;
        },
        rows_at_a_time);
    parallel_for(
        n_,
        [&](std::size_t i) {
            double sum = 0;
            for (const Entry& e : row(i)) sum += e.transpose * bent[at(e.vertex)];
            out[i] += 2 * bending_weight_ * sum;
        },
        rows_at_a_time);
}

std::vector<double> NormalDisplacement::solve(double damping) const {
    std::vector<double> u(n_, 0.0), r(n_), z(n_), p(n_), Ap(n_), bent(n_), damped(n_);
    for (std::size_t i = 0; i < n_; ++i) damped[i] = diagonal_[i] * (1 + damping);
    // Preconditions the residual: by the damped diagonal.
    const auto conditioned = [&](std::size_t i) { return diagonal_[i] > 0 ? r[i] / damped[i] : 0.0; };
    double rz = 0;
    for (std::size_t i = 0; i < n_; ++i) {
        r[i] = -gradient_[i];
        p[i] = conditioned(i);
        rz += r[i] * p[i];
    }
    const double target = cg_tolerance * cg_tolerance * rz;
    for (int k = 0; k < max_cg_iterations && rz > target; ++k) {
        apply(p, damping, bent, Ap);
        double pAp = 0;
        for (std::size_t i = 0; i < n_; ++i) pAp += p[i] * Ap[i];
        if (!(pAp > 0)) break;
        const double alpha = rz / pAp;
        double next = 0;
        for (std::size_t i = 0; i < n_; ++i) {
            u[i] += alpha * p[i];
            r[i] -= alpha * Ap[i];
            z[i] = conditioned(i);
            next += r[i] * z[i];
        }
        const double beta = next / rz;
        rz = next;
        for (std::size_t i = 0; i < n_; ++i) p[i] = z[i] + beta * p[i];
    }
    return u;
}

}  // namespace anyrate
