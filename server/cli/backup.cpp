#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "server/cli/commands.h"
#include "server/jobs/back_up.h"

namespace anyrate {
namespace {

struct BackupCommand {
    std::filesystem::path data = "anyrate-data";
    std::filesystem::path target;
};

int back_up_to(const BackupCommand& request) {
    const BackUp done = back_up(request.data, request.target);
    std::printf("%s: %zu models, %llu bytes\n", request.target.c_str(), done.n_models,
                static_cast<unsigned long long>(done.n_bytes));
    return 0;
}

}  // namespace

void add_backup(CLI::App& app, Command& command) {
    auto request = std::make_shared<BackupCommand>();
    CLI::App* sub = app.add_subcommand("backup", "copy a data directory as it stands, also while a server works on it");
    sub->add_option("--data", request->data, "data directory")->capture_default_str();
    sub->add_option("-o,--output", request->target, "the folder to make; `serve --data` takes it")->required();
    sub->callback([request, &command] { command = [request] { return back_up_to(*request); }; });
}

}  // namespace anyrate
