#include "server/cli/log_id.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

namespace anyrate {
namespace {

/// FNV-1a on words of eight bytes, each of which is folded so that its last bits count in all others: photographs of a
/// capture are tens of megabytes, of which byte by byte takes longer than the first picture can wait.
class WordHash {
public:
    template <class T>
    void add(std::span<const T> values) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
        for (std::span<const std::byte> rest = std::as_bytes(values); !rest.empty();) {
            std::uint64_t word = 0;
            const std::size_t n = std::min(rest.size(), sizeof word);
            std::memcpy(&word, rest.data(), n);
            add_word(word);
            rest = rest.subspan(n);
        }
        add_word(values.size_bytes());
    }
    template <class T>
    void add_value(const T& value) {
        add(std::span<const T>(&value, 1));
    }
    std::uint64_t value() const { return hash_; }

private:
    void add_word(std::uint64_t word) {
        hash_ = (hash_ ^ word) * 0x100000001b3u;
        hash_ ^= hash_ >> 32;
    }

    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

void add_view(WordHash& hash, const View& view) {
    hash.add(std::span<const double>(view.camera.K.data(), 9));
    hash.add(std::span<const double>(view.camera.R.data(), 9));
    hash.add(std::span<const double>(view.camera.t.data(), 3));
    hash.add_value(view.image.width);
    hash.add_value(view.image.height);
    hash.add(std::span<const Rgb8>(view.image.pixels));
    hash.add(std::span<const std::uint8_t>(view.mask.pixels));
}

}  // namespace

std::uint64_t log_id_of(const Capture& capture, const ReconstructOptions& options, std::string_view device) {
    WordHash hash;
    for (const View& view : capture.views) add_view(hash, view);
    hash.add_value(options.n_vertices);
    hash.add_value(options.n_coarse);
    hash.add_value(options.seed);
    hash.add_value(static_cast<int>(options.method));
    hash.add_value(static_cast<int>(options.sampling));
    hash.add_value(options.samples_per_px);
    hash.add(std::span<const char>(device));
    return hash.value();
}

std::uint64_t log_id_of(const Mesh& mesh, const EncodeMeshOptions& options) {
    WordHash hash;
    for (const Vec3& v : mesh.vertices) hash.add(std::span<const double>(v.data(), 3));
    for (const Triangle& t : mesh.triangles) hash.add(std::span<const std::int32_t>(t));
    hash.add(std::span<const Rgb8>(mesh.colours));
    hash.add_value(options.n_vertices);
    hash.add_value(options.n_coarse);
    return hash.value();
}

}  // namespace anyrate
