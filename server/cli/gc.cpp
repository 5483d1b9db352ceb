#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/error.h"
#include "server/cli/commands.h"
#include "server/cli/job_options.h"
#include "server/jobs/housekeeping.h"
#include "server/store/sqlite_catalog.h"

namespace anyrate {
namespace {

struct GcCommand {
    std::filesystem::path data = "anyrate-data";
    std::optional<double> keep_days;
    std::optional<std::uint64_t> keep_mb;
    bool dry_run = false;
};

int collect(const GcCommand& request) {
    const auto catalog_file = request.data / "catalog.sqlite";
    if (!std::filesystem::exists(catalog_file))
        throw InputError(request.data.string() + ": expected a data directory, found no catalog.sqlite");
    SqliteCatalog catalog(catalog_file);
    const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
    const Clearing clearing = find_clearing(catalog, request.data, keep_rule(request.keep_days, request.keep_mb), now);
    for (const std::string& id : clearing.models) std::printf("model %s\n", id.c_str());
    for (const auto& leftover : clearing.leftovers) std::printf("leftover %s\n", leftover.c_str());
    if (!request.dry_run) clear(catalog, clearing, request.data, [](const std::string&) {});
    std::printf("%s %zu models and %zu leftovers, %llu bytes\n", request.dry_run ? "would remove" : "removed",
                clearing.models.size(), clearing.leftovers.size(), static_cast<unsigned long long>(clearing.n_bytes));
    return 0;
}

}  // namespace

void add_gc(CLI::App& app, Command& command) {
    auto request = std::make_shared<GcCommand>();
    CLI::App* sub = app.add_subcommand("gc", "remove finished models by age or size, and what crashes left behind");
    sub->add_option("--data", request->data, "data directory; a server may be working on it")->capture_default_str();
    add_keep_options(*sub, request->keep_days, request->keep_mb);
    sub->add_flag("--dry-run", request->dry_run, "only say what would go");
    sub->callback([request, &command] { command = [request] { return collect(*request); }; });
}

}  // namespace anyrate
