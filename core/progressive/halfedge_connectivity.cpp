#include "core/progressive/halfedge_connectivity.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace anyrate {

namespace {

/// A directed edge and the half-edge that runs along it; sorted by edge, each edge stands beside its duplicates.
struct DirectedEdge {
    std::uint64_t ends;  ///< origin in the high word, target in the low word
    std::int32_t halfedge;
};

std::uint64_t directed(std::int32_t origin, std::int32_t target) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(origin)) << 32 | static_cast<std::uint32_t>(target);
}

std::string edge_name(std::uint64_t ends) {
    return "edge " + std::to_string(ends >> 32) + " -> " + std::to_string(ends & 0xFFFFFFFFu);
}

void check_corners(int n_vertices, std::span<const Triangle> triangles) {
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        const auto& [a, b, c] = triangles[f];
        for (const std::int32_t v : triangles[f]) {
            if (v < 0 || v >= n_vertices) {
                throw DecodeError("base face " + std::to_string(f) + ": vertex " + std::to_string(v) + " of only " +
                                  std::to_string(n_vertices));
            }
        }
        if (a == b || b == c || c == a) {
            throw DecodeError("base face " + std::to_string(f) + ": expected three different corners");
        }
    }
}

}  // namespace

HalfedgeConnectivity::HalfedgeConnectivity(int n_vertices, std::span<const Triangle> triangles)
    : triangles_(triangles.begin(), triangles.end()) {
    if (n_vertices < 4 || n_vertices > max_log_vertices || triangles.size() > 2 * std::size_t{max_log_vertices}) {
        throw DecodeError("base: expected 4 to 2^24 vertices and at most 2^25 faces, got " +
                          std::to_string(n_vertices) + " and " + std::to_string(triangles.size()));
    }
    check_corners(n_vertices, triangles);
    twin_.resize(3 * triangles_.size());
    match_twins();

    outgoing_.assign(index(n_vertices), -1);
    valence_.assign(index(n_vertices), 0);
    for (std::int32_t h = static_cast<std::int32_t>(twin_.size()) - 1; h >= 0; --h) {
        outgoing_[index(origin(h))] = h;
        ++valence_[index(origin(h))];
    }
    check_fans();
}

void HalfedgeConnectivity::match_twins() {
    std::vector<DirectedEdge> edges(twin_.size());
    for (std::int32_t h = 0; index(h) < edges.size(); ++h) edges[index(h)] = {directed(origin(h), target(h)), h};
    const auto by_ends = [](const DirectedEdge& a, const DirectedEdge& b) { return a.ends < b.ends; };
    std::sort(edges.begin(), edges.end(), by_ends);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i + 1 < edges.size() && edges[i].ends == edges[i + 1].ends) {
            throw DecodeError("base: " + edge_name(edges[i].ends) +
                              " occurs in two faces; expected a consistently oriented manifold");
        }
        const std::uint64_t reverse = edges[i].ends << 32 | edges[i].ends >> 32;
        const auto opposite = std::lower_bound(edges.begin(), edges.end(), DirectedEdge{reverse, 0}, by_ends);
        if (opposite == edges.end() || opposite->ends != reverse) {
            throw DecodeError("base: " + edge_name(edges[i].ends) +
                              " has no face on its other side; expected a closed mesh");
        }
        twin_[index(edges[i].halfedge)] = opposite->halfedge;
    }
}

void HalfedgeConnectivity::check_fans() const {
    for (std::int32_t v = 0; v < n_vertices(); ++v) {
        if (valence(v) < 3) {
            throw DecodeError("base vertex " + std::to_string(v) + ": expected at least three edges, got " +
                              std::to_string(valence(v)));
        }
        int walked = 0;
        std::int32_t h = outgoing(v);
        do {
            ++walked;
            h = next_spoke(h);
        } while (h != outgoing(v));
        if (walked != valence(v)) {
            throw DecodeError("base vertex " + std::to_string(v) +
                              ": its faces form more than one fan; expected a manifold");
        }
    }
}

bool HalfedgeConnectivity::are_neighbours(std::int32_t a, std::int32_t b) const {
    const std::int32_t first = outgoing(a);
    std::int32_t h = first;
    do {
        if (target(h) == b) return true;
        h = next_spoke(h);
    } while (h != first);
    return false;
}

std::optional<std::array<std::int32_t, 6>> HalfedgeConnectivity::split_site(std::int32_t face) const {
    if (face < 0 || face >= n_faces() || n_vertices() + 3 > max_log_vertices) return std::nullopt;
    std::array<std::int32_t, 6> site;
    for (std::int32_t i = 0; i < 3; ++i) {
        site[index(i)] = origin(3 * face + i);
        site[index(3 + i)] = origin(prev(twin(3 * face + i)));
    }
    for (std::size_t i = 0; i < 6; ++i) {
        if (valence(site[i]) >= max_valence) return std::nullopt;
        for (std::size_t j = 0; j < i; ++j) {
            if (site[i] == site[j]) return std::nullopt;
        }
    }
    return site;
}

void HalfedgeConnectivity::split(std::int32_t face, const std::array<std::int32_t, 6>& site) {
    const std::int32_t V = n_vertices(), F = n_faces();
    // All arrays grow before the first journalled write: the journal keeps addresses.
    triangles_.resize(triangles_.size() + 6);
    twin_.resize(twin_.size() + 18);
    outgoing_.resize(outgoing_.size() + 3);
    valence_.resize(valence_.size() + 3, 5);

    std::array<std::int32_t, 3> inner, outer;  // t_i and o_i of FORMAT.md
    for (std::int32_t i = 0; i < 3; ++i) {
        inner[index(i)] = twin(3 * face + i);
        outer[index(i)] = twin(next(inner[index(i)]));
    }
    for (std::int32_t i = 0; i < 3; ++i) {
        const std::int32_t c = site[index(i)], a = site[index(3 + i)], t = inner[index(i)];
        const std::int32_t m = V + i, m_before = V + (i + 2) % 3;
        const std::int32_t corner = F + i, next_corner = F + (i + 1) % 3, half = F + 3 + i;
        triangles_[index(corner)] = {c, m, m_before};
        triangles_[index(half)] = {m, c, a};
        set_origin(3 * face + i, m);
        set_origin(next(t), m);

        link(3 * face + i, 3 * next_corner + 1);
        link(3 * corner, 3 * half);
        link(t, 3 * next_corner + 2);
        link(3 * half + 1, outer[index(i)]);
        link(3 * half + 2, next(t));

        outgoing_[index(m)] = 3 * face + i;
        journal_.set(outgoing_[index(c)], 3 * corner);
        add_valence(a, 1);
    }
}

bool HalfedgeConnectivity::can_flip(std::int32_t h) const {
    const std::int32_t t = twin(h);
    const std::int32_t m = origin(prev(h)), s = origin(prev(t));
    return valence(origin(h)) >= 4 && valence(origin(t)) >= 4 && valence(m) < max_valence && valence(s) < max_valence &&
           m != s && !are_neighbours(m, s);
}

void HalfedgeConnectivity::flip(std::int32_t h) {
    const std::int32_t t = twin(h);
    const std::int32_t hn = next(h), hp = prev(h), tn = next(t), tp = prev(t);
    const std::int32_t p = origin(h), q = origin(t), m = origin(hp), s = origin(tp);
    const std::int32_t beyond_ps = twin(tn), beyond_qm = twin(hn);

    set_origin(hn, s);  // face of h: m p s
    set_origin(tn, m);  // face of t: s q m
    link(h, beyond_ps);
    link(t, beyond_qm);
    link(hn, tn);

    journal_.set(outgoing_[index(p)], h);
    journal_.set(outgoing_[index(q)], t);
    add_valence(p, -1);
    add_valence(q, -1);
    add_valence(m, 1);
    add_valence(s, 1);
}

void HalfedgeConnectivity::roll_back(int n_vertices, int n_faces) {
    journal_.undo();
    triangles_.resize(index(n_faces));
    twin_.resize(3 * index(n_faces));
    outgoing_.resize(index(n_vertices));
    valence_.resize(index(n_vertices));
}

}  // namespace anyrate
