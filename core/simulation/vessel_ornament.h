#pragma once
// The ornaments of the carved vessel, as functions of the angle around its axis (radians) and the height z. The carver
// raises the surface by them, the painter colours what is raised: both ask here, so that paint and relief agree.
// All give 0 on the ground and rise to 1 on the ornament.

namespace anyrate {

/// A horizontal zone of the vessel, which stands from z = -1 to z = 1.
struct Zone {
    double low, high;
    bool contains(double z) const { return z >= low && z < high; }
    double middle() const { return 0.5 * (low + high); }
};
namespace vessel_zone {
inline constexpr Zone foot{-1.00, -0.86};
inline constexpr Zone stem{-0.86, -0.73};
inline constexpr Zone tongues{-0.73, -0.34};
inline constexpr Zone beads{-0.34, -0.22};
inline constexpr Zone frieze{-0.22, 0.12};
inline constexpr Zone meander{0.12, 0.28};
inline constexpr Zone eggs{0.28, 0.45};
inline constexpr Zone collar{0.45, 0.52};
inline constexpr Zone neck{0.52, 0.80};
inline constexpr Zone lip{0.80, 1.00};
}  // namespace vessel_zone

/// Radius of the vessel's outside without its relief: foot, stem, belly, shoulder, neck and flaring lip.
double vessel_radius(double z);
/// Its slope dr/dz.
double vessel_slope(double z);
/// Radius of the cavity inside, for z above its floor.
double cavity_radius(double z);
inline constexpr double cavity_floor = 0.20;

/// Upright round tongues around the lower belly, with grooves between them. Their number is `n_tongues`.
inline constexpr int n_tongues = 28;
double tongues(double angle, double z);

/// A row of pearls.
double beads(double angle, double z);

/// A wavy stem with a leaf in every bay and a bunch of berries on every crossing.
struct Vine {
    double stem = 0, leaf = 0, berry = 0;
    double vein = 0;  ///< inside a leaf: its ribs
};
Vine vine(double angle, double z);

/// Hanging eggs on the shoulder, `n_eggs` of them.
inline constexpr int n_eggs = 30;
double eggs(double angle, double z);

/// The horizontal mouldings of foot, stem, belly and neck.
double mouldings(double z);

/// The twisted edge of the lip.
double lip_rope(double angle, double z);

}  // namespace anyrate
