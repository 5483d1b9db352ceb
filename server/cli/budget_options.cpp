#include "server/cli/budget_options.h"

#include <CLI/CLI.hpp>
#include <limits>

#include "server/cli/number_check.h"

namespace anyrate {

void BudgetOptions::add_to(CLI::App& subcommand) {
    auto* group = subcommand.add_option_group("budget", "how much of the model; everything by default");
    group->add_option("--vertices", n_vertices, "at most N vertices, at most 2 fewer")->check(above_zero());
    group->add_option("--bytes", n_bytes, "as many whole frames as fit into B bytes of the log")->check(above_zero());
    group->add_option("--distortion", distortion, "as few bytes as reach distortion D (Eq. 10, squared 8-bit units)")
        ->check(not_below_zero());
    group->require_option(0, 1);
}

Budget BudgetOptions::budget() const {
    if (n_vertices) return VertexBudget{*n_vertices};
    if (n_bytes) return ByteBudget{*n_bytes};
    if (distortion) return DistortionBudget{*distortion};
    return VertexBudget{std::numeric_limits<std::uint32_t>::max()};
}

}  // namespace anyrate
