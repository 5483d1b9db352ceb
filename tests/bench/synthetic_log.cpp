#include "tests/bench/synthetic_log.h"

#include <random>

#include "proto/header.h"

namespace anyrate::bench {

SyntheticLog make_log(const FanOutOptions& options) {
    SyntheticLog log;
    Header header;
    header.log_id = log.id;
    header.grid = {.unit = 1.0, .bits = 14, .base_shift = 2};
    header.n_base_vertices = 6;
    header.n_base_faces = 8;
    log.bytes = encode_header(header);
    std::mt19937_64 random(7);
    for (int i = 0; i < options.n_frames(); ++i) {
        for (int word = 0; word < options.frame_bytes / 8; ++word) {
            const std::uint64_t bits = random();
            const auto* begin = reinterpret_cast<const std::byte*>(&bits);
            log.bytes.insert(log.bytes.end(), begin, begin + 8);
        }
        log.frame_ends.push_back(log.bytes.size());
        log.rows.push_back({.n_vertices = 6 + 3 * static_cast<std::uint32_t>(i),
                            .end = static_cast<std::uint32_t>(log.bytes.size() - header_size),
                            .mean_distortion = 1.0f / static_cast<float>(i + 1),
                            .max_distortion = 1});
    }
    return log;
}

}  // namespace anyrate::bench
