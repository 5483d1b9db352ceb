#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "proto/log_reader.h"
#include "tests/golden/sample_models.h"

namespace anyrate::testing {

/// A small log with colours: 42 vertices, 6 batches of 8 splits.
inline const samples::SampleLog& small_log() {
    static const samples::SampleLog log = [] {
        const Grid grid = samples::unit_grid(12);
        return samples::make_log(grid, samples::icosphere(grid, 1), {.n_batches = 6, .splits_per_batch = 8});
    }();
    return log;
}

inline bool same_mesh(const Mesh& a, const Mesh& b) {
    return a.vertices == b.vertices && a.triangles == b.triangles && a.colours == b.colours;
}

}  // namespace anyrate::testing
