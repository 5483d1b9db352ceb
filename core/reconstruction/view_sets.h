#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace anyrate {

/// A set of views, a bit a view.
using ViewSet = std::span<std::uint64_t>;
using ConstViewSet = std::span<const std::uint64_t>;

inline int count(ConstViewSet set) {
    int n = 0;
    for (const std::uint64_t word : set) n += std::popcount(word);
    return n;
}

/// Calls visit(view) for the views of a set, ascending, until it returns false.
/// @return whether it never did
template <class Visit>
bool all_of(ConstViewSet set, const Visit& visit) {
    for (std::size_t i = 0; i < set.size(); ++i)
        for (std::uint64_t left = set[i]; left != 0; left &= left - 1)
            if (!visit(64 * i + static_cast<std::size_t>(std::countr_zero(left)))) return false;
    return true;
}

inline void remove(ViewSet set, std::size_t view) { set[view / 64] &= ~(std::uint64_t{1} << view % 64); }
inline void insert(ViewSet set, std::size_t view) { set[view / 64] |= std::uint64_t{1} << view % 64; }

/// One set for each of many things, all empty at first.
class ViewSets {
public:
    ViewSets(std::size_t n_sets, std::size_t n_views)
        : n_words_(std::max<std::size_t>(1, (n_views + 63) / 64)), words_(n_words_ * n_sets) {}

    ViewSet operator[](std::size_t i) { return ViewSet(words_).subspan(n_words_ * i, n_words_); }
    ConstViewSet operator[](std::size_t i) const { return ConstViewSet(words_).subspan(n_words_ * i, n_words_); }

    /// Puts these sets of `others`, of as many views, behind the own ones.
    void append(const ViewSets& others, std::span<const std::size_t> chosen) {
        for (const std::size_t i : chosen) words_.insert(words_.end(), others[i].begin(), others[i].end());
    }

private:
    std::size_t n_words_;
    std::vector<std::uint64_t> words_;
};

}  // namespace anyrate
