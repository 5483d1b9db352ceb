#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/progressive/refinable_mesh.h"

namespace anyrate {

/// Quantiser steps of colour residuals, 8-bit units (proto/FORMAT.md, "Colours").
struct ColourSteps {
    int luma = 4;
    int chroma = 6;
    friend bool operator==(const ColourSteps&, const ColourSteps&) = default;
};

/// The first bytes of a log (proto/FORMAT.md, "Header").
struct Header {
    std::uint16_t major = 1, minor = 0;
    std::uint64_t log_id = 0;
    Grid grid;
    RefinementRules rules;
    std::uint32_t n_base_vertices = 0, n_base_faces = 0;
    bool sealed = false;
    ColourSteps colour_steps;
    std::uint32_t header_bytes = 96;  ///< more than header_size in a log of a later minor version
};

inline constexpr std::size_t header_size = 96;

/// The header_size bytes of this version; `header.header_bytes` and versions are those of this writer.
std::vector<std::byte> encode_header(const Header& header);
/// @param bytes a log from its start; may be longer than the header
/// @throws DecodeError if the header is not whole, not sound, or of another major version
Header decode_header(std::span<const std::byte> bytes);
/// How many bytes decode_header() needs, from the first header_size bytes of a log. @throws DecodeError if they start
/// no log
std::size_t header_bytes_needed(std::span<const std::byte> bytes);
/// The same header with the sealed flag on; a tail of a later minor version stays. @throws DecodeError
std::vector<std::byte> sealed_header(std::span<const std::byte> header);

}  // namespace anyrate
