#pragma once
#include <span>

#include "core/types.h"
#include "proto/colour_state.h"
#include "proto/symbol_costs.h"

namespace anyrate {

/// How colours are rounded. On four reconstructions of 10,000 vertices the default takes 5.9 to 8.5 bits a vertex at a
/// mean error of 2.0 of 255 (tests/bench/colour_rate). At equal error, squares of errors instead of errors would take 1
/// % more, steps of 6 and 10 would, and so would bits that are not counted by each frame's own tables.
struct ColourCoding {
    ColourSteps steps{.luma = 5, .chroma = 11};
    double bit_price = 0.28;  ///< mean error of the three channels that a bit is worth; 0: to the nearest
};

/// Chooses the residuals of a frame's colours.
class ColourRounding {
public:
    explicit ColourRounding(const ColourCoding& coding) : coding_(coding) {}

    /// The residual that takes a prediction nearest to a colour, or, if bits have a price, that of least error plus
    /// price.
    ColourResidual residual(const Rgb8& prediction, const Rgb8& colour) const;
    /// From now on bits are counted as in a frame of these residuals.
    void learn(std::span<const ColourResidual> residuals);

private:
    ColourCoding coding_;
    SymbolCosts luma_, chroma_;
};

}  // namespace anyrate
