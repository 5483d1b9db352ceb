#include <doctest/doctest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/mesh/glb.h"
#include "proto/draco_glb.h"
#include "tests/unit/proto/log_fixture.h"

namespace anyrate {
namespace {

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value = 0;
    REQUIRE(at + 4 <= bytes.size());
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

nlohmann::json document(std::span<const std::byte> glb) {
    const auto* text = reinterpret_cast<const char*>(glb.data()) + 20;
    return nlohmann::json::parse(text, text + word(glb, 12));
}

const char* const extension = "KHR_draco_mesh_compression";

}  // namespace

TEST_CASE("Draco GLB: chunks are aligned, and accessors tell what the decoder will find") {
    const Mesh mesh = decode_mesh(testing::small_log().live, VertexBudget{0xFFFFFFFF});
    const auto glb = encode_draco_glb(mesh);
    CHECK(word(glb, 8) == glb.size());
    CHECK(word(glb, 12) % 4 == 0);
    CHECK(word(glb, 20 + word(glb, 12)) % 4 == 0);
    const auto json = document(glb);
    CHECK(json["extensionsRequired"] == nlohmann::json::array({extension}));
    const auto& primitive = json["meshes"][0]["primitives"][0];
    for (const char* name : {"POSITION", "NORMAL", "COLOR_0"}) {
        const auto& accessor = json["accessors"][primitive["attributes"][name].get<std::size_t>()];
        CHECK(accessor["count"] == mesh.n_vertices());
        CHECK_FALSE(accessor.contains("bufferView"));
        CHECK(primitive["extensions"][extension]["attributes"].contains(name));
    }
    CHECK(json["accessors"][primitive["indices"].get<std::size_t>()]["count"] == 3 * mesh.n_faces());
    const auto& position = json["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
    for (int axis = 0; axis < 3; ++axis) {
        double low = 1e9, high = -1e9;
        for (const Vec3& v : mesh.vertices) {
            low = std::min(low, v[axis]);
            high = std::max(high, v[axis]);
        }
        CHECK(position["min"][axis].get<double>() == doctest::Approx(low).epsilon(1e-4));
        CHECK(position["max"][axis].get<double>() == doctest::Approx(high).epsilon(1e-4));
    }
}

TEST_CASE("Draco GLB: it is a fifth of the plain file") {
    const auto sample = samples::icosphere_log();
    const Mesh mesh = decode_mesh(sample.live, VertexBudget{0xFFFFFFFF});
    CHECK(5 * encode_draco_glb(mesh).size() < encode_glb(mesh).size());
}

TEST_CASE("Draco GLB: a mesh without colours has none, one without triangles is an empty scene") {
    Mesh mesh = decode_mesh(testing::small_log().live, VertexBudget{42});
    mesh.colours.clear();
    const auto json = document(encode_draco_glb(mesh));
    CHECK_FALSE(json["meshes"][0]["primitives"][0]["attributes"].contains("COLOR_0"));
    CHECK_FALSE(document(encode_draco_glb({})).contains("meshes"));
}

TEST_CASE("Draco GLB: vertices of no face are left out, a mesh of needles without corners is refused") {
    Mesh mesh = decode_mesh(testing::small_log().live, VertexBudget{42});
    mesh.vertices.emplace_back(9, 9, 9);
    mesh.colours.emplace_back();
    const auto json = document(encode_draco_glb(mesh));
    CHECK(json["accessors"][0]["count"] == 42);
    mesh.triangles = {{0, 0, 0}, {1, 1, 2}};
    CHECK_THROWS_AS(encode_draco_glb(mesh), InputError);
}

}  // namespace anyrate
