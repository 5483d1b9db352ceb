#include "core/simulation/vessel_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/simulation/scene_field.h"
#include "core/simulation/vessel_ornament.h"
#include "core/simulation/vessel_shape.h"

namespace anyrate {
namespace {

using std::numbers::pi;

const Vec3 ivory(0.74, 0.66, 0.48), ochre(0.66, 0.40, 0.09), gold(0.72, 0.48, 0.14), terracotta(0.46, 0.17, 0.07),
    crimson(0.36, 0.055, 0.045), cobalt(0.055, 0.13, 0.42), navy(0.035, 0.055, 0.14), teal(0.06, 0.27, 0.26),
    leaf_green(0.16, 0.30, 0.09), plum(0.17, 0.05, 0.12);

/// Whether the nearest of evenly spaced lines, `step` apart and the first at 0, is closer than half of `width`.
bool on_line(double x, double step, double width) { return std::abs(x - step * std::round(x / step)) < 0.5 * width; }

/// x in turns of `step` around its nearest multiple: in [-0.5, 0.5].
double in_step(double x, double step) { return x / step - std::round(x / step); }

/// One hook of the Greek key. The band is 9 cells high with its borders; a hook is 8 cells wide.
bool greek_key(double cells_along, double cells_up) {
    static constexpr std::array<std::string_view, 9> hook{"########", "........", "#######.", "#.....#.", "#.###.#.",
                                                          "#.#...#.", "#.#####.", "#.......", "########"};
    const auto row = static_cast<int>(std::floor(9 - cells_up));
    if (row < 0 || row > 8) return false;
    const auto column = static_cast<int>(std::floor(cells_along - 8 * std::floor(cells_along / 8)));
    return hook[static_cast<std::size_t>(row)][static_cast<std::size_t>(std::clamp(column, 0, 7))] == '#';
}

/// A flower of eight petals in the unit disk; nothing of it outside.
Vec3 rosette(const Vec3& ground, double u, double v, const Vec3& petal, const Vec3& heart) {
    const double distance = length(u, v);
    if (distance > 1) return ground;
    const double petals = std::abs(std::cos(4 * std::atan2(u, v)));
    if (distance < 0.24) return heart;
    if (distance < 0.30) return ground;
    return distance < 0.55 + 0.45 * petals ? blend(petal, heart, 0.5 * smooth_step(0.8, 0.3, distance)) : ground;
}

Vec3 paint_foot(double angle, double z) {
    if (z < vessel_zone::foot.low + 0.045) return on_line(angle, 2 * pi / 40, 0.06) ? navy : ochre;
    return length(in_step(angle, 2 * pi / 24), (z + 0.915) / 0.055) < 0.34 ? ivory : crimson;
}

Vec3 paint_stem(double angle, double z) {
    const double spiral = in_step(angle + 9 * z, 2 * pi / 16);
    return std::abs(spiral) < 0.22 ? gold : navy;
}

Vec3 paint_tongues(double angle, double z) {
    const double raised = tongues(angle, z);
    // The grooves lie at even multiples of the half step, so a tongue's number is the whole part.
    const int number = static_cast<int>(std::floor((angle + pi) * n_tongues / (2 * pi)));
    const double across = std::abs(in_step(angle + pi / n_tongues, 2 * pi / n_tongues));
    if (raised < 0.30) return crimson;
    if (raised < 0.55) return gold;
    const Vec3 body = number % 2 == 0 ? cobalt : ivory;
    const Vec3 accent = number % 2 == 0 ? ivory : terracotta;
    if (across < 0.035) return accent;
    // Chevrons along the spine.
    return across < 0.26 && on_line(z - 0.10 * across, 0.036, 0.011) ? accent : body;
}

Vec3 paint_beads(double angle, double z) {
    const double raised = beads(angle, z);
    if (raised > 0.80) return ivory;
    if (raised > 0.05) return gold;
    return std::abs(z - vessel_zone::beads.middle()) > 0.042 ? ochre : navy;
}

Vec3 paint_frieze(double angle, double z) {
    const Vine v = vine(angle, z);
    if (v.berry > 0.1) return blend(plum, crimson, smooth_step(0.45, 0.80, v.berry));
    if (v.leaf > 0.25) return blend(v.leaf > 0.55 ? leaf_green : ivory, gold, v.vein);
    if (v.stem > 0.2) return v.stem > 0.75 ? ochre : ivory;
    // Scales of two glazes on the ground.
    const double row = (z + 1) / 0.026;
    const double shift = static_cast<int>(std::floor(row)) % 2 == 0 ? 0.0 : 0.5;
    const double u = in_step(angle * 60 / (2 * pi) + shift, 1), w = row - std::floor(row);
    const double scale = length(u, 0.85 * w);
    return scale < 0.42 ? Vec3(terracotta) : (scale < 0.52 ? Vec3(ochre) : Vec3(0.26, 0.07, 0.035));
}

Vec3 paint_meander(double angle, double z) {
    constexpr int n_hooks = 29;
    const auto& [low, high] = vessel_zone::meander;
    return greek_key((angle + pi) / (2 * pi) * n_hooks * 8, (z - low) / (high - low) * 9) ? navy : ivory;
}

Vec3 paint_eggs(double angle, double z) {
    const double raised = eggs(angle, z);
    if (raised < 0.15) return on_line(angle - pi / n_eggs, 2 * pi / n_eggs, 0.016) ? ochre : teal;
    if (raised < 0.60) return ivory;
    const int number = static_cast<int>(std::round((angle + 2 * pi) * n_eggs / (2 * pi)));
    return number % 2 == 0 ? crimson : cobalt;
}

Vec3 paint_neck(double angle, double z) {
    const auto& [low, high] = vessel_zone::neck;
    if (z < low + 0.03 || z > high - 0.03) return on_line(angle, 2 * pi / 44, 0.07) ? crimson : gold;
    // Two staggered rows of flowers on cobalt, small stars between.
    constexpr int n_flowers = 12;
    const double height = (z - 0.5 * (low + high)) / 0.055;
    const double row = height > 0 ? 1.0 : -1.0;
    const double phase = row > 0 ? 0.0 : 0.5;
    const double u = in_step(angle + phase * 2 * pi / n_flowers, 2 * pi / n_flowers) * 2.65;
    const Vec3 flower = rosette(cobalt, u, (height - row), ivory, ochre);
    const double star_u = (std::abs(u) - 1.32) * 2.2, star_v = (height - row) * 2.2;
    return std::sqrt(std::abs(star_u)) + std::sqrt(std::abs(star_v)) < 1.0 ? ivory : flower;
}

Vec3 paint_lip(double angle, double z) {
    if (z > 0.925) return lip_rope(angle, z) > 0.55 ? gold : navy;
    const double zigzag = 0.12 * std::abs(in_step(angle, 2 * pi / 24));
    const double level = z - 0.835 - zigzag;
    if (std::abs(level) < 0.010) return navy;
    return level > 0 ? (level < 0.022 ? ochre : ivory) : (level > -0.022 ? ivory : crimson);
}

Vec3 paint_cavity(double angle, double r, double z) {
    if (z < cavity_floor + 0.06)
        return on_line(r, 0.05, 0.018) ? cobalt : rosette(ivory, r / 0.2, 0, terracotta, ochre);
    if (z > 0.93) return on_line(angle, 2 * pi / 36, 0.09) ? crimson : gold;
    const double wave = z + 0.014 * std::sin(14 * angle);
    if (on_line(wave, 0.125, 0.016)) return navy;
    const double row = std::round(z / 0.125 - 0.5) * 0.125 + 0.0625;
    const double u = in_step(angle + row * 9, 2 * pi / 14) * 3.2, v = (z - row) / 0.042;
    return rosette(ivory, u, v, std::fmod(row, 0.25) < 0.125 ? cobalt : terracotta, ochre);
}

Vec3 paint_handle(const HandlePoint& place) {
    const double raised = strands(place);
    if (raised < 0.45) return crimson;
    const double turns = 1.5 * place.around + 17 * place.along;
    const double stripe = in_step(turns - 0.5 * pi, pi);
    if (std::abs(stripe) < 0.06) return navy;
    return on_line(place.along + 0.08 * std::abs(stripe), 0.034, 0.012) ? cobalt : gold;
}

Vec3 paint_outside(double angle, double z) {
    using namespace vessel_zone;
    if (z < foot.high) return paint_foot(angle, z);
    if (z < stem.high) return paint_stem(angle, z);
    if (z < vessel_zone::tongues.high) return paint_tongues(angle, z);
    if (z < vessel_zone::beads.high) return paint_beads(angle, z);
    if (z < frieze.high) return paint_frieze(angle, z);
    if (z < meander.high) return paint_meander(angle, z);
    if (z < vessel_zone::eggs.high) return paint_eggs(angle, z);
    if (z < collar.high) return on_line(angle + 4 * z, 2 * pi / 30, 0.10) ? gold : crimson;
    if (z < neck.high) return paint_neck(angle, z);
    return paint_lip(angle, z);
}

Vec3 glaze(const Vec3& p) {
    const double r = length(p.x(), p.y()), z = p.z(), angle = std::atan2(p.y(), p.x());
    const double wall = vessel_radius(z);
    if (z > cavity_floor - 0.02 && r < 0.5 * (wall + cavity_radius(z))) return paint_cavity(angle, r, z);
    if (r > wall + 0.030) {
        if (const auto place = on_handle(p); place && place->distance < 0.075) return paint_handle(*place);
    }
    return paint_outside(angle, z);
}

}  // namespace

SolidTexture vessel_paint(std::uint64_t seed) {
    return [noise = SolidNoise(seed), patina = Patina(seed + 1)](const Vec3& p) -> Vec3 {
        const Vec3 painted = glaze(p);
        // Where the glaze has gone the fired clay shows, pale at the broken edge.
        const double loss = noise.fbm(4.5 * p, 4, 0.7);
        const Vec3 clay(0.50, 0.27, 0.15), edge(0.72, 0.58, 0.42);
        const Vec3 worn = loss > 0.72 ? clay : (loss > 0.69 ? edge : painted);
        return (worn * patina(p)).cwiseMin(1.0).cwiseMax(0.008);
    };
}

}  // namespace anyrate
