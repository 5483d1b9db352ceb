#pragma once
#include <cstdint>
#include <optional>

#include "proto/index.h"

namespace CLI {
class App;
}

namespace anyrate {

/// The three ways to say how much of a model is wanted, at most one of them: --vertices, --bytes, --distortion.
struct BudgetOptions {
    std::optional<std::uint32_t> n_vertices;
    std::optional<std::uint64_t> n_bytes;
    std::optional<double> distortion;

    /// Adds the three options to a subcommand. `*this` must live as long as the parsing.
    void add_to(CLI::App& subcommand);
    /// The budget that was given; all vertices if none was.
    Budget budget() const;
};

}  // namespace anyrate
