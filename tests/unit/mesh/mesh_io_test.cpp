#include "core/mesh/mesh_io.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/error.h"
#include "core/mesh/normals.h"
#include "core/simulation/parametric_meshes.h"
#include "shapes.h"

using namespace anyrate;

namespace {

std::vector<std::byte> bytes_of(const std::string& text) {
    const auto view = std::as_bytes(std::span(text));
    return {view.begin(), view.end()};
}

Mesh decode(const std::string& text, MeshFormat format) { return decode_mesh_file(bytes_of(text), format, "test"); }

Mesh coloured_sphere() {
    Mesh mesh = icosphere(1, 0.7);
    for (int v = 0; v < mesh.n_vertices(); ++v)
        mesh.colours.push_back({static_cast<std::uint8_t>(6 * v), static_cast<std::uint8_t>(255 - 5 * v), 17});
    return mesh;
}

std::string ply_header(const std::string& format, const std::string& vertices, const std::string& faces) {
    return "ply\nformat " + format + " 1.0\ncomment a test\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

struct Glb {
    nlohmann::json json;
    std::vector<std::byte> bin;

    template <class Number>
    Number number(int accessor, std::size_t index) const {
        const auto& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<int>()];
        Number value;
        std::memcpy(&value, bin.data() + view["byteOffset"].get<std::size_t>() + index * sizeof value, sizeof value);
        return value;
    }
};

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value;
    REQUIRE(at + 4 <= bytes.size());
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
}

/// Takes a GLB file apart and checks its frame: magic, version, lengths, chunk order and alignment.
Glb parse_glb(std::span<const std::byte> file) {
    CHECK(word(file, 0) == 0x46546C67);
    CHECK(word(file, 4) == 2);
    CHECK(word(file, 8) == file.size());
    const std::size_t json_size = word(file, 12);
    CHECK(word(file, 16) == 0x4E4F534A);
    CHECK(json_size % 4 == 0);
    const auto* text = reinterpret_cast<const char*>(file.data()) + 20;
    Glb glb{nlohmann::json::parse(text, text + json_size), {}};
    if (20 + json_size < file.size()) {
        const std::size_t bin_size = word(file, 20 + json_size);
        CHECK(word(file, 24 + json_size) == 0x004E4942);
        CHECK(28 + json_size + bin_size == file.size());
        glb.bin.assign(file.begin() + 28 + static_cast<std::ptrdiff_t>(json_size), file.end());
    }
    return glb;
}

}  // namespace

TEST_CASE("PLY: positions come back as floats, triangles and colours unchanged") {
    const Mesh mesh = coloured_sphere();
    const Mesh back = decode_mesh_file(encode_mesh_file(mesh, MeshFormat::ply), MeshFormat::ply, "sphere.ply");
    CHECK(back.triangles == mesh.triangles);
    CHECK(back.colours == mesh.colours);
    for (int v = 0; v < mesh.n_vertices(); ++v)
        CHECK(back.vertices[v] == mesh.vertices[v].cast<float>().cast<double>());
}

TEST_CASE("PLY: the header declares positions, normals and colours, and the body has them in this order") {
    const Mesh mesh = coloured_sphere();
    const std::vector<std::byte> file = encode_mesh_file(mesh, MeshFormat::ply);
    const std::string text(reinterpret_cast<const char*>(file.data()), file.size());
    CHECK(
        text.find("property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty uchar red\n") !=
        std::string::npos);
    const std::size_t body = text.find("end_header\n") + 11;
    REQUIRE(file.size() == body + 27 * mesh.vertices.size() + 13 * mesh.triangles.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        Eigen::Vector3f n;
        std::memcpy(n.data(), file.data() + body + 27 * v + 12, sizeof n);
        CHECK(n.norm() == doctest::Approx(1).epsilon(1e-6));
        CHECK(n.dot(mesh.vertices[v].normalized().cast<float>()) > 0.99F);
    }
}

TEST_CASE("PLY: far from the origin positions are doubles and come back unchanged") {
    const Mesh mesh = shapes::translated(icosphere(1, 0.7), {4.5e6, 5.1e5, -120});
    const Mesh back = decode_mesh_file(encode_mesh_file(mesh, MeshFormat::ply), MeshFormat::ply, "far.ply");
    CHECK(back.vertices == mesh.vertices);
}

TEST_CASE("PLY: every truncation and every trailing byte is rejected") {
    const std::vector<std::byte> file = encode_mesh_file(coloured_sphere(), MeshFormat::ply);
    for (std::size_t n = 0; n < file.size(); ++n) {
        const std::vector<std::byte> cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(n));
        CHECK_THROWS_AS(decode_mesh_file(cut, MeshFormat::ply, "cut.ply"), InputError);
    }
    std::vector<std::byte> longer = file;
    longer.push_back(std::byte{});
    CHECK_THROWS_AS(decode_mesh_file(longer, MeshFormat::ply, "longer.ply"), InputError);
}

TEST_CASE("PLY: polygons of a text file become fans, unknown elements and properties are skipped") {
    const Mesh mesh = decode(
        "ply\r\nformat ascii 1.0\r\nelement vertex 5\r\nproperty double x\r\nproperty double y\r\nproperty double "
        "z\r\nproperty float quality\r\nproperty list uchar int neighbours\r\nelement material 1\r\nproperty int "
        "id\r\nelement face 2\r\nproperty uchar flag\r\nproperty list uchar int vertex_index\r\nend_header\r\n"
        "0 0 0 1 0\r\n1 0 0 1 2 4 4\r\n1 1 0 1 0\r\n0 1 0 1 0\r\n0.5 0.5 1e0 +1 0\r\n7\r\n1 4 0 1 2 3\r\n1 3 0 1 4",
        MeshFormat::ply);
    CHECK(mesh.n_vertices() == 5);
    CHECK(mesh.vertices[4] == Vec3(0.5, 0.5, 1));
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 4}});
    CHECK(mesh.colours.empty());
}

TEST_CASE("PLY: both byte orders give the same mesh") {
    const Mesh mesh = coloured_sphere();
    const std::vector<std::byte> little = encode_mesh_file(mesh, MeshFormat::ply);
    std::string text(reinterpret_cast<const char*>(little.data()), little.size());
    std::size_t at = text.find("end_header\n") + 11;
    for (int v = 0; v < mesh.n_vertices(); ++v, at += 27)
        for (int i = 0; i < 6; ++i) std::reverse(text.begin() + at + 4 * i, text.begin() + at + 4 * i + 4);
    for (int f = 0; f < mesh.n_faces(); ++f, at += 13)
        for (int i = 0; i < 3; ++i) std::reverse(text.begin() + at + 1 + 4 * i, text.begin() + at + 5 + 4 * i);
    text.replace(text.find("little"), 6, "big");
    const Mesh back = decode(text, MeshFormat::ply);
    CHECK(back.triangles == mesh.triangles);
    CHECK(back.colours == mesh.colours);
    CHECK(back.vertices[5] == mesh.vertices[5].cast<float>().cast<double>());
}

TEST_CASE("PLY: counts that the bytes cannot hold are refused before memory is taken") {
    for (const char* count : {"4000000000", "18446744073709551615", "99999999999999999999999", "-1"}) {
        CHECK_THROWS_AS(decode(ply_header("binary_little_endian", count, "0"), MeshFormat::ply), InputError);
        CHECK_THROWS_AS(decode(ply_header("binary_little_endian", "0", count), MeshFormat::ply), InputError);
        CHECK_THROWS_AS(decode(ply_header("ascii", count, "0") + "1 2 3\n", MeshFormat::ply), InputError);
    }
    CHECK_THROWS_AS(
        decode("ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float "
               "z\nelement ghost 18446744073709551615\nend_header\n",
               MeshFormat::ply),
        InputError);
}

TEST_CASE("PLY: what is no mesh is refused with a sentence") {
    const auto refuses = [](const std::string& text) { CHECK_THROWS_AS(decode(text, MeshFormat::ply), InputError); };
    refuses("");
    refuses("plywood\n");
    refuses("ply\nformat xml 1.0\nend_header\n");
    refuses("ply\nproperty float x\n");
    refuses("ply\nformat ascii 1.0\nend_header\n");
    refuses("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n");
    refuses("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\nend_header\n1 2\n");
    std::string many_properties = "ply\nformat ascii 1.0\nelement vertex 0\n";
    for (int i = 0; i < 1000; ++i) many_properties += "property float p" + std::to_string(i) + "\n";
    refuses(many_properties + "end_header\n");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 nan 1 0 3 0 1 2");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 inf 1 0 3 0 1 2");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 0 1 0 3 0 1 3");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 0 1 0 3 0 1 -2");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 0 1 0 3 0 1 1.5");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 0 1 0 2 0 1");
    refuses(ply_header("ascii", "3", "1") + "0 0 0 1 0 0 0 one 0 3 0 1 2");
}

TEST_CASE("OBJ: positions, triangles and colours come back unchanged") {
    const Mesh mesh = coloured_sphere();
    const Mesh back = decode_mesh_file(encode_mesh_file(mesh, MeshFormat::obj), MeshFormat::obj, "sphere.obj");
    CHECK(back.vertices == mesh.vertices);
    CHECK(back.triangles == mesh.triangles);
    CHECK(back.colours == mesh.colours);
}

TEST_CASE("OBJ: polygons, all spellings of a corner, numbers from the end, and lines of other kinds") {
    const Mesh mesh = decode(
        "# a comment\nmtllib some.mtl\nv 0 0 0\nv 1 0 0 1.0\r\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\n"
        "f 1/1/1 2//1 3/1 4\nf -4 -3 -1",
        MeshFormat::obj);
    CHECK(mesh.vertices.size() == 4);
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}});
    CHECK(mesh.colours.empty());
}

TEST_CASE("OBJ: what is no mesh is refused with the line it stands on") {
    for (const char* text : {"v 0 0\n", "v 0 0 x\n", "v 0 0 inf\n", "v 0 0 0\nf 1 1\n", "v 0 0 0\nf 1 1 2\n",
                             "v 0 0 0\nf 0 1 1\n", "v 0 0 0\nf -2 1 1\n", "v 0 0 0\nf 1 1 99999999999\n"})
        CHECK_THROWS_AS(decode(text, MeshFormat::obj), InputError);
    CHECK_THROWS_WITH_AS(decode("v 0 0 0\nf 1 a 1\n", MeshFormat::obj), "test:2: expected a vertex number, got \"a\"",
                         InputError);
}

TEST_CASE("OBJ: every vertex has a unit normal, and corners name both") {
    const Mesh mesh = shapes::tetrahedron();
    const std::vector<std::byte> file = encode_mesh_file(mesh, MeshFormat::obj);
    std::istringstream lines(std::string(reinterpret_cast<const char*>(file.data()), file.size()));
    int n_normals = 0, n_faces = 0;
    for (std::string line; std::getline(lines, line);) {
        Vec3 n;
        if (std::sscanf(line.c_str(), "vn %lf %lf %lf", &n[0], &n[1], &n[2]) == 3) {
            CHECK(n.norm() == doctest::Approx(1).epsilon(1e-3));
            ++n_normals;
        }
        Triangle v, t;
        if (std::sscanf(line.c_str(), "f %d//%d %d//%d %d//%d", &v[0], &t[0], &v[1], &t[1], &v[2], &t[2]) == 6) {
            CHECK(v == t);
            ++n_faces;
        }
    }
    CHECK(n_normals == 4);
    CHECK(n_faces == 4);
}

TEST_CASE("Mesh files: where faces have no area, or one beyond all numbers, the normal is +z") {
    Mesh mesh = shapes::tetrahedron();
    for (const double size : {0.0, 1e-200, 1e200}) {
        Mesh scaled = mesh;
        for (Vec3& v : scaled.vertices) v *= size;
        for (const Eigen::Vector3f& n : file_normals(scaled)) CHECK(n.norm() == doctest::Approx(1).epsilon(1e-6));
    }
    mesh.vertices.emplace_back(9, 9, 9);  // of no face
    CHECK(file_normals(mesh)[4] == Eigen::Vector3f::UnitZ());
    const Glb glb = parse_glb(encode_mesh_file(mesh, MeshFormat::glb));
    const int normal = glb.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"];
    CHECK(glb.number<float>(normal, 3 * 4 + 2) == 1);
}

TEST_CASE("GLB: accessors describe the mesh, bounds are exact, normals are radial on a sphere") {
    const Mesh mesh = coloured_sphere();
    const Glb glb = parse_glb(encode_mesh_file(mesh, MeshFormat::glb));
    const auto& primitive = glb.json["meshes"][0]["primitives"][0];
    const int position = primitive["attributes"]["POSITION"], normal = primitive["attributes"]["NORMAL"];
    const int indices = primitive["indices"];
    CHECK(glb.json["buffers"][0]["byteLength"] == glb.bin.size());
    CHECK(glb.json["accessors"][position]["count"] == mesh.n_vertices());
    CHECK(glb.json["accessors"][indices]["count"] == 3 * mesh.n_faces());
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = -low;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        Eigen::Vector3f p, n;
        for (std::size_t i = 0; i < 3; ++i) {
            p[i] = glb.number<float>(position, 3 * v + i);
            n[i] = glb.number<float>(normal, 3 * v + i);
        }
        CHECK(p == mesh.vertices[v].cast<float>());
        CHECK(n.norm() == doctest::Approx(1).epsilon(1e-6));
        CHECK(n.dot(p.normalized()) > 0.99F);
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    for (int i = 0; i < 3; ++i) {
        CHECK(glb.json["accessors"][position]["min"][i].get<double>() == low[i]);
        CHECK(glb.json["accessors"][position]["max"][i].get<double>() == high[i]);
    }
    for (std::size_t i = 0; i < 3 * mesh.triangles.size(); ++i)
        CHECK(glb.number<std::uint32_t>(indices, i) == mesh.triangles[i / 3][i % 3]);
    for (const auto& view : glb.json["bufferViews"]) CHECK(view["byteOffset"].get<int>() % 4 == 0);
}

TEST_CASE("GLB: colours are linear light, black and white stay what they are") {
    Mesh mesh = shapes::tetrahedron();
    mesh.colours = {{0, 0, 0}, {255, 255, 255}, {188, 188, 188}, {1, 0, 0}};
    const Glb glb = parse_glb(encode_mesh_file(mesh, MeshFormat::glb));
    const int colour = glb.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"];
    CHECK(glb.json["accessors"][colour]["normalized"] == true);
    const auto red = [&](std::size_t v) { return glb.number<std::uint16_t>(colour, 4 * v) / 65535.0; };
    CHECK(red(0) == 0);
    CHECK(red(1) == 1);
    CHECK(red(2) == doctest::Approx(0.5).epsilon(0.01));
    CHECK(red(3) == doctest::Approx(1 / 255.0 / 12.92).epsilon(0.05));
    CHECK(glb.number<std::uint16_t>(colour, 3) == 65535);
}

TEST_CASE("GLB: far from the origin the node carries the place") {
    const Vec3 far(4.5e6, 5.1e5, -120);
    const Mesh mesh = shapes::translated(icosphere(1, 0.7), far);
    const Glb glb = parse_glb(encode_mesh_file(mesh, MeshFormat::glb));
    const int position = glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    for (std::size_t i = 0; i < 3; ++i) {
        const double x = glb.json["nodes"][0]["translation"][i].get<double>() + glb.number<float>(position, i);
        CHECK(x == doctest::Approx(mesh.vertices[0][static_cast<int>(i)]).epsilon(1e-12));
    }
}

TEST_CASE("GLB: a mesh without triangles is an empty scene, and reading is refused") {
    CHECK(parse_glb(encode_mesh_file(Mesh{}, MeshFormat::glb)).json["asset"]["version"] == "2.0");
    CHECK_THROWS_AS(decode_mesh_file({}, MeshFormat::glb, "a.glb"), InputError);
}

TEST_CASE("Mesh files: the extension chooses the format, in either case") {
    CHECK(mesh_format("a/b.PLY") == MeshFormat::ply);
    CHECK(mesh_format("b.obj") == MeshFormat::obj);
    CHECK(mesh_format("b.glb") == MeshFormat::glb);
    CHECK_THROWS_AS(mesh_format("b.stl"), InputError);
}

TEST_CASE("Mesh files: written and read back, and a missing one is an IoError") {
    const auto folder = std::filesystem::temp_directory_path() / "anyrate_mesh_io_test";
    std::filesystem::create_directories(folder);
    const Mesh mesh = coloured_sphere();
    write_mesh(mesh, folder / "sphere.ply");
    CHECK(read_mesh(folder / "sphere.ply").triangles == mesh.triangles);
    CHECK_THROWS_AS(read_mesh(folder / "missing.ply"), IoError);
    CHECK_THROWS_AS(write_mesh(mesh, folder / "missing" / "sphere.ply"), IoError);
    std::filesystem::remove_all(folder);
}
