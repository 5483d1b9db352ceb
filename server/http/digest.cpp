#include "server/http/digest.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t base64_size = 44;  // of 32 bytes, with one "=" at the end

std::optional<Sha256> from_base64(std::string_view text) {
    if (text.size() != base64_size || text.back() != '=') return std::nullopt;
    Sha256 digest{};
    std::uint32_t bits = 0;
    int n_bits = 0;
    std::size_t n_bytes = 0;
    for (const char c : text.substr(0, base64_size - 1)) {
        const auto value = alphabet.find(c);
        if (value == std::string_view::npos) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        n_bits += 6;
        if (n_bits < 8) continue;
        n_bits -= 8;
        digest[n_bytes++] = static_cast<unsigned char>(bits >> n_bits & 0xFF);
    }
    // The last digit has two bits that no byte takes; one spelling of a digest is enough.
    return (bits & 3) == 0 ? std::optional(digest) : std::nullopt;
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

bool is_sha256(std::string_view name) {
    constexpr std::string_view expected = "sha-256";
    return std::equal(name.begin(), name.end(), expected.begin(), expected.end(),
                      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

/// The value of sha-256 in a list of `name=value`.
std::optional<std::string_view> find_sha256(std::string_view field) {
    while (!field.empty()) {
        const auto comma = field.find(',');
        const std::string_view member = trim(field.substr(0, comma));
        const auto equals = member.find('=');
        if (equals != std::string_view::npos && is_sha256(trim(member.substr(0, equals))))
            return trim(member.substr(equals + 1));
        field = comma == std::string_view::npos ? std::string_view() : field.substr(comma + 1);
    }
    return std::nullopt;
}

Sha256 expect_base64(const char* name, std::string_view text) {
    if (const auto digest = from_base64(text)) return *digest;
    throw HttpProblem(400, std::string(name) + ": expected the base64 of a SHA-256, 44 letters, got \"" +
                               std::string(text.substr(0, 60)) + "\"");
}

}  // namespace

std::optional<Sha256> digest_of_request(const Request& request) {
    if (const auto value = find_sha256(request.headers.find("Content-Digest").value_or(""))) {
        if (value->size() < 2 || value->front() != ':' || value->back() != ':')
            throw HttpProblem(400, "Content-Digest: expected sha-256=:<base64>:, as RFC 9530 has it");
        return expect_base64("Content-Digest", value->substr(1, value->size() - 2));
    }
    if (const auto value = find_sha256(request.headers.find("Digest").value_or("")))
        return expect_base64("Digest", *value);
    return std::nullopt;
}

void expect_digest(const Request& request, const Sha256& digest) {
    const auto expected = digest_of_request(request);
    if (expected && *expected != digest)
        throw HttpProblem(422, "the body's SHA-256 is " + to_hex(digest) + ", the request says " + to_hex(*expected) +
                                   ": send it again");
}

}  // namespace anyrate
