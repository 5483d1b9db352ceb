#include "core/mesh/cut_loop.h"

#include "core/mesh/edges.h"

namespace anyrate {
namespace {

constexpr int n_smoothing_rounds = 5;

std::int32_t previous_halfedge(std::int32_t h) { return next_halfedge(next_halfedge(h)); }

std::int32_t add_copy(Mesh& mesh, std::int32_t v) {
    mesh.vertices.push_back(Vec3(mesh.vertices[v]));
    if (!mesh.colours.empty()) mesh.colours.push_back(Rgb8(mesh.colours[v]));
    return mesh.n_vertices() - 1;
}

/// Gives the faces on the loop's left a copy of its vertices, and returns the copies in the loop's order.
std::vector<std::int32_t> detach_left_side(Mesh& cut, const Mesh& mesh, const std::vector<std::int32_t>& twin,
                                           const Loop& loop) {
    std::vector<std::int32_t> copies;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::int32_t copy = add_copy(cut, origin(mesh, loop[i]));
        const std::int32_t arriving = loop[i == 0 ? loop.size() - 1 : i - 1];
        // Counter-clockwise from the halfedge that leaves to the one that goes back: the fan on the left.
        for (std::int32_t h = loop[i]; h != twin[arriving]; h = twin[previous_halfedge(h)])
            cut.triangles[h / 3][h % 3] = copy;
        copies.push_back(copy);
    }
    return copies;
}

/// Closes a hole by a fan about the middle of its border, given in the order in which the fan's triangles run along it.
void cap(Mesh& mesh, const std::vector<std::int32_t>& border, std::vector<std::int32_t>& touched) {
    const std::int32_t middle = add_copy(mesh, border[0]);
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t v : border) sum += mesh.vertices[v];
    mesh.vertices[middle] = sum / static_cast<double>(border.size());
    for (std::size_t i = 0; i < border.size(); ++i)
        mesh.triangles.push_back({border[i], border[(i + 1) % border.size()], middle});
    touched.insert(touched.end(), border.begin(), border.end());
    touched.push_back(middle);
}

/// Every touched vertex to the mean of its neighbours, all at once, a few times.
void smooth(Mesh& mesh, const std::vector<std::int32_t>& touched) {
    std::vector<std::int32_t> place(mesh.vertices.size(), -1);
    for (std::size_t i = 0; i < touched.size(); ++i) place[touched[i]] = static_cast<std::int32_t>(i);
    std::vector<std::vector<std::int32_t>> neighbours(touched.size());
    for (const Triangle& t : mesh.triangles)
        for (int i = 0; i < 3; ++i)
            if (place[t[i]] >= 0) neighbours[place[t[i]]].push_back(t[(i + 1) % 3]);
    std::vector<Vec3> mean(touched.size());
    for (int round = 0; round < n_smoothing_rounds; ++round) {
        for (std::size_t i = 0; i < touched.size(); ++i) {
            Vec3 sum = Vec3::Zero();
            for (const std::int32_t v : neighbours[i]) sum += mesh.vertices[v];
            mean[i] = sum / static_cast<double>(neighbours[i].size());
        }
        for (std::size_t i = 0; i < touched.size(); ++i) mesh.vertices[touched[i]] = mean[i];
    }
}

}  // namespace

Mesh cut_and_cap(const Mesh& mesh, const std::vector<std::int32_t>& twin, std::span<const Loop> loops) {
    Mesh cut = mesh;
    std::vector<std::int32_t> touched;
    for (const Loop& loop : loops) {
        std::vector<std::int32_t> right;
        for (const std::int32_t h : loop) right.push_back(origin(mesh, h));
        std::vector<std::int32_t> left = detach_left_side(cut, mesh, twin, loop);
        left = {left.rbegin(), left.rend()};
        cap(cut, right, touched);
        cap(cut, left, touched);
    }
    smooth(cut, touched);
    return cut;
}

}  // namespace anyrate
