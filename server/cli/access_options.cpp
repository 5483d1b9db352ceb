#include "server/cli/access_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <fstream>

#include "core/error.h"

namespace anyrate {
namespace {

constexpr std::size_t longest_token = 4096;

/// The first line of a file, without the white space around it.
std::string read_token(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    if (!in || !std::getline(in, line))
        throw InputError(file.string() + ": expected a file whose first line is a token");
    const auto is_space = [](unsigned char c) { return std::isspace(c) != 0; };
    line.erase(std::find_if_not(line.rbegin(), line.rend(), is_space).base(), line.end());
    line.erase(line.begin(), std::find_if_not(line.begin(), line.end(), is_space));
    const bool is_printable = std::all_of(line.begin(), line.end(), [](char c) { return c > ' ' && c < '\x7f'; });
    if (line.empty() || line.size() > longest_token || !is_printable)
        throw InputError(file.string() + ": expected a token in the first line, of printable characters and no spaces");
    return line;
}

}  // namespace

void AccessOptions::add_to(CLI::App& app) {
    app.add_option("--token", token_,
                   "the server's token; other users of this machine can read it here, so rather set ANYRATE_TOKEN")
        ->envname("ANYRATE_TOKEN");
    app.add_option("--token-file", token_file_, "a file whose first line is the token; goes before ANYRATE_TOKEN");
    app.add_option("--ca", ca_, "certificates (PEM) that an https server's must come from, instead of the system's")
        ->envname("ANYRATE_CA");
}

ServerAccess AccessOptions::access() const {
    return {.token = token_file_ ? read_token(*token_file_) : token_, .ca = ca_};
}

}  // namespace anyrate
