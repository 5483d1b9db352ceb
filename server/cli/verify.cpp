#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "proto/log_reader.h"
#include "server/cli/commands.h"
#include "server/cli/read_log.h"

namespace anyrate {
namespace {

int verify(const std::filesystem::path& model) {
    const auto log = read_log(model);
    const std::size_t n_frames = naming_log(model, [&] { return verify_log(log); });
    std::printf("%s: %zu frames, every checksum and state hash holds\n", log_name(model), n_frames);
    return 0;
}

}  // namespace

void add_verify(CLI::App& app, Command& command) {
    auto model = std::make_shared<std::filesystem::path>();
    CLI::App* sub = app.add_subcommand("verify", "check every checksum and state hash of a model");
    sub->add_option("MODEL", *model, "the log of a model (.arl); - is the standard input")->required();
    sub->callback([model, &command] { command = [model] { return verify(*model); }; });
}

}  // namespace anyrate
