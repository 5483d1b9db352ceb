#include "core/reconstruction/poisson.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "core/error.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

// The discrete problem. With chi_i at the nodes, h the spacing and V on the grid's edges, minimise
//     sum over edges ij of (chi_j - chi_i - h V_ij)^2  +  sum over nodes of sigma_i (chi_i - tau_i)^2,
// chi = 1/2 on the border. V is the points' normals times area, spread by the trilinear kernel on the lattice of edge
// midpoints of each axis, so that its divergence below is the exact adjoint of the gradient. The normal equations,
//     (6 + sigma_i) chi_i - sum of six neighbours = sigma_i tau_i + (h V in) - (h V out),
// are solved for u = chi - 1/2, which is zero on the border, by full multigrid (Brandt 1977).
//
// What differs from Kazhdan and Hoppe 2013: they ask chi to vanish at the points, which couples the 27 nodes around
// each. Here the same wish is put on the nodes: tau_i is the indicator, smoothed by the kernel, of the plane through a
// nearby point, so the zero set passes through the points to the second order, and the matrix keeps seven diagonals.

struct Dimensions {
    int nx = 0, ny = 0, nz = 0;
    std::size_t row() const { return static_cast<std::size_t>(nx); }
    std::size_t plane() const { return row() * static_cast<std::size_t>(ny); }
    std::size_t n_nodes() const { return plane() * static_cast<std::size_t>(nz); }
    std::size_t node(int i, int j, int k) const {
        return static_cast<std::size_t>(k) * plane() + static_cast<std::size_t>(j) * row() +
               static_cast<std::size_t>(i);
    }
};

// One grid of the hierarchy: unknown, right-hand side and screening. Border nodes stay zero.
struct Level {
    Dimensions size;
    std::vector<float> u, f, sigma;

    explicit Level(const Dimensions& dimensions)
        : size(dimensions), u(size.n_nodes()), f(size.n_nodes()), sigma(size.n_nodes()) {}
};

// ---- multigrid

// Gauss-Seidel on the nodes of one colour of a three-dimensional chequerboard, which depend on the other colour only.
void relax_colour(Level& level, int colour) {
    const Dimensions& n = level.size;
    const std::size_t row = n.row(), plane = n.plane();
    parallel_for(
        static_cast<std::size_t>(n.nz - 2),
        [&](std::size_t plane_above_border) {
            const int k = static_cast<int>(plane_above_border) + 1;
            for (int j = 1; j + 1 < n.ny; ++j) {
                const std::size_t start = n.node(0, j, k);
                float* u = level.u.data() + start;
                const float* f = level.f.data() + start;
                const float* sigma = level.sigma.data() + start;
                for (int i = 1 + (1 + j + k + colour) % 2; i + 1 < n.nx; i += 2) {
                    const float neighbours =
                        u[i - 1] + u[i + 1] + *(u + i - row) + *(u + i + row) + *(u + i - plane) + *(u + i + plane);
                    u[i] = (f[i] + neighbours) / (6.0f + sigma[i]);
                }
            }
        },
        4);
}

void relax(Level& level, int n_sweeps) {
    for (int sweep = 0; sweep < n_sweeps; ++sweep)
        for (const int colour : {0, 1}) relax_colour(level, colour);
}

float residual(const Level& level, std::size_t node) {
    const std::size_t row = level.size.row(), plane = level.size.plane();
    const float* u = level.u.data() + node;
    const float neighbours = *(u - 1) + *(u + 1) + *(u - row) + *(u + row) + *(u - plane) + *(u + plane);
    return level.f[node] + neighbours - (6.0f + level.sigma[node]) * *u;
}

// Full weighting, to the inner nodes of the twice coarser grid, of value(fine node), times 4: the seven-point operator
// of spacing 2h carries a factor 1/4 against that of h, which is moved to the right-hand side and the screening.
template <class Value>
void restrict_to(const Dimensions& coarse, const Dimensions& fine, const Value& value, std::vector<float>& result) {
    static constexpr std::array<float, 3> weights = {0.25f, 0.5f, 0.25f};
    parallel_for(
        static_cast<std::size_t>(coarse.nz - 2),
        [&](std::size_t plane_above_border) {
            const int k = static_cast<int>(plane_above_border) + 1;
            std::vector<float> line(fine.row());
            for (int j = 1; j + 1 < coarse.ny; ++j) {
                std::fill(line.begin(), line.end(), 0.0f);
                for (int dk = -1; dk <= 1; ++dk)
                    for (int dj = -1; dj <= 1; ++dj) {
                        const float weight = 4.0f * weights[static_cast<std::size_t>(dk + 1)] *
                                             weights[static_cast<std::size_t>(dj + 1)];
                        const std::size_t start = fine.node(0, 2 * j + dj, 2 * k + dk);
                        for (std::size_t i = 1; i + 1 < line.size(); ++i) line[i] += weight * value(start + i);
                    }
                float* target = result.data() + coarse.node(0, j, k);
                for (std::size_t i = 1; i + 1 < coarse.row(); ++i)
                    target[i] = 0.25f * line[2 * i - 1] + 0.5f * line[2 * i] + 0.25f * line[2 * i + 1];
            }
        },
        1);
}

// Adds the trilinear interpolation of the coarse unknown to the fine one.
void add_prolongation(const Level& coarse, Level& fine) {
    parallel_for(
        static_cast<std::size_t>(fine.size.nz - 2),
        [&](std::size_t plane_above_border) {
            const int k = static_cast<int>(plane_above_border) + 1;
            std::vector<float> line(coarse.size.row());
            for (int j = 1; j + 1 < fine.size.ny; ++j) {
                // The coarse rows below and above, in both directions; twice the same where the fine row lies on one.
                const std::array<std::size_t, 4> rows = {
                    coarse.size.node(0, j / 2, k / 2), coarse.size.node(0, (j + 1) / 2, k / 2),
                    coarse.size.node(0, j / 2, (k + 1) / 2), coarse.size.node(0, (j + 1) / 2, (k + 1) / 2)};
                const float* u = coarse.u.data();
                for (std::size_t i = 0; i < line.size(); ++i)
                    line[i] = 0.25f * (u[rows[0] + i] + u[rows[1] + i] + u[rows[2] + i] + u[rows[3] + i]);
                float* target = fine.u.data() + fine.size.node(0, j, k);
                for (std::size_t i = 0; i + 1 < line.size(); ++i) {
                    target[2 * i] += line[i];
                    target[2 * i + 1] += 0.5f * (line[i] + line[i + 1]);
                }
            }
        },
        4);
}

// The coarsest grid has a few thousand nodes; its own relaxation converges in about as many sweeps as it is wide,
// squared.
constexpr int n_coarsest_sweeps = 100;

void v_cycle(std::span<Level> levels) {
    Level& fine = levels[0];
    if (levels.size() == 1) return relax(fine, n_coarsest_sweeps);
    Level& coarse = levels[1];
    relax(fine, 2);
    std::fill(coarse.u.begin(), coarse.u.end(), 0.0f);
    restrict_to(
        coarse.size, fine.size, [&](std::size_t node) { return residual(fine, node); }, coarse.f);
    v_cycle(levels.subspan(1));
    add_prolongation(coarse, fine);
    relax(fine, 2);
}

// Solves coarse to fine, each grid starting from the solution of the next coarser one. levels[0] is the finest, and the
// only one whose f and sigma are given. Three cycles a grid leave the algebraic error far below the discretisation's.
void solve(std::vector<Level>& levels) {
    for (std::size_t l = 1; l < levels.size(); ++l) {
        const Level& fine = levels[l - 1];
        restrict_to(
            levels[l].size, fine.size, [&](std::size_t node) { return fine.f[node]; }, levels[l].f);
        restrict_to(
            levels[l].size, fine.size, [&](std::size_t node) { return fine.sigma[node]; }, levels[l].sigma);
    }
    for (std::size_t l = levels.size(); l-- > 0;) {
        if (l + 1 < levels.size()) add_prolongation(levels[l + 1], levels[l]);
        for (int cycle = 0; cycle < 3; ++cycle) v_cycle(std::span(levels).subspan(l));
    }
}

// ---- from points to the grid and back

// The two lattice positions around a coordinate and their linear weights.
struct Hat {
    int low = 0;
    std::array<float, 2> weights = {};
    explicit Hat(double coordinate) : low(static_cast<int>(std::floor(coordinate))) {
        const auto part = static_cast<float>(coordinate - low);
        weights = {1.0f - part, part};
    }
};

// Calls visit(i, j, k, weight) for the eight lattice positions around a point in grid coordinates.
template <class Visit>
void for_each_corner(const Vec3& point_in_grid, const Visit& visit) {
    const Hat x(point_in_grid.x()), y(point_in_grid.y()), z(point_in_grid.z());
    for (int c = 0; c < 8; ++c) {
        const auto bit = [c](int axis) { return static_cast<std::size_t>(c >> axis & 1); };
        visit(x.low + (c & 1), y.low + (c >> 1 & 1), z.low + (c >> 2),
              x.weights[bit(0)] * y.weights[bit(1)] * z.weights[bit(2)]);
    }
}

// A unit step along the normal, smoothed by the linear kernel: -1/2 from one spacing inside the plane on, +1/2 outside.
float smoothed_step(double distance_in_spacings) {
    const double t = std::clamp(distance_in_spacings, -1.0, 1.0);
    return static_cast<float>(t - 0.5 * t * std::abs(t));
}

// The distance to the plane, in spacings, at which smoothed_step() has this value; +-1 beyond its range.
float distance_of_step(float value) {
    return std::copysign(1.0f - std::sqrt(std::max(0.0f, 1.0f - 2.0f * std::abs(value))), value);
}

struct Placement {
    Dimensions size;
    Vec3 origin;
    double spacing;
    Vec3 to_grid(const Vec3& point_in_world) const { return (point_in_world - origin) / spacing; }
};

// Adds one point to the right-hand side and the screening of the finest grid.
void splat(const OrientedPoint& point, const Placement& grid, double screening, Level& level) {
    const Vec3 point_in_grid = grid.to_grid(point.position);
    const auto area = static_cast<float>(point.area / (grid.spacing * grid.spacing));
    // Kazhdan, Bolitho, Hoppe 2006, Eq. 3, on the staggered lattices: + h V at an edge's end, - h V at its start.
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 in_lattice = point_in_grid;
        in_lattice[axis] -= 0.5;
        const float flux = area * static_cast<float>(point.normal[axis]);
        const std::size_t stride = axis == 0 ? 1 : axis == 1 ? grid.size.row() : grid.size.plane();
        for_each_corner(in_lattice, [&](int i, int j, int k, float weight) {
            const std::size_t node = grid.size.node(i, j, k);
            level.f[node] -= weight * flux;
            level.f[node + stride] += weight * flux;
        });
    }
    const float strength = area * static_cast<float>(screening);
    for_each_corner(point_in_grid, [&](int i, int j, int k, float weight) {
        const std::size_t node = grid.size.node(i, j, k);
        const float tau = smoothed_step(point.normal.dot(Vec3(i, j, k) - point_in_grid));
        level.sigma[node] += weight * strength;
        level.f[node] += weight * strength * (tau - 0.5f);
    });
}

// Adds all points, in slabs of node planes: a point touches at most two planes beyond its slab, so every other slab may
// be filled at the same time, and within a slab the points keep their order: the sums do not depend on the threads.
void splat_all(std::span<const OrientedPoint> points, const Placement& grid, double screening, Level& level) {
    constexpr int slab_planes = 8;
    const auto slab_of = [&](const OrientedPoint& point) {
        return static_cast<std::size_t>(grid.to_grid(point.position).z()) / slab_planes;
    };
    std::vector<std::vector<std::uint32_t>> slabs(static_cast<std::size_t>(grid.size.nz) / slab_planes + 1);
    for (std::size_t p = 0; p < points.size(); ++p) slabs[slab_of(points[p])].push_back(static_cast<std::uint32_t>(p));
    for (const std::size_t parity : {0u, 1u})
        parallel_for((slabs.size() + 1 - parity) / 2,
                     [&](std::size_t pair) {
                         for (const std::uint32_t p : slabs[2 * pair + parity])
                             splat(points[p], grid, screening, level);
                     },
                     1);
}

// Adds what the votes want at the inner nodes: u from -1, inside, to 0.
void add_votes(const VoteFn& votes, const Placement& grid, const PoissonOptions& options, Level& level) {
    const auto vote = static_cast<float>(options.vote), most = static_cast<float>(options.most_votes);
    parallel_for(
        static_cast<std::size_t>(grid.size.nz - 2),
        [&](std::size_t plane_above_border) {
            const int k = static_cast<int>(plane_above_border) + 1;
            RowVotes row{std::vector<float>(grid.size.row()), std::vector<float>(grid.size.row())};
            for (int j = 1; j + 1 < grid.size.ny; ++j) {
                votes({grid.origin + grid.spacing * Vec3(0, j, k), grid.spacing}, row);
                const std::size_t start = grid.size.node(0, j, k);
                for (std::size_t i = 1; i + 1 < grid.size.row(); ++i) {
                    const float of_node = vote * most / std::max(most, row.weight[i]);
                    level.sigma[start + i] += of_node * row.weight[i];
                    level.f[start + i] += of_node * 0.5f * (row.sum[i] - row.weight[i]);
                }
            }
        },
        1);
}

// Mean of the field over the points' surface.
double mean_at_points(std::span<const OrientedPoint> points, const Placement& grid, const std::vector<float>& values) {
    std::vector<float> at_point(points.size());
    parallel_for(points.size(), [&](std::size_t p) {
        for_each_corner(grid.to_grid(points[p].position), [&](int i, int j, int k, float weight) {
            at_point[p] += weight * values[grid.size.node(i, j, k)];
        });
    });
    double sum = 0.0, area = 0.0;
    for (std::size_t p = 0; p < points.size(); ++p) {
        sum += points[p].area * static_cast<double>(at_point[p]);
        area += points[p].area;
    }
    return area > 0.0 ? sum / area : 0.0;
}

// Grids of the hierarchy: the coarsest is at least four cells wide, and small enough to be solved by relaxation.
int count_levels(double cells) { return std::clamp(static_cast<int>(std::log2(cells / 4.0)), 0, 4) + 1; }

// The finest grid: covers the points and the margin, its cells halve evenly through all levels, and it is centred.
Placement place_grid(std::span<const OrientedPoint> points, const PoissonOptions& options, int& n_levels) {
    Vec3 lower = points.front().position;
    Vec3 upper = lower;
    for (const OrientedPoint& point : points) {
        lower = lower.cwiseMin(point.position);
        upper = upper.cwiseMax(point.position);
    }
    const Vec3 cells = ((upper - lower) / options.spacing).array() + 2.0 * options.margin;
    n_levels = count_levels(cells.maxCoeff());
    const double unit = std::exp2(n_levels - 1);
    const Vec3 padded = (cells / unit).array().ceil().max(2.0) * unit;
    if (!((padded.array() + 1.0).prod() < 0x1p28))
        throw InputError("poisson: the points span " + std::to_string(cells.maxCoeff()) +
                         " grid cells of the given spacing, expected at most 2^28 nodes in all");
    Placement grid;
    grid.size = {static_cast<int>(padded.x()) + 1, static_cast<int>(padded.y()) + 1, static_cast<int>(padded.z()) + 1};
    grid.spacing = options.spacing;
    grid.origin = 0.5 * (lower + upper - options.spacing * padded);
    return grid;
}

}  // namespace

ScalarField poisson_field(std::span<const OrientedPoint> points, const PoissonOptions& options, const VoteFn& votes) {
    assert(options.spacing > 0.0 && options.margin >= 2);
    if (points.empty()) throw InputError("poisson: expected oriented points, got none");
    int n_levels = 0;
    const Placement grid = place_grid(points, options, n_levels);

    std::vector<Level> levels;
    Dimensions size = grid.size;
    for (int l = 0; l < n_levels; ++l) {
        levels.emplace_back(size);
        size = {size.nx / 2 + 1, size.ny / 2 + 1, size.nz / 2 + 1};
    }
    splat_all(points, grid, options.screening, levels.front());
    if (votes) add_votes(votes, grid, options, levels.front());
    solve(levels);

    ScalarField field{grid.size.nx, grid.size.ny, grid.size.nz, grid.origin, grid.spacing, std::move(levels.front().u)};
    // On the border u = 0; a mean of zero or more would mean that the points' normals point inwards.
    const auto at_surface = static_cast<float>(std::min(mean_at_points(points, grid, field.values), -0.01));
    parallel_for(
        field.values.size(), [&](std::size_t i) { field.values[i] = distance_of_step(field.values[i] - at_surface); },
        1 << 16);
    return field;
}

}  // namespace anyrate
