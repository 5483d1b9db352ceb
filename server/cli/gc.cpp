#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "core/error.h"
#include "server/cli/commands.h"
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

KeepRule rule_of(const GcCommand& request) {
    KeepRule rule;
    using Days = std::chrono::duration<double, std::ratio<86400>>;
    if (request.keep_days) rule.age = std::chrono::duration_cast<std::chrono::milliseconds>(Days(*request.keep_days));
    if (request.keep_mb) rule.bytes = *request.keep_mb << 20;
    return rule;
}

int collect(const GcCommand& request) {
    const auto catalog_file = request.data / "catalog.sqlite";
    if (!std::filesystem::exists(catalog_file))
        throw InputError(request.data.string() + ": expected a data directory, found no catalog.sqlite");
    SqliteCatalog catalog(catalog_file);
    const auto now = std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
    const Clearing clearing = find_clearing(catalog, request.data, rule_of(request), now);
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
    sub->add_option("--keep-days", request->keep_days, "remove final models that are older")
        ->check(CLI::NonNegativeNumber);
    sub->add_option("--keep-mb", request->keep_mb, "remove the oldest final models beyond so many MB of all models")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 40));
    sub->add_flag("--dry-run", request->dry_run, "only say what would go");
    sub->callback([request, &command] { command = [request] { return collect(*request); }; });
}

}  // namespace anyrate
