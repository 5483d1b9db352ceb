#include "server/client/push_capture.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "core/error.h"
#include "server/cli/access_options.h"
#include "server/cli/commands.h"
#include "server/cli/number_check.h"

namespace anyrate {
namespace {

struct PushCommand {
    std::filesystem::path capture;
    std::string server;
    PushOptions options;
    AccessOptions access;
    bool wait = false;
};

/// Shows each new state: one line that moves on a terminal, a plain line at each new stage elsewhere.
class StateLine {
public:
    ~StateLine() {
        if (is_open_) std::fputc('\n', stderr);
    }
    void show(const RemoteState& state) {
        const std::string where = state.state + (state.stage.empty() ? "" : ", " + state.stage);
        if (!on_terminal_ && where == shown_) return;
        shown_ = where;
        std::fprintf(stderr,
                     on_terminal_ ? "\r\033[K%s %3.0f %%, %llu vertices, %llu bytes"
                                  : "%s %3.0f %%, %llu vertices, %llu bytes\n",
                     where.c_str(), 100 * state.fraction, static_cast<unsigned long long>(state.n_vertices),
                     static_cast<unsigned long long>(state.n_bytes));
        is_open_ = on_terminal_;
    }

private:
    bool on_terminal_ = ::isatty(STDERR_FILENO) == 1;
    bool is_open_ = false;
    std::string shown_;
};

int push(const PushCommand& request) {
    const Url server = parse_url(request.server);
    PushOptions options = request.options;
    options.access = request.access.access();
    const std::string id = push_capture(server, request.capture, options);
    std::printf("%s\n", id.c_str());
    std::fflush(stdout);
    if (!request.wait) return 0;
    const RemoteState end = [&] {
        StateLine line;
        return wait_for_model(server, id, options.access, [&](const RemoteState& state) { line.show(state); });
    }();
    if (end.state == "done") return 0;
    std::fprintf(stderr, "anyrate: the model %s: %s\n", end.state.c_str(), end.error.c_str());
    return 1;
}

}  // namespace

void add_push(CLI::App& app, Command& command) {
    auto request = std::make_shared<PushCommand>();
    CLI::App* sub = app.add_subcommand("push", "upload a capture to a server and print the model's id");
    sub->add_option("CAPTURE", request->capture, "folder or zip of images, masks and cameras")->required();
    sub->add_option("--server", request->server,
                    "address of the server, as in http://127.0.0.1:8080 or https://example.org")
        ->required();
    sub->add_option("--vertices", request->options.n_vertices, "of the finest mesh")->check(above_zero());
    request->access.add_to(*sub);
    sub->add_flag("--wait", request->wait, "wait for the end of the reconstruction; exit code 1 if it failed");
    sub->callback([request, &command] { command = [request] { return push(*request); }; });
}

}  // namespace anyrate
