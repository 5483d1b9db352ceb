#include "proto/colour_rounding.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "proto/ycocg.h"

namespace anyrate {

namespace {

std::int32_t nearest(double steps) { return static_cast<std::int32_t>(std::lround(steps)); }

/// Of the steps around a way of x steps, three: towards 0, away from it, and one nearer to 0 still.
std::array<std::int32_t, 3> steps_near(double x) {
    const int inner = static_cast<int>(std::trunc(x)), sign = x < 0 ? -1 : 1;
    return {inner, inner + sign, inner == 0 ? 0 : inner - sign};
}

double mean_error(const Rgb8& a, const Rgb8& b) {
    return (std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b)) / 3.0;
}

}  // namespace

ColourResidual ColourRounding::residual(const Rgb8& prediction, const Rgb8& colour) const {
    const ColourSteps& steps = coding_.steps;
    const YCoCg from = to_ycocg(prediction), to = to_ycocg(colour);
    const auto way = [](int a, int b, int step) { return static_cast<double>(b - a) / step; };
    const double luma = way(from.y, to.y, steps.luma), orange = way(from.co, to.co, steps.chroma),
                 green = way(from.cg, to.cg, steps.chroma);
    ColourResidual best{nearest(luma), nearest(orange), nearest(green)};
    if (coding_.bit_price == 0) return best;
    const auto cost_of = [&](const ColourResidual& r) {
        const double n_bits = luma_.bits(r.luma) + chroma_.bits(r.orange) + chroma_.bits(r.green);
        return mean_error(corrected(prediction, r, steps), colour) + coding_.bit_price * n_bits;
    };
    double least = cost_of(best);
    for (const std::int32_t y : steps_near(luma))
        for (const std::int32_t co : steps_near(orange))
            for (const std::int32_t cg : steps_near(green)) {
                const ColourResidual residual{y, co, cg};
                const double cost = cost_of(residual);
                if (cost >= least) continue;
                least = cost;
                best = residual;
            }
    return best;
}

void ColourRounding::learn(std::span<const ColourResidual> residuals) {
    std::vector<std::int32_t> luma, chroma;
    for (const ColourResidual& residual : residuals) {
        luma.push_back(residual.luma);
        chroma.insert(chroma.end(), {residual.orange, residual.green});
    }
    luma_ = SymbolCosts(luma);
    chroma_ = SymbolCosts(chroma);
}

}  // namespace anyrate
