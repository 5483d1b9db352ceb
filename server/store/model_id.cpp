#include "server/store/model_id.h"

#include <sys/random.h>

#include <algorithm>
#include <array>

#include "core/error.h"

namespace anyrate {
namespace {

constexpr std::string_view alphabet = "abcdefghijklmnopqrstuvwxyz234567";
constexpr std::size_t id_length = 26;  // ceil(128 / 5)

}  // namespace

std::string new_model_id() {
    std::array<std::uint8_t, 16> random{};
    if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
        throw IoError("the kernel gave no random bytes for a model id");
    std::string id;
    unsigned bits = 0, n_bits = 0;
    for (const std::uint8_t byte : random) {
        bits = bits << 8 | byte;
        for (n_bits += 8; n_bits >= 5; n_bits -= 5) id += alphabet[bits >> (n_bits - 5) & 31u];
        bits &= (1u << n_bits) - 1;
    }
    id += alphabet[bits << (5 - n_bits) & 31u];
    return id;
}

bool is_model_id(std::string_view text) {
    return text.size() == id_length &&
           std::all_of(text.begin(), text.end(), [](char c) { return alphabet.find(c) != std::string_view::npos; });
}

std::uint64_t log_id_of(std::string_view model_id, std::uint64_t generation) {
    std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a, 64 bits
    const auto mix = [&](std::uint8_t byte) { hash = (hash ^ byte) * 0x100000001b3u; };
    for (const char c : model_id) mix(static_cast<std::uint8_t>(c));
    for (int shift = 0; shift < 64; shift += 8) mix(static_cast<std::uint8_t>(generation >> shift));
    return hash;
}

}  // namespace anyrate
