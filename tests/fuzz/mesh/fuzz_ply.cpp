// PLY: whatever the bytes, the result is a mesh that keeps Mesh's promises, or an InputError.
#include "check_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    anyrate::decode_and_check(std::as_bytes(std::span(data, size)), anyrate::MeshFormat::ply);
    return 0;
}
