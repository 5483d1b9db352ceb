// Short non-separating loops after Erickson and Whittlesey 2005: every such loop crosses an edge with a homology
// signature, so it is enough to grow shortest paths from the ends of those edges, no further than half the loop.
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <limits>
#include <queue>

#include "core/mesh/cut_loop.h"
#include "core/mesh/edges.h"
#include "core/mesh/homology.h"
#include "core/mesh/topology.h"
#include "core/parallel.h"

namespace anyrate {
namespace {

struct ShortLoop {
    double length = std::numeric_limits<double>::infinity();
    std::uint64_t signature = 0;
    Loop halfedges;
};

/// The mesh as a graph of edges with lengths and signatures.
struct SignedGraph {
    const Mesh& mesh;
    std::vector<std::int32_t> twin = twin_halfedges(mesh);
    std::vector<std::uint64_t> signature = homology_signatures(mesh, twin);
    std::vector<std::int32_t> outgoing = std::vector<std::int32_t>(mesh.vertices.size(), -1);

    explicit SignedGraph(const Mesh& m) : mesh(m) {
        for (std::int32_t h = 0; h < 3 * m.n_faces(); ++h) outgoing[origin(m, h)] = h;
    }
    double length(std::int32_t h) const {
        return (mesh.vertices[target(mesh, h)] - mesh.vertices[origin(mesh, h)]).norm();
    }
    template <class Visit>
    void for_each_outgoing(std::int32_t v, const Visit& visit) const {
        std::int32_t h = outgoing[v];
        do {
            visit(h);
            h = next_halfedge(twin[h]);
        } while (h != outgoing[v]);
    }
};

/// Shortest paths from one vertex at a time (Dijkstra 1959), within a radius; what it allocates serves the next one.
class LoopSearch {
public:
    explicit LoopSearch(const SignedGraph& graph)
        : graph_(graph),
          distance_(graph.mesh.vertices.size(), std::numeric_limits<double>::infinity()),
          arriving_(graph.mesh.vertices.size(), -1),
          signature_(graph.mesh.vertices.size(), 0) {}

    /// The shortest non-separating loop through `start`, if it is at most `max_length` long.
    ShortLoop shortest_through(std::int32_t start, double max_length) {
        grow(start, max_length / 2);
        double best = max_length;
        std::int32_t closing = -1;
        for (const std::int32_t v : reached_)
            graph_.for_each_outgoing(v, [&](std::int32_t h) {
                const std::int32_t w = target(graph_.mesh, h);
                if (v > w || (signature_[v] ^ signature_[w] ^ graph_.signature[h]) == 0) return;
                const double length = distance_[v] + distance_[w] + graph_.length(h);
                if (length > best) return;
                best = length;
                closing = h;
            });
        ShortLoop loop;
        if (closing >= 0) loop = closed_by(closing);
        for (const std::int32_t v : reached_) distance_[v] = std::numeric_limits<double>::infinity();
        reached_.clear();
        return loop;
    }

private:
    void grow(std::int32_t start, double radius) {
        using Entry = std::pair<double, std::int32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
        distance_[start] = 0;
        arriving_[start] = -1;
        signature_[start] = 0;
        reached_.push_back(start);
        front.push({0, start});
        while (!front.empty()) {
            const auto [d, v] = front.top();
            front.pop();
            if (d > distance_[v]) continue;
            graph_.for_each_outgoing(v, [&, d = d, v = v](std::int32_t h) {
                const std::int32_t w = target(graph_.mesh, h);
                const double through_v = d + graph_.length(h);
                if (through_v > radius || through_v >= distance_[w]) return;
                if (distance_[w] == std::numeric_limits<double>::infinity()) reached_.push_back(w);
                distance_[w] = through_v;
                arriving_[w] = h;
                signature_[w] = signature_[v] ^ graph_.signature[h];
                front.push({through_v, w});
            });
        }
    }

    /// Out to the closing edge and back, without the way that both have in common: what is left is simple.
    ShortLoop closed_by(std::int32_t closing) const {
        Loop out = path_to(origin(graph_.mesh, closing)), back = path_to(target(graph_.mesh, closing));
        std::size_t shared = 0;
        while (shared < out.size() && shared < back.size() && out[shared] == back[shared]) ++shared;
        ShortLoop loop;
        loop.halfedges.assign(out.begin() + static_cast<std::ptrdiff_t>(shared), out.end());
        loop.halfedges.push_back(closing);
        for (std::size_t i = back.size(); i > shared; --i) loop.halfedges.push_back(graph_.twin[back[i - 1]]);
        loop.length = 0;
        for (const std::int32_t h : loop.halfedges) {
            loop.length += graph_.length(h);
            loop.signature ^= graph_.signature[h];
        }
        return loop;
    }

    Loop path_to(std::int32_t v) const {
        Loop path;
        for (std::int32_t h = arriving_[v]; h >= 0; h = arriving_[origin(graph_.mesh, h)]) path.push_back(h);
        return {path.rbegin(), path.rend()};
    }

    const SignedGraph& graph_;
    std::vector<double> distance_;
    std::vector<std::int32_t> arriving_;  ///< the halfedge by which the shortest path reaches a vertex
    std::vector<std::uint64_t> signature_;
    std::vector<std::int32_t> reached_;
};

/// For every edge with a signature the shortest non-separating loop through one of its ends, the shortest first.
std::vector<ShortLoop> short_loops(const SignedGraph& graph, double max_length) {
    std::vector<std::int32_t> starts;
    for (std::int32_t h = 0; h < 3 * graph.mesh.n_faces(); ++h)
        if (graph.signature[h] != 0) starts.push_back(std::min(origin(graph.mesh, h), target(graph.mesh, h)));
    std::ranges::sort(starts);
    starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
    std::vector<ShortLoop> loops(starts.size());
    tbb::enumerable_thread_specific<LoopSearch> search([&] { return LoopSearch(graph); });
    parallel_for(starts.size(),
                 [&](std::size_t i) { loops[i] = search.local().shortest_through(starts[i], max_length); });
    std::erase_if(loops, [](const ShortLoop& loop) { return loop.halfedges.empty(); });
    std::ranges::stable_sort(loops, {}, &ShortLoop::length);
    return loops;
}

/// Loops that together still leave their piece whole: apart from each other, and independent in homology.
std::vector<Loop> choose_independent(const SignedGraph& graph, const std::vector<ShortLoop>& loops) {
    std::vector<Loop> chosen;
    std::vector<std::uint64_t> basis;  // of the chosen signatures; each has a highest bit that no later one has
    std::vector<bool> taken(graph.mesh.vertices.size(), false);
    for (const ShortLoop& loop : loops) {
        std::uint64_t rest = loop.signature;
        for (const std::uint64_t b : basis) rest = std::min(rest, rest ^ b);
        const auto is_taken = [&](std::int32_t h) { return taken[origin(graph.mesh, h)]; };
        if (rest == 0 || std::ranges::any_of(loop.halfedges, is_taken)) continue;
        basis.push_back(rest);
        chosen.push_back(loop.halfedges);
        for (const std::int32_t h : loop.halfedges) taken[origin(graph.mesh, h)] = true;
    }
    return chosen;
}

}  // namespace

Mesh remove_small_handles(const Mesh& mesh, double max_loop_length) {
    Mesh result = mesh;
    Topology topology = measure_topology(result);
    // The tiniest handles go first, found by searches that reach no further than they do: of the many that noise makes
    // few are left for the wide searches, whose cost grows with the square of the length.
    double length = max_loop_length / 8;
    while (topology.euler < 2 * topology.n_components) {
        const SignedGraph graph(result);
        const std::vector<Loop> loops = choose_independent(graph, short_loops(graph, length));
        if (!loops.empty()) {  // which lowers the genus by one at least
            result = cut_and_cap(result, graph.twin, loops);
            topology = measure_topology(result);
        } else if (length < max_loop_length) {
            length *= 2;
        } else {
            break;
        }
    }
    return result;
}

}  // namespace anyrate
