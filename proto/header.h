#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// The first bytes of a log (proto/FORMAT.md, "Header").
struct Header {
    std::uint16_t major = 1, minor = 0;
    std::uint64_t log_id = 0;
    Grid grid;
    RefinementRules rules;
    std::uint32_t n_base_vertices = 0, n_base_faces = 0;
    bool sealed = false;
};

inline constexpr std::size_t header_size = 96;

std::vector<std::byte> encode_header(const Header& header);
/// @throws DecodeError
Header decode_header(std::span<const std::byte> bytes);

}  // namespace anyrate
