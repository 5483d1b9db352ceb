#pragma once
#include "core/mesh/mesh.h"

namespace anyrate {

/// A sphere: the icosahedron with every triangle split in four `subdivisions` times, new vertices pushed onto the
/// sphere. 20 * 4^subdivisions triangles, a closed manifold of genus 0, all vertices at `radius` from `centre`.
Mesh icosphere(int subdivisions, double radius = 1.0, const Vec3& centre = Vec3::Zero());

/// A torus around the z axis: a regular grid of n_around x n_across vertices, a closed manifold of genus 1.
/// @param major_radius  of the circle in the middle of the tube
/// @param minor_radius  of the tube, smaller than major_radius
/// @param n_around, n_across  vertices around the axis and around the tube, at least 3 each
Mesh torus(double major_radius, double minor_radius, int n_around, int n_across);

}  // namespace anyrate
