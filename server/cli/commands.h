#pragma once
#include <functional>
#include <string_view>

namespace CLI {
class App;
}

namespace anyrate {

/// What the command line does once it is parsed; returns the exit code: 0 done, 1 failed. Wrong usage (2) is CLI11's,
/// InputError becomes 3 and every other exception 1, in main.cpp alone.
using Command = std::function<int()>;

/// Each adds one subcommand with its options to `app` and, when that subcommand was chosen, sets `command`.
void add_reconstruct(CLI::App& app, Command& command);
void add_decode(CLI::App& app, Command& command);
void add_info(CLI::App& app, Command& command);
void add_verify(CLI::App& app, Command& command);
void add_compare(CLI::App& app, Command& command);
void add_simulate(CLI::App& app, Command& command);
void add_serve(CLI::App& app, Command& command);
void add_worker(CLI::App& app, Command& command);
void add_token(CLI::App& app, Command& command);
void add_push(CLI::App& app, Command& command);
void add_fetch(CLI::App& app, Command& command);
void add_encode_mesh(CLI::App& app, Command& command);
void add_gc(CLI::App& app, Command& command);
void add_backup(CLI::App& app, Command& command);

}  // namespace anyrate
