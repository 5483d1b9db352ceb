#pragma once
#include <span>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// Distortion after a piece of the log, mean over the whole surface and the largest mean of one triangle: Eq. 10 in
/// squared 8-bit colour units, or, of a log made from a surface, squared distance to it in squared grid units.
struct DistortionPoint {
    double mean = 0, max = 0;
};

/// Receives a model while it is made. core writes through this seam, so that it knows no wire format; proto implements
/// it.
class ModelSink {
public:
    virtual ~ModelSink() = default;
    /// Who takes a picture to look at until start(): a base and its colours, of another model than the one to come,
    /// which replaces it. Distortions may be NaN: unknown. nullptr if nobody would look.
    virtual ModelSink* preview() { return nullptr; }
    /// Takes the coarse mesh and gives it back as every decoder will number it (Draco renumbers).
    virtual BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) = 0;
    /// Colours and distortion of the base, one colour per vertex of the mesh that start() returned.
    virtual void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) = 0;
    /// One batch: records in order, `state` after the last of them, colours of the three new vertices of each record.
    virtual void batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                       std::span<const Rgb8> new_colours, const DistortionPoint& distortion) = 0;
    /// No more batches.
    virtual void finish() = 0;
};

}  // namespace anyrate
