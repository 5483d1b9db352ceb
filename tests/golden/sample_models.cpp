#include "tests/golden/sample_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "proto/log_writer.h"

namespace anyrate::samples {

namespace {

/// Nearest point of the grid that a base may stand on.
GridPoint snap(const Grid& grid, const Vec3& world) {
    const int unit = 1 << grid.base_shift;
    const auto coordinate = [&](int axis) {
        const double steps = (world[axis] - grid.origin[axis]) / (grid.unit * unit);
        return unit * static_cast<std::int32_t>(std::floor(steps + 0.5));
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
}

/// Splits every triangle into four at its edge midpoints.
void subdivide(std::vector<Vec3>& points, std::vector<Triangle>& faces) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> midpoints;
    const auto midpoint = [&](std::int32_t a, std::int32_t b) {
        const auto [entry, is_new] = midpoints.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(points.size()));
        if (is_new) points.push_back((points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)]) / 2);
        return entry->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : faces) {
        const std::int32_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
}

/// Radius of the bumpy sphere in a direction: a polynomial of its coordinates.
double bumpy_radius(const Vec3& direction) {
    const double bump = direction.x() * direction.y() * direction.z();
    return 0.75 + 0.35 * bump + 0.1 * direction.x() * direction.x();
}

Rgb8 solid_texture(const Vec3& p) {
    const auto channel = [](double x) { return static_cast<std::uint8_t>(std::clamp(std::floor(x), 0.0, 255.0)); };
    const double stripes = std::fabs(4 * p.z() - std::floor(4 * p.z()) - 0.5);
    return {channel(150 + 100 * p.x()), channel(140 + 90 * p.y() * p.z()), channel(60 + 300 * stripes)};
}

std::vector<Rgb8> textured(const Grid& grid, std::span<const GridPoint> positions) {
    std::vector<Rgb8> colours;
    for (const GridPoint& p : positions) colours.push_back(solid_texture(grid.to_world(p)));
    return colours;
}

std::int64_t longest_edge(const RefinableMesh& mesh, std::int32_t face) {
    const Triangle& t = mesh.triangles()[static_cast<std::size_t>(face)];
    std::int64_t longest = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const GridPoint& p = mesh.positions()[static_cast<std::size_t>(t[i])];
        const GridPoint& q = mesh.positions()[static_cast<std::size_t>(t[(i + 1) % 3])];
        const std::int64_t x = q.x - p.x, y = q.y - p.y, z = q.z - p.z;
        longest = std::max(longest, x * x + y * y + z * z);
    }
    return longest;
}

/// Faces whose splits touch no common vertex, longest edges first; returned ascending.
std::vector<std::int32_t> choose_faces(const RefinableMesh& mesh, int n_wanted) {
    std::vector<std::pair<std::int64_t, std::int32_t>> ranked;
    for (std::int32_t f = 0; f < mesh.n_faces(); ++f) ranked.emplace_back(-longest_edge(mesh, f), f);
    std::sort(ranked.begin(), ranked.end());
    std::set<std::int32_t> touched;
    std::vector<std::int32_t> chosen;
    for (const auto& [rank, face] : ranked) {
        const auto site = mesh.split_site(face);
        if (!site || std::ranges::any_of(*site, [&](std::int32_t v) { return touched.contains(v); })) continue;
        touched.insert(site->begin(), site->end());
        chosen.push_back(face);
        if (static_cast<int>(chosen.size()) == n_wanted) break;
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

SampleLog log_of_batches(const Grid& grid, const BaseMesh& base, const SampleOptions& options,
                         const std::function<std::vector<std::int32_t>(const RefinableMesh&)>& choose) {
    std::vector<std::byte> bytes;
    const ColourCoding to_the_nearest{.steps = {.luma = 4, .chroma = 6}, .bit_price = 0};
    LogWriter writer(
        options.log_id, [&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); },
        to_the_nearest);
    RefinableMesh mesh(writer.start(grid, options.rules, base), grid, options.rules);
    std::vector<Rgb8> wished;
    if (options.colours) wished = textured(grid, mesh.positions());
    writer.base_attributes(wished, {100, 400});
    std::vector<std::uint32_t> hash_at = {mesh.state_hash()};
    for (int b = 1; b <= options.n_batches; ++b) {
        std::vector<SplitRecord> records;
        const auto before = static_cast<std::size_t>(mesh.n_vertices());
        for (const std::int32_t face : choose(mesh)) {
            if (!mesh.split_site(face)) continue;  // a flip of this batch may have changed it
            records.push_back(
                mesh.split(face, [&](const ScalarSite& site) { return towards_bumpy_sphere(grid, site); }));
            hash_at.push_back(mesh.state_hash());
        }
        std::vector<Rgb8> new_colours;
        if (options.colours) new_colours = textured(grid, mesh.positions().subspan(before));
        writer.batch(records, mesh, new_colours, {100.0 / (b + 1), 400.0 / (b + 1)});
        wished.insert(wished.end(), new_colours.begin(), new_colours.end());
    }
    writer.finish();
    return {bytes, {writer.rows().begin(), writer.rows().end()}, hash_at, mesh, wished};
}

}  // namespace

Grid unit_grid(int bits) {
    Grid grid;
    grid.bits = bits;
    grid.base_shift = 2;
    grid.origin = Vec3(-1, -1, -1);
    grid.unit = 2.0 / (1 << bits);
    return grid;
}

BaseMesh octahedron(const Grid& grid) {
    BaseMesh base;
    for (const Vec3& p :
         {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(-1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, -1)}) {
        base.positions.push_back(snap(grid, 0.75 * p));
    }
    base.triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
    return base;
}

BaseMesh icosphere(const Grid& grid, int n_subdivisions) {
    const double g = (1 + std::sqrt(5.0)) / 2;  // golden ratio
    std::vector<Vec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    std::vector<Triangle> faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                   {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                   {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int level = 0; level < n_subdivisions; ++level) subdivide(points, faces);
    BaseMesh base;
    for (const Vec3& p : points) {
        const double radius = std::sqrt((p.x() * p.x() + p.y() * p.y()) + p.z() * p.z());
        base.positions.push_back(snap(grid, (0.75 / radius) * p));
    }
    base.triangles = std::move(faces);
    return base;
}

BaseMesh flat_cube(const Grid& grid, int n_subdivisions) {
    std::vector<Vec3> points;
    for (int corner = 0; corner < 8; ++corner) {
        points.push_back(0.5 * Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1));
    }
    std::vector<Triangle> faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (int level = 0; level < n_subdivisions; ++level) subdivide(points, faces);
    BaseMesh base{{}, std::move(faces)};
    for (const Vec3& p : points) base.positions.push_back(snap(grid, p));
    return base;
}

BaseMesh square_torus(const Grid& grid) {
    // Twelve stations around a square of side 1; at each, four points of a small square across the ring.
    const std::array<Vec3, 4> corners = {Vec3(-0.5, -0.5, 0), Vec3(0.5, -0.5, 0), Vec3(0.5, 0.5, 0),
                                         Vec3(-0.5, 0.5, 0)};
    std::vector<Vec3> stations;
    for (std::size_t c = 0; c < 4; ++c) {
        for (int k = 0; k < 3; ++k) stations.push_back(corners[c] + k * (corners[(c + 1) % 4] - corners[c]) / 3);
    }
    BaseMesh base;
    for (const Vec3& station : stations) {
        for (const auto& [outward, up] : {std::pair(1, 0), std::pair(0, 1), std::pair(-1, 0), std::pair(0, -1)}) {
            base.positions.push_back(snap(grid, station * (1 + 0.25 * outward) + Vec3(0, 0, 0.2 * up)));
        }
    }
    const auto n = static_cast<std::int32_t>(stations.size());
    for (std::int32_t i = 0; i < n; ++i) {
        for (std::int32_t j = 0; j < 4; ++j) {
            const std::int32_t a = 4 * i + j, b = 4 * ((i + 1) % n) + j;
            const std::int32_t c = 4 * ((i + 1) % n) + (j + 1) % 4, d = 4 * i + (j + 1) % 4;
            base.triangles.insert(base.triangles.end(), {{a, b, c}, {a, c, d}});
        }
    }
    return base;
}

std::int32_t towards_bumpy_sphere(const Grid& grid, const ScalarSite& site) {
    const Vec3 p = grid.origin + grid.unit * site.position;
    const double radius = std::sqrt((p.x() * p.x() + p.y() * p.y()) + p.z() * p.z());
    const Vec3 direction = p / radius;
    const double along =
        (direction.x() * site.normal.x() + direction.y() * site.normal.y()) + direction.z() * site.normal.z();
    if (along < 0.2) return 0;
    const double scalar = (bumpy_radius(direction) - radius) / (along * grid.unit * site.step);
    return static_cast<std::int32_t>(std::floor(std::clamp(scalar, -60.0, 60.0) + 0.5));
}

SampleLog make_log(const Grid& grid, const BaseMesh& base, const SampleOptions& options) {
    return log_of_batches(grid, base, options,
                          [&](const RefinableMesh& mesh) { return choose_faces(mesh, options.splits_per_batch); });
}

RefinementRules first_rules() { return {.flip_rule = FlipRule::delaunay, .ring_smoothing = RingSmoothing::quarter}; }

SampleLog octahedron_log() {
    const Grid grid = unit_grid(10);
    // One batch of the first face and of the first other one that can be split behind it.
    return log_of_batches(grid, octahedron(grid), {.rules = first_rules()}, [](const RefinableMesh&) {
        return std::vector<std::int32_t>{0, 6};
    });
}

SampleLog icosphere_log() {
    const Grid grid = unit_grid(12);
    return make_log(grid, icosphere(grid, 1),
                    {.n_batches = 24, .splits_per_batch = 20, .log_id = 42, .rules = first_rules()});
}

SampleLog cube_log() {
    const Grid grid = unit_grid(12);
    return make_log(grid, flat_cube(grid, 2),
                    {.n_batches = 12,
                     .splits_per_batch = 20,
                     .log_id = 43,
                     .rules = {.flip_rule = FlipRule::crease_preserving, .ring_smoothing = RingSmoothing::sixteenth}});
}

SampleLog sphere_log() {
    const Grid grid = unit_grid(12);
    return make_log(grid, icosphere(grid, 1), {.n_batches = 16, .splits_per_batch = 20, .log_id = 44});
}

}  // namespace anyrate::samples
