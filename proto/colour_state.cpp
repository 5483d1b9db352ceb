#include "proto/colour_state.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace anyrate {

namespace {

constexpr Rgb8 grey = {128, 128, 128};

/// Malvar and Sullivan, "YCoCg-R: A Color Space with RGB Reversibility and Low Dynamic Range", 2003.
struct YCoCg {
    int y = 0, co = 0, cg = 0;
};

YCoCg to_ycocg(const Rgb8& colour) {
    const int co = colour.r - colour.b;
    const int t = colour.b + (co >> 1);
    const int cg = colour.g - t;
    return {t + (cg >> 1), co, cg};
}

Rgb8 to_rgb(const YCoCg& c) {
    const int t = c.y - (c.cg >> 1);
    const int green = c.cg + t;
    const int blue = t - (c.co >> 1);
    const auto channel = [](int x) { return static_cast<std::uint8_t>(std::clamp(x, 0, 255)); };
    return {channel(blue + c.co), channel(green), channel(blue)};
}

std::int32_t steps_between(int from, int to, int step) {
    return static_cast<std::int32_t>(std::lround(static_cast<double>(to - from) / step));
}

/// About what Draco's tables spend on a component of a residual, less what they spend on 0.
double extra_bits(int steps) { return steps == 0 ? 0 : 0.8 + 1.7 * std::log2(1.0 + std::abs(steps)); }

/// Of the steps around a way of x steps, three: towards 0, away from it, and one nearer to 0 still.
std::array<int, 3> steps_near(double x) {
    const int inner = static_cast<int>(std::trunc(x)), sign = x < 0 ? -1 : 1;
    return {inner, inner + sign, inner == 0 ? 0 : inner - sign};
}

double mean_squared_error(const Rgb8& a, const Rgb8& b) {
    const double r = a.r - b.r, g = a.g - b.g, blue = a.b - b.b;
    return (r * r + g * g + blue * blue) / 3;
}

/// For each vertex its neighbours with lower numbers, one list behind the other: those of v end where those of v+1
/// begin.
struct LowerNeighbours {
    std::vector<std::size_t> begin;
    std::vector<std::int32_t> neighbours;

    explicit LowerNeighbours(const RefinableMesh& mesh) : begin(static_cast<std::size_t>(mesh.n_vertices()) + 1, 0) {
        // Every pair of neighbours is one half-edge each way, so each list holds a neighbour once.
        const auto each_descending = [&](auto&& body) {
            for (const Triangle& t : mesh.triangles()) {
                for (std::size_t i = 0; i < 3; ++i) {
                    if (t[(i + 1) % 3] < t[i]) body(static_cast<std::size_t>(t[i]), t[(i + 1) % 3]);
                }
            }
        };
        each_descending([&](std::size_t from, std::int32_t) { ++begin[from + 1]; });
        for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
        neighbours.resize(begin.back());
        std::vector<std::size_t> end(begin.begin(), begin.end() - 1);
        each_descending([&](std::size_t from, std::int32_t to) { neighbours[end[from]++] = to; });
    }

    std::span<const std::int32_t> of(std::size_t v) const {
        return std::span(neighbours).subspan(begin[v], begin[v + 1] - begin[v]);
    }
};

/// Mean colour, halves up; grey of none.
Rgb8 mean_colour(std::span<const std::int32_t> vertices, std::span<const Rgb8> colours) {
    if (vertices.empty()) return grey;
    std::int64_t r = 0, g = 0, b = 0;
    for (const std::int32_t v : vertices) {
        const Rgb8& colour = colours[static_cast<std::size_t>(v)];
        r += colour.r, g += colour.g, b += colour.b;
    }
    const auto k = static_cast<std::int64_t>(vertices.size());
    const auto channel = [k](std::int64_t sum) { return static_cast<std::uint8_t>((sum + k / 2) / k); };
    return {channel(r), channel(g), channel(b)};
}

}  // namespace

void ColourState::predict_base(std::size_t n_vertices) { colours_.assign(n_vertices, grey); }

void ColourState::correct_base(const RefinableMesh& base, const ChooseResidual& choose) {
    const LowerNeighbours lower(base);
    colours_.resize(static_cast<std::size_t>(base.n_vertices()));
    for (std::size_t v = 0; v < colours_.size(); ++v) {
        const Rgb8 prediction = mean_colour(lower.of(v), colours_);
        write(v, prediction, choose(v, prediction));
    }
}

void ColourState::predict(std::span<const EdgeEnds> ends) {
    for (const EdgeEnds& edge : ends) colours_.push_back(midpoint(edge));
}

void ColourState::correct(std::size_t first, std::span<const EdgeEnds> ends, const ChooseResidual& choose) {
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const Rgb8 prediction = midpoint(ends[i]);
        write(first + i, prediction, choose(i, prediction));
    }
}

ColourResidual ColourState::quantise(const Rgb8& prediction, const Rgb8& colour, double bit_price) const {
    const YCoCg from = to_ycocg(prediction), to = to_ycocg(colour);
    ColourResidual best = {steps_between(from.y, to.y, steps_.luma), steps_between(from.co, to.co, steps_.chroma),
                           steps_between(from.cg, to.cg, steps_.chroma)};
    if (bit_price == 0) return best;
    const auto cost_of = [&](const ColourResidual& residual) {
        const double n_bits = extra_bits(residual.luma) + extra_bits(residual.orange) + extra_bits(residual.green);
        return mean_squared_error(corrected(prediction, residual), colour) + bit_price * n_bits;
    };
    double least = cost_of(best);
    const auto way = [](int a, int b, int step) { return static_cast<double>(b - a) / step; };
    for (const int luma : steps_near(way(from.y, to.y, steps_.luma)))
        for (const int orange : steps_near(way(from.co, to.co, steps_.chroma)))
            for (const int green : steps_near(way(from.cg, to.cg, steps_.chroma))) {
                const ColourResidual residual{luma, orange, green};
                const double cost = cost_of(residual);
                if (cost >= least) continue;
                least = cost;
                best = residual;
            }
    return best;
}

Rgb8 ColourState::midpoint(const EdgeEnds& ends) const {
    const Rgb8& a = colours_[static_cast<std::size_t>(ends[0])];
    const Rgb8& b = colours_[static_cast<std::size_t>(ends[1])];
    const auto mean = [](int u, int v) { return static_cast<std::uint8_t>((u + v + 1) >> 1); };
    return {mean(a.r, b.r), mean(a.g, b.g), mean(a.b, b.b)};
}

Rgb8 ColourState::corrected(const Rgb8& prediction, const ColourResidual& residual) const {
    YCoCg c = to_ycocg(prediction);
    c.y += residual.luma * steps_.luma;
    c.co += residual.orange * steps_.chroma;
    c.cg += residual.green * steps_.chroma;
    return to_rgb(c);
}

void ColourState::write(std::size_t vertex, const Rgb8& prediction, const ColourResidual& residual) {
    const Rgb8 colour = corrected(prediction, residual);
    colours_[vertex] = colour;
    hash_.mix(static_cast<std::uint32_t>(vertex));
    hash_.mix(static_cast<std::uint32_t>(colour.r | colour.g << 8 | colour.b << 16));
}

}  // namespace anyrate
