#include "core/reconstruction/fuse_points.h"

#include <cmath>

#include <Eigen/Geometry>

#include "core/parallel.h"
#include "core/reconstruction/point_grid.h"

namespace anyrate {
namespace {

// The mean point of every cube, two where the two sides of a thin wall share one. `area` counts the points.
std::vector<OrientedPoint> cube_means(std::span<const OrientedPoint> points, double edge) {
    std::vector<OrientedPoint> means;
    PointGrid(points, edge).for_each_cube([&](const std::vector<OrientedPoint>& in_cube) {
        for (const bool front : {true, false}) {
            OrientedPoint sum{Vec3::Zero(), Vec3::Zero(), 0.0};
            for (const OrientedPoint& point : in_cube) {
                if ((point.normal.dot(in_cube.front().normal) > 0) != front) continue;
                sum.position += point.position;
                sum.normal += point.normal;
                sum.area += 1.0;
            }
            if (sum.normal.norm() > 0) means.push_back({sum.position / sum.area, sum.normal.normalized(), sum.area});
        }
    });
    return means;
}

// Every mean moved along the normal into the middle of those around it, if they stand for enough points.
std::vector<OrientedPoint> smoothed(std::span<const OrientedPoint> means, double pixel) {
    constexpr double radius_px = 2.5, fewest_points = 20.0;
    const PointGrid grid(means, radius_px * pixel);
    std::vector<OrientedPoint> smooth(means.size());
    parallel_for(means.size(), [&](std::size_t p) {
        OrientedPoint sum{Vec3::Zero(), Vec3::Zero(), 0.0};
        grid.for_each_near(means[p], [&](const OrientedPoint& other) {
            sum.position += other.area * (other.position - means[p].position);
            sum.normal += other.area * other.normal;
            sum.area += other.area;
            return true;
        });
        if (sum.area < fewest_points) return;
        const Vec3 normal = sum.normal.normalized();
        // A surface element cuts the cubes of a grid at this rate.
        smooth[p] = {means[p].position + normal * (normal.dot(sum.position) / sum.area), normal,
                     pixel * pixel / normal.lpNorm<1>()};
    });
    std::erase_if(smooth, [](const OrientedPoint& point) { return point.area == 0; });
    return smooth;
}

// A point as a square patch of n x n points of its tangent plane.
void add_patch(const OrientedPoint& point, double edge, int n, std::vector<OrientedPoint>& points) {
    const Vec3 across = point.normal.unitOrthogonal(), along = point.normal.cross(across);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const double u = (i + 0.5) / n - 0.5, v = (j + 0.5) / n - 0.5;
            points.push_back({point.position + edge * (u * across + v * along), point.normal, point.area / (n * n)});
        }
}

}  // namespace

std::vector<OrientedPoint> fuse_points(std::span<const OrientedPoint> points, double pixel, double spacing) {
    std::vector<OrientedPoint> fused;
    for (const OrientedPoint& point : smoothed(cube_means(points, pixel), pixel))
        add_patch(point, pixel, static_cast<int>(std::ceil(pixel / spacing)), fused);
    return fused;
}

}  // namespace anyrate
