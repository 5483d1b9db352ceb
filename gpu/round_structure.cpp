#include "gpu/round_structure.h"

#include <span>

namespace anyrate {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

/// Where each of `n` things stands in a list of some of them, -1 where it does not.
std::vector<std::int32_t> places_in(std::span<const std::int32_t> list, std::size_t n) {
    std::vector<std::int32_t> places(n, -1);
    for (std::size_t i = 0; i < list.size(); ++i) places[at(list[i])] = static_cast<std::int32_t>(i);
    return places;
}

}  // namespace

RoundStructure round_structure(const OptimiseRound& round, std::size_t n_vertices) {
    const std::vector<std::int32_t> active_places = places_in(round.active, n_vertices);
    const std::vector<std::int32_t> slots = places_in(round.faces, round.triangles.size());
    RoundStructure structure;
    structure.head = {static_cast<std::int32_t>(round.active.size()), static_cast<std::int32_t>(round.faces.size()),
                      static_cast<std::int32_t>(n_vertices)};
    std::vector<std::int32_t>& items = structure.items;
    const auto begin_list = [&] { structure.head.push_back(static_cast<std::int32_t>(items.size())); };
    const auto append = [&](std::span<const std::int32_t> list) {
        items.insert(items.end(), list.begin(), list.end());
    };

    begin_list();
    append(round.active);

    begin_list();
    std::int32_t n_so_far = 0;
    for (std::size_t v = 0; v < n_vertices; ++v) {
        items.push_back(n_so_far);
        n_so_far += static_cast<std::int32_t>(round.rings.faces(static_cast<std::int32_t>(v)).size());
    }
    items.push_back(n_so_far);
    begin_list();
    for (std::size_t v = 0; v < n_vertices; ++v) append(round.rings.faces(static_cast<std::int32_t>(v)));

    begin_list();
    append(round.faces);
    begin_list();
    append(slots);

    begin_list();
    n_so_far = 0;
    for (const std::int32_t v : round.active) {
        items.push_back(n_so_far);
        n_so_far += round.rings.valence(v);
    }
    items.push_back(n_so_far);
    begin_list();
    for (const std::int32_t v : round.active)
        for (const std::int32_t w : round.rings.neighbours(v))
            items.insert(items.end(), {w, active_places[at(w)], round.rings.valence(w)});
    return structure;
}

}  // namespace anyrate
