#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "core/error.h"
#include "server/cli/commands.h"
#include "server/cli/one_of.h"
#include "server/http/tokens.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

struct TokenCommand {
    std::filesystem::path data = "anyrate-data";
    std::string name;
    Scope scope = Scope::write;
    bool revoke = false;
};

int token(const TokenCommand& request) {
    const std::filesystem::path file = request.data / "tokens.json";
    std::vector<StoredToken> tokens = read_tokens(file);
    const auto known = std::find_if(tokens.begin(), tokens.end(),
                                    [&](const StoredToken& candidate) { return candidate.name == request.name; });
    if (request.revoke) {
        if (known == tokens.end()) throw InputError("there is no token called \"" + request.name + "\"");
        tokens.erase(known);
        write_tokens(file, tokens);
        return 0;
    }
    if (known != tokens.end())
        throw InputError("there is a token called \"" + request.name + "\" already; --revoke it first");
    std::filesystem::create_directories(request.data);
    const std::string made = new_token();
    tokens.push_back({request.name, request.scope, sha256(as_bytes(made))});
    write_tokens(file, tokens);
    std::printf("%s\n", made.c_str());
    return 0;
}

}  // namespace

void add_token(CLI::App& app, Command& command) {
    auto request = std::make_shared<TokenCommand>();
    CLI::App* sub = app.add_subcommand("token", "make a token for a server's clients, or revoke one");
    sub->add_option("NAME", request->name, "whose it is, for people")->required();
    sub->add_option("--data", request->data, "data directory of the server, which takes the token within a second")
        ->capture_default_str();
    const std::map<std::string, Scope> scopes = {{"read", Scope::read}, {"write", Scope::write}};
    sub->add_option("--scope", request->scope, "what it allows: read, or write (which includes reading)")
        ->transform(one_of(numbers_of(scopes)))
        ->default_str("write");
    sub->add_flag("--revoke", request->revoke, "take the token of that name back");
    sub->footer("The token is printed once; the data directory holds only its SHA-256.");
    sub->callback([request, &command] { command = [request] { return token(*request); }; });
}

}  // namespace anyrate
