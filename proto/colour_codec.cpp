#include "proto/colour_codec.h"

#include <array>

#include "core/error.h"
#include "proto/draco_io.h"

namespace anyrate {

namespace {

constexpr std::array<int, 2> layout = {1, 2};  // luma | Co, Cg
constexpr std::int32_t max_residual = 511;     // no two chroma values differ by more

}  // namespace

std::vector<std::byte> encode_colour(std::span<const ColourResidual> residuals) {
    std::array<IntAttribute, 2> columns;
    for (std::size_t a = 0; a < columns.size(); ++a) columns[a].n_components = layout[a];
    for (const ColourResidual& residual : residuals) {
        columns[0].values.push_back(residual.luma);
        columns[1].values.insert(columns[1].values.end(), {residual.orange, residual.green});
    }
    return encode_point_cloud(residuals.size(), columns);
}

std::vector<ColourResidual> decode_colour(std::span<const std::byte> payload, std::size_t n_vertices) {
    const std::vector<IntAttribute> columns = decode_point_cloud(payload, n_vertices, layout);
    const auto checked = [](std::int32_t value) {
        if (value < -max_residual || value > max_residual) throw DecodeError("colour packet: a residual beyond 511");
        return value;
    };
    std::vector<ColourResidual> residuals(n_vertices);
    for (std::size_t i = 0; i < n_vertices; ++i) {
        residuals[i] = {checked(columns[0].values[i]), checked(columns[1].values[2 * i]),
                        checked(columns[1].values[2 * i + 1])};
    }
    return residuals;
}

}  // namespace anyrate
