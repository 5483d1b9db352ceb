#pragma once
// The only arithmetic a refinement may use: IEEE doubles, each operation rounded on its own, in the order that
// proto/FORMAT.md, "Arithmetic", writes down. (Eigen is free to sum a dot product in another order, so it stays out.)
#include <cmath>

#include "core/progressive/grid.h"

namespace anyrate {

/// A vector of the refinement: grid units, unless it is a direction.
struct LatticeVector {
    double x = 0, y = 0, z = 0;
};

inline LatticeVector lattice_vector(const GridPoint& p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

inline LatticeVector operator+(const LatticeVector& a, const LatticeVector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline LatticeVector operator-(const LatticeVector& a, const LatticeVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline LatticeVector operator*(double s, const LatticeVector& a) { return {s * a.x, s * a.y, s * a.z}; }
inline LatticeVector operator/(const LatticeVector& a, double s) { return {a.x / s, a.y / s, a.z / s}; }

inline double dot(const LatticeVector& a, const LatticeVector& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
inline LatticeVector cross(const LatticeVector& a, const LatticeVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const LatticeVector& a) { return std::sqrt(dot(a, a)); }

/// The nearest integer, halves up.
inline double round_half_up(double x) { return std::floor(x + 0.5); }

}  // namespace anyrate
