#pragma once
#include <algorithm>
#include <vector>

#include "core/reconstruction/silhouette_cone.h"
#include "core/reconstruction/view_sets.h"

namespace anyrate {

using Cones = std::vector<SilhouetteCone>;

/// The views that say something about a point, and how well they fix a place there together.
struct Witnesses {
    int n = 0;
    Mat3 across = Mat3::Zero();  // sum of the projections across the views' axes

    void add(const SilhouetteCone& cone) {
        ++n;
        if (const auto axis = cone.axis()) across += Mat3::Identity() - *axis * axis->transpose();
    }
    Witnesses& operator+=(const Witnesses& others) {
        n += others.n;
        across += others.across;
        return *this;
    }
};

/// A point about which too few views say something is not part of the hull. Complete views speak of all space: two of
/// them will do. Where there are none, the cones of a few neighbours still overlap far behind the object, in places
/// that no other image contains: so there are to be many, or they look across each other. A place is as uncertain along
/// its worst direction as the least eigenvalue of `across` is small: 1 - cos(angle) of two views. Of nefertiti's 22
/// images cut to 70 % of their sides a third of the views alone cuts off parts that six see: 0.0303 % instead of 0.0250
/// %.
class WitnessRule {
public:
    explicit WitnessRule(const Cones& cones) {
        const auto n_complete =
            std::count_if(cones.begin(), cones.end(), [](const auto& cone) { return cone.is_complete(); });
        is_complete_ = n_complete >= 2;
        many_ = is_complete_ ? 2 : std::max(2, static_cast<int>(cones.size()) / 3);
    }

    /// Whether so many are enough wherever they look from.
    bool are_many(int n) const { return n >= many_; }

    bool are_enough(const Witnesses& witnesses) const {
        if (are_many(witnesses.n)) return true;
        if (is_complete_ || witnesses.n < fewest) return false;
        // The least eigenvalue is above a bound if what is left without the bound is positive definite (Sylvester).
        const Mat3 left = witnesses.across - least_across * Mat3::Identity();
        return left(0, 0) > 0 && left.topLeftCorner<2, 2>().determinant() > 0 && left.determinant() > 0;
    }

private:
    static constexpr int fewest = 3;
    static constexpr double least_across = 0.5;  // as of two views 60 degrees apart
    bool is_complete_ = false;
    int many_ = 2;
};

/// @param views  by their places among the cones
inline Witnesses witnesses_of(const Cones& cones, ConstViewSet views) {
    Witnesses witnesses;
    all_of(views, [&](std::size_t view) {
        witnesses.add(cones[view]);
        return true;
    });
    return witnesses;
}

}  // namespace anyrate
