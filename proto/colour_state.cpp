#include "proto/colour_state.h"

#include "proto/ycocg.h"

namespace anyrate {

namespace {

constexpr Rgb8 grey = {128, 128, 128};

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

Rgb8 corrected(const Rgb8& prediction, const ColourResidual& residual, const ColourSteps& steps) {
    YCoCg c = to_ycocg(prediction);
    c.y += residual.luma * steps.luma;
    c.co += residual.orange * steps.chroma;
    c.cg += residual.green * steps.chroma;
    return to_rgb(c);
}

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

Rgb8 ColourState::midpoint(const EdgeEnds& ends) const {
    const Rgb8& a = colours_[static_cast<std::size_t>(ends[0])];
    const Rgb8& b = colours_[static_cast<std::size_t>(ends[1])];
    const auto mean = [](int u, int v) { return static_cast<std::uint8_t>((u + v + 1) >> 1); };
    return {mean(a.r, b.r), mean(a.g, b.g), mean(a.b, b.b)};
}

void ColourState::write(std::size_t vertex, const Rgb8& prediction, const ColourResidual& residual) {
    const Rgb8 colour = corrected(prediction, residual, steps_);
    colours_[vertex] = colour;
    hash_.mix(static_cast<std::uint32_t>(vertex));
    hash_.mix(static_cast<std::uint32_t>(colour.r | colour.g << 8 | colour.b << 16));
}

}  // namespace anyrate
