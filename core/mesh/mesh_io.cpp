#include "core/mesh/mesh_io.h"

#include <fstream>

#include "core/error.h"
#include "core/mesh/glb.h"
#include "core/mesh/obj.h"
#include "core/mesh/ply.h"

namespace anyrate {

MeshFormat mesh_format(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (extension == ".ply") return MeshFormat::ply;
    if (extension == ".obj") return MeshFormat::obj;
    if (extension == ".glb") return MeshFormat::glb;
    throw InputError(file.string() + ": expected a file name that ends in .ply, .obj or .glb");
}

std::vector<std::byte> encode_mesh_file(const Mesh& mesh, MeshFormat format) {
    switch (format) {
        case MeshFormat::ply:
            return encode_ply(mesh);
        case MeshFormat::obj:
            return encode_obj(mesh);
        default:
            return encode_glb(mesh);
    }
}

Mesh decode_mesh_file(std::span<const std::byte> bytes, MeshFormat format, std::string_view name) {
    switch (format) {
        case MeshFormat::ply:
            return decode_ply(bytes, name);
        case MeshFormat::obj:
            return decode_obj(bytes, name);
        default:
            throw InputError(std::string(name) + ": GLB is written but not read here; expected PLY or OBJ");
    }
}

Mesh read_mesh(const std::filesystem::path& file) {
    const MeshFormat format = mesh_format(file);
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    const std::streamoff size = stream.tellg();
    if (!stream || size < 0) throw IoError(file.string() + ": cannot be opened");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(bytes.data()), size);
    if (!stream) throw IoError(file.string() + ": cannot be read");
    return decode_mesh_file(bytes, format, file.string());
}

void write_mesh(const Mesh& mesh, const std::filesystem::path& file) {
    const std::vector<std::byte> bytes = encode_mesh_file(mesh, mesh_format(file));
    std::ofstream stream(file, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) throw IoError(file.string() + ": cannot be written");
}

}  // namespace anyrate
