#pragma once
// The colours of a log and how they are predicted: proto/FORMAT.md, "Colours".
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"
#include "core/progressive/state_hash.h"
#include "core/types.h"
#include "proto/header.h"

namespace anyrate {

/// A colour's difference from its prediction in YCoCg-R, in quantiser steps.
struct ColourResidual {
    std::int32_t luma = 0, orange = 0, green = 0;  ///< Y, Co, Cg
    friend bool operator==(const ColourResidual&, const ColourResidual&) = default;
};

/// A prediction, corrected.
Rgb8 corrected(const Rgb8& prediction, const ColourResidual& residual, const ColourSteps& steps);

/// The ends of the edge on which a split put a vertex.
using EdgeEnds = std::array<std::int32_t, 2>;

/// One 8-bit colour a vertex, the same at both ends of the stream.
class ColourState {
public:
    /// Gives the residual of the i-th vertex of a frame, which was predicted as `prediction`.
    using ChooseResidual = std::function<ColourResidual(std::size_t i, const Rgb8& prediction)>;

    explicit ColourState(const ColourSteps& steps) : steps_(steps) {}

    /// The vertices of the base, each at the rounded mean of its lower-numbered neighbours, then corrected.
    void correct_base(const RefinableMesh& base, const ChooseResidual& choose);
    /// Appends new vertices at the mean of their edge ends, uncorrected.
    void predict(std::span<const EdgeEnds> ends);
    /// Corrects vertices first, first + 1, .. that predict() has appended, in order.
    void correct(std::size_t first, std::span<const EdgeEnds> ends, const ChooseResidual& choose);
    /// Sets so many vertices of a base without colours to their prediction.
    void predict_base(std::size_t n_vertices);

    std::span<const Rgb8> colours() const { return colours_; }
    /// Rolling hash over all corrected colours.
    std::uint32_t hash() const { return hash_.value(); }

private:
    Rgb8 midpoint(const EdgeEnds& ends) const;
    void write(std::size_t vertex, const Rgb8& prediction, const ColourResidual& residual);

    ColourSteps steps_;
    std::vector<Rgb8> colours_;
    RollingHash hash_;
};

}  // namespace anyrate
