#include "server/http/tokens.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

using nlohmann::json;

std::optional<Sha256> from_hex(const std::string& text) {
    Sha256 digest{};
    if (text.size() != 2 * digest.size()) return std::nullopt;
    for (std::size_t i = 0; i < text.size(); ++i) {
        constexpr std::string_view digits = "0123456789abcdef";
        const auto value = digits.find(text[i]);
        if (value == std::string_view::npos) return std::nullopt;
        digest[i / 2] = static_cast<unsigned char>(digest[i / 2] << 4 | value);
    }
    return digest;
}

StoredToken token_from(const json& entry) {
    const std::string scope = entry.at("scope");
    if (scope != "read" && scope != "write") throw InputError("scope \"" + scope + "\": expected read or write");
    const auto hash = from_hex(entry.at("sha256"));
    if (!hash) throw InputError("sha256: expected 64 digits 0-9 and a-f");
    return {entry.at("name"), scope == "write" ? Scope::write : Scope::read, *hash};
}

}  // namespace

std::string new_token() {
    constexpr std::string_view digits = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ-_";
    std::array<unsigned char, 43> random{};  // of each, 6 bits
    if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
        throw IoError("the kernel gave no randomness");
    std::string token;
    for (const unsigned char byte : random) token += digits[byte & 63];
    return token;
}

std::vector<StoredToken> read_tokens(const std::filesystem::path& file) {
    const FileHandle handle = open_if_exists(file);
    if (!handle) return {};
    const auto bytes = read_at(handle, 0, static_cast<std::size_t>(file_size(handle)));
    try {
        std::vector<StoredToken> tokens;
        const json document = json::parse(as_text(bytes));
        for (const json& entry : document.at("tokens")) tokens.push_back(token_from(entry));
        return tokens;
    } catch (const json::exception& error) {
        throw InputError(file.string() + ": no file of tokens: " + error.what());
    } catch (const InputError& error) {
        throw InputError(file.string() + ": " + error.what());
    }
}

void write_tokens(const std::filesystem::path& file, const std::vector<StoredToken>& tokens) {
    json list = json::array();
    for (const StoredToken& token : tokens)
        list.push_back({{"name", token.name},
                        {"scope", token.scope == Scope::write ? "write" : "read"},
                        {"sha256", to_hex(token.hash)}});
    const std::string text = json{{"tokens", list}}.dump(1) + "\n";
    replace_file(file, as_bytes(text));
    if (::chmod(file.c_str(), 0600) != 0) throw IoError("cannot set the permissions of " + file.string());
}

Tokens::Tokens(std::filesystem::path file, const std::string& writer) : file_(std::move(file)) {
    if (!writer.empty()) own_.push_back({"the server's own", Scope::write, sha256(as_bytes(writer))});
    known_ = own_;
    const std::lock_guard lock(mutex_);
    read_again();
}

bool Tokens::has_writer() {
    const std::lock_guard lock(mutex_);
    read_for_request();
    for (const StoredToken& token : known_)
        if (token.scope == Scope::write) return true;
    return false;
}

bool Tokens::permit(std::string_view token, Scope scope) {
    const Sha256 hash = sha256(as_bytes(token));
    const std::lock_guard lock(mutex_);
    read_for_request();
    bool permitted = false;
    for (const StoredToken& known : known_) {
        const bool is_it = equal_in_constant_time(hash, known.hash);
        permitted |= is_it && (known.scope == scope || known.scope == Scope::write);
    }
    return permitted;
}

void Tokens::read_for_request() {
    try {
        read_again();
    } catch (const InputError& error) {  // the operator's fault, not that of who asks
        throw IoError(error.what());
    }
}

/// At most once a second, for every writing request asks.
void Tokens::read_again() {
    const auto now = std::chrono::steady_clock::now();
    if (file_.empty() || now - looked_ < std::chrono::seconds(1)) return;
    looked_ = now;
    std::error_code error;  // no file: no tokens
    const auto changed = std::filesystem::last_write_time(file_, error);
    if (!error && changed == changed_) return;
    known_ = own_;
    changed_ = {};
    if (error) return;
    const auto read = read_tokens(file_);
    known_.insert(known_.end(), read.begin(), read.end());
    changed_ = changed;
}

}  // namespace anyrate
