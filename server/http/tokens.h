#pragma once
#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/sha256.h"

namespace anyrate {

enum class Scope { read, write };  ///< who may write may read

/// A token as it is kept: nobody can tell the token from it.
struct StoredToken {
    std::string name;  ///< for people: whose it is
    Scope scope = Scope::read;
    Sha256 hash{};
};

/// A fresh token: 256 random bits of the kernel, so that its plain SHA-256 may be stored. @throws IoError
std::string new_token();

/// The tokens of a file, `{"tokens": [{"name", "scope": "read"|"write", "sha256": <hex>}]}`; none if there is no file.
/// @throws InputError it is no such file, IoError
std::vector<StoredToken> read_tokens(const std::filesystem::path& file);
/// Replaces the file, readable by its owner only. @throws IoError
void write_tokens(const std::filesystem::path& file, const std::vector<StoredToken>& tokens);

/// The tokens that a server takes: those of its file, which is read again when it has changed, and one of its own
/// options. Safe to call from several threads.
class Tokens {
public:
    /// @param file    may come to be later; empty for none
    /// @param writer  a token of write scope beside the file's; empty for none
    /// @throws InputError, IoError
    Tokens(std::filesystem::path file, const std::string& writer);

    bool has_writer();
    /// Whether a token is known and of that scope. All tokens are compared, each in constant time.
    bool permit(std::string_view token, Scope scope);

private:
    void read_again();
    void read_for_request();

    std::filesystem::path file_;
    std::vector<StoredToken> own_;
    std::mutex mutex_;
    std::vector<StoredToken> known_;
    std::filesystem::file_time_type changed_{};
    std::chrono::steady_clock::time_point looked_{};
};

}  // namespace anyrate
