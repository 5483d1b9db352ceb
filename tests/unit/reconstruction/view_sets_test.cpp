#include "core/reconstruction/view_sets.h"

#include <doctest/doctest.h>

#include <array>
#include <vector>

using namespace anyrate;

namespace {

std::vector<std::size_t> members(ConstViewSet set) {
    std::vector<std::size_t> views;
    all_of(set, [&](std::size_t view) {
        views.push_back(view);
        return true;
    });
    return views;
}

}  // namespace

TEST_CASE("Sets of views: what is inserted and not removed is a member, of more views than fit a word, too") {
    ViewSets sets(2, 130);
    for (const std::size_t view : {129, 0, 63, 64, 5}) insert(sets[1], view);
    remove(sets[1], 5);
    remove(sets[1], 7);
    CHECK(members(sets[1]) == std::vector<std::size_t>{0, 63, 64, 129});
    CHECK(count(sets[1]) == 4);
    CHECK(count(sets[0]) == 0);
}

TEST_CASE("Sets of views: a visit that says no is the last") {
    ViewSets sets(1, 70);
    for (const std::size_t view : {1, 3, 66}) insert(sets[0], view);
    std::vector<std::size_t> visited;
    CHECK_FALSE(all_of(sets[0], [&](std::size_t view) {
        visited.push_back(view);
        return view < 3;
    }));
    CHECK(visited == std::vector<std::size_t>{1, 3});
}

TEST_CASE("Sets of views: those that are appended stand behind the own ones") {
    ViewSets others(4, 65), sets(1, 65);
    for (std::size_t i = 0; i < 4; ++i) insert(others[i], 61 + i);
    insert(sets[0], 7);
    sets.append(others, std::array<std::size_t, 2>{1, 3});
    CHECK(members(sets[0]) == std::vector<std::size_t>{7});
    CHECK(members(sets[1]) == std::vector<std::size_t>{62});
    CHECK(members(sets[2]) == std::vector<std::size_t>{64});
}
