// The one binary. Every way to fail becomes an exit code here: 0 done, 1 failed, 2 wrong usage, 3 bad input.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "core/error.h"
#include "server/cli/commands.h"

namespace {

int run(const anyrate::Command& command) {
    try {
        return command();
    } catch (const anyrate::InputError& error) {
        std::fprintf(stderr, "anyrate: %s\n", error.what());
        return 3;
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "anyrate: out of memory\n");
        return 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "anyrate: %s\n", error.what());
        return 1;
    }
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Rebuilds a 3D object from calibrated photographs and streams it as a mesh at any rate.", "anyrate");
    app.require_subcommand(1);
    app.set_version_flag("--version", ANYRATE_VERSION);

    anyrate::Command command;
    anyrate::add_reconstruct(app, command);
    anyrate::add_decode(app, command);
    anyrate::add_info(app, command);
    anyrate::add_verify(app, command);
    anyrate::add_compare(app, command);
    anyrate::add_simulate(app, command);
    anyrate::add_serve(app, command);
    anyrate::add_worker(app, command);
    anyrate::add_token(app, command);
    anyrate::add_push(app, command);
    anyrate::add_fetch(app, command);
    anyrate::add_encode_mesh(app, command);
    anyrate::add_gc(app, command);
    anyrate::add_backup(app, command);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    return run(command);
}
