#include "server/store/sha256.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <memory>
#include <string_view>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

/// SHA-256 piece by piece.
class Hash {
public:
    Hash() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
        if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
            throw IoError("the library for digests does not work");
    }
    void add(std::span<const std::byte> bytes) { EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()); }
    Sha256 end() {
        Sha256 digest{};
        EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr);
        return digest;
    }

private:
    std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

Sha256 sha256(std::span<const std::byte> bytes) {
    Hash hash;
    hash.add(bytes);
    return hash.end();
}

Sha256 sha256_of_file(const std::filesystem::path& file) {
    constexpr std::size_t piece = 1 << 18;
    const FileHandle handle = open_if_exists(file);
    if (!handle) throw IoError("cannot open " + file.string());
    Hash hash;
    for (std::uint64_t at = 0;;) {
        const auto bytes = read_at(handle, at, piece);
        hash.add(bytes);
        at += bytes.size();
        if (bytes.size() < piece) return hash.end();
    }
}

std::string to_hex(const Sha256& digest) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : digest) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

std::string to_base64(const Sha256& digest) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    std::uint32_t bits = 0;
    int n_bits = 0;
    for (const unsigned char byte : digest) {
        bits = bits << 8 | byte;
        for (n_bits += 8; n_bits >= 6; n_bits -= 6) text += alphabet[bits >> (n_bits - 6) & 63];
    }
    return text + alphabet[bits << 2 & 63] + "=";
}

bool equal_in_constant_time(const Sha256& a, const Sha256& b) {
    return CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace anyrate
