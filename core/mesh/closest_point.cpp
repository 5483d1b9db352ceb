#include "core/mesh/closest_point.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace anyrate {
namespace {

/// For a triangle that is next to a line, on which the regions below would divide by zero.
Vec3 closest_point_on_border(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    Vec3 best = closest_point_on_segment(p, a, b);
    for (const Vec3& q : {closest_point_on_segment(p, b, c), closest_point_on_segment(p, c, a)})
        if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
    return best;
}

}  // namespace

Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double length2 = ab.squaredNorm();
    if (length2 == 0) return a;
    return a + std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) * ab;
}

Vec3 closest_point_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    if (ab.cross(ac).squaredNorm() <= 1e-20 * ab.squaredNorm() * ac.squaredNorm())
        return closest_point_on_border(p, a, b, c);
    const double ab_ap = ab.dot(ap), ac_ap = ac.dot(ap);
    if (ab_ap <= 0 && ac_ap <= 0) return a;
    const Vec3 bp = p - b;
    const double ab_bp = ab.dot(bp), ac_bp = ac.dot(bp);
    if (ab_bp >= 0 && ac_bp <= ab_bp) return b;
    const Vec3 cp = p - c;
    const double ab_cp = ab.dot(cp), ac_cp = ac.dot(cp);
    if (ac_cp >= 0 && ab_cp <= ac_cp) return c;
    // The barycentric coordinates of p's foot, not yet divided by their sum.
    const double wc = ab_ap * ac_bp - ab_bp * ac_ap;
    if (wc <= 0 && ab_ap >= 0 && ab_bp <= 0) return a + ab_ap / (ab_ap - ab_bp) * ab;
    const double wb = ab_cp * ac_ap - ab_ap * ac_cp;
    if (wb <= 0 && ac_ap >= 0 && ac_cp <= 0) return a + ac_ap / (ac_ap - ac_cp) * ac;
    const double wa = ab_bp * ac_cp - ab_cp * ac_bp;
    const double to_c = ac_bp - ab_bp, to_b = ab_cp - ac_cp;
    if (wa <= 0 && to_c >= 0 && to_b >= 0) return b + to_c / (to_c + to_b) * (c - b);
    const double sum = wa + wb + wc;
    return a + wb / sum * ab + wc / sum * ac;
}

Vec3 barycentric(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    const double bb = ab.dot(ab), bc = ab.dot(ac), cc = ac.dot(ac), pb = ap.dot(ab), pc = ap.dot(ac);
    const double determinant = bb * cc - bc * bc;
    if (!(determinant > 0)) return Vec3::Constant(1.0 / 3);
    const double v = (cc * pb - bc * pc) / determinant, w = (bb * pc - bc * pb) / determinant;
    return {1 - v - w, v, w};
}

}  // namespace anyrate
