#pragma once
#include <cstdint>
#include <numeric>
#include <vector>

namespace anyrate {

/// Union-find over 0..n-1 with path halving. The smallest member names its set, so that the result does not depend on
/// the order of the unions.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

    std::int32_t find(std::int32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(std::int32_t a, std::int32_t b) {
        a = find(a);
        b = find(b);
        (a < b ? parent_[b] : parent_[a]) = a < b ? a : b;
    }

private:
    std::vector<std::int32_t> parent_;
};

}  // namespace anyrate
