#include "core/mesh/surface_meter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/mesh/closest_point.h"
#include "core/mesh/triangle_shape.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

// Points a face, and as many of the true surface for each: enough that noise of the sampling does not show in a fit.
constexpr int least_steps = 2, most_steps = 6;
constexpr std::size_t samples_per_face = 3;
constexpr std::size_t stretch_of_tour = 256;  ///< samples, each of which searches from where the one before ended

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// A pair of points, one on a face, one on the true surface, that should meet.
struct Pair {
    Vec3 weights;       ///< of the face's corners
    double offset = 0;  ///< from the face's point to the true one along the true normal
    double squared_distance = 0;
    Vec3 true_normal;
};

/// One face of a mesh.
struct Corners {
    Corners(const Mesh& mesh, std::size_t face)
        : numbers(mesh.triangles[face]),
          points{mesh.vertices[at(numbers[0])], mesh.vertices[at(numbers[1])], mesh.vertices[at(numbers[2])]},
          twice_area(twice_area_vector(points[0], points[1], points[2])) {}

    double area() const { return 0.5 * twice_area.norm(); }
    double longest_squared_edge() const {
        const auto& [a, b, c] = points;
        return std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    }

    Triangle numbers;
    std::array<Vec3, 3> points;
    Vec3 twice_area;
};

/// The nearest point that faces alike, so that a thin part is not taken for its other side. Of a face that is turned
/// over there is none but on the far side of the object: further off than the face is long, what is nearest counts,
/// whichever way it faces. Else one sliver outweighs all other faces (nefertiti at 3,000 vertices: it had 90 % of the
/// squared distance) and is pulled through the object.
/// @param reach2  squared, for what was found
template <class SquaredReach>
NearestSurface::Hit nearest_alike(const NearestSurface& surface, const Vec3& point, const Vec3& direction,
                                  std::int32_t hint, const SquaredReach& reach2) {
    const NearestSurface::Hit hit = surface.nearest_facing(point, direction, hint);
    return hit.face >= 0 && hit.squared_distance <= reach2(hit) ? hit : surface.nearest(point, hint);
}

/// @param touched  the face's point nearest to `sample`
Pair pair_from_surface(const Corners& corners, const Vec3& touched, const Vec3& sample, const Vec3& normal) {
    const auto& [a, b, c] = corners.points;
    const Vec3 offset = sample - touched;
    return {barycentric(touched, a, b, c), offset.dot(normal), offset.squaredNorm(), normal};
}

/// @param hint  where the last search ended; where this one did
Pair pair_from_face(const Corners& corners, const Vec3& weights, const TrueSurface& surface, std::int32_t& hint) {
    const auto& [a, b, c] = corners.points;
    const Vec3 point = weights[0] * a + weights[1] * b + weights[2] * c;
    const NearestSurface::Hit hit = nearest_alike(surface.nearest, point, corners.twice_area, hint,
                                                  [&](const auto&) { return corners.longest_squared_edge(); });
    hint = hit.face;
    const Vec3& normal = surface.face_normals[at(hit.face)];
    return {weights, (hit.point - point).dot(normal), hit.squared_distance, normal};
}

void add(FaceDistance& sum, const Pair& pair, double area) {
    sum.area += area;
    sum.squared += area * pair.squared_distance;
}

void add(FaceQuadratic& sum, const Pair& pair, double area) {
    const Vec3 &w = pair.weights, &n = pair.true_normal;
    const Symmetric3 projector{n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[1] * n[2], n[2] * n[0]};
    const std::array<double, 6> products{w[0] * w[0], w[1] * w[1], w[2] * w[2], w[0] * w[1], w[1] * w[2], w[2] * w[0]};
    for (std::size_t k = 0; k < 3; ++k) sum.gradient[k] -= (2 * area * pair.offset * w[static_cast<int>(k)]) * n;
    for (std::size_t k = 0; k < products.size(); ++k)
        for (std::size_t i = 0; i < projector.size(); ++i) sum.hessian[k][i] += 2 * area * products[k] * projector[i];
}

/// The centres of the n * n equal triangles that a triangle divides into, as weights of its corners.
std::vector<Vec3> centres(int n) {
    std::vector<Vec3> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
            for (const double up : {1.0, 2.0}) {
                if (up == 2.0 && i + j + 2 > n) continue;
                const double x = (i + up / 3) / n, y = (j + up / 3) / n;
                points.emplace_back(1 - x - y, x, y);
            }
        }
    return points;
}

int steps_for(std::size_t n_faces, int fewest_points) {
    const double wanted = fewest_points / static_cast<double>(n_faces);
    return std::clamp(static_cast<int>(std::sqrt(wanted)), least_steps, most_steps);
}

/// Positions `i` of `keys` in the order of their keys in [0, n_keys), and where each key begins.
struct Buckets {
    std::vector<std::size_t> begin, order;
};
Buckets bucket(std::span<const std::int32_t> keys, std::size_t n_keys) {
    Buckets result{std::vector<std::size_t>(n_keys + 1, 0), std::vector<std::size_t>(keys.size())};
    for (const std::int32_t key : keys) ++result.begin[at(key) + 1];
    std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
    std::vector<std::size_t> next(result.begin.begin(), result.begin.end() - 1);
    for (std::size_t i = 0; i < keys.size(); ++i) result.order[next[at(keys[i])]++] = i;
    return result;
}

}  // namespace

std::vector<Vec3> SurfaceMeter::nearest_to_samples(const Mesh& mesh, std::size_t n_samples) {
    const NearestSurface tree(mesh);
    std::vector<Vec3> points(n_samples);
    const std::vector<std::int32_t>& tour = surface_.samples_in_tour;
    parallel_for((tour.size() + stretch_of_tour - 1) / stretch_of_tour,
                 [&](std::size_t stretch) {
                     std::int32_t neighbour = -1;  // the face found last
                     const std::size_t end = std::min(tour.size(), (stretch + 1) * stretch_of_tour);
                     for (std::size_t place = stretch * stretch_of_tour; place < end; ++place) {
                         const std::size_t i = at(tour[place]);
                         if (i >= n_samples) continue;
                         // What was found for the sample itself may be a face of a trial that was not taken.
                         const std::int32_t own = nearest_of_sample_[i];
                         const std::int32_t hint = own >= 0 && own < mesh.n_faces() ? own : neighbour;
                         const Vec3& sample = surface_.samples[i];
                         const Vec3& normal = surface_.face_normals[at(surface_.sample_faces[i])];
                         const NearestSurface::Hit hit = nearest_alike(
                             tree, sample, normal, hint,
                             [&](const auto& found) { return Corners(mesh, at(found.face)).longest_squared_edge(); });
                         nearest_of_sample_[i] = neighbour = hit.face;
                         points[i] = hit.point;
                     }
                 },
                 1);
    return points;
}

template <class Face>
std::vector<Face> SurfaceMeter::measure(const Mesh& mesh) {
    const std::size_t n_faces = mesh.triangles.size();
    nearest_of_face_.resize(n_faces, -1);
    nearest_of_sample_.resize(surface_.samples.size(), -1);
    const std::size_t n_samples = std::min(
        surface_.samples.size(), std::max(static_cast<std::size_t>(fewest_points_), samples_per_face * n_faces));
    const std::vector<Vec3> touched = nearest_to_samples(mesh, n_samples);
    const Buckets by_face = bucket(std::span(nearest_of_sample_).first(n_samples), n_faces);
    const double area_of_sample = 0.5 * surface_.area / static_cast<double>(n_samples);
    const std::vector<Vec3> lattice = centres(steps_for(n_faces, fewest_points_));

    std::vector<Face> result(n_faces);
    parallel_for(n_faces, [&](std::size_t f) {
        const Corners corners(mesh, f);
        Face& sum = result[f];
        for (std::size_t k = by_face.begin[f]; k < by_face.begin[f + 1]; ++k) {
            const std::size_t i = by_face.order[k];
            const std::int32_t true_face = surface_.sample_faces[i];
            if (nearest_of_face_[f] < 0) nearest_of_face_[f] = true_face;
            add(sum, pair_from_surface(corners, touched[i], surface_.samples[i], surface_.face_normals[at(true_face)]),
                area_of_sample);
        }
        const double area_of_point = 0.5 * corners.area() / static_cast<double>(lattice.size());
        for (const Vec3& weights : lattice)
            add(sum, pair_from_face(corners, weights, surface_, nearest_of_face_[f]), area_of_point);
    });
    return result;
}

std::vector<FaceDistance> SurfaceMeter::distances(const Mesh& mesh) { return measure<FaceDistance>(mesh); }

std::vector<FaceQuadratic> SurfaceMeter::quadratics(const Mesh& mesh) { return measure<FaceQuadratic>(mesh); }

}  // namespace anyrate
