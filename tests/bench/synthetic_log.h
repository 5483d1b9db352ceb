#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/index.h"

namespace anyrate::bench {

/// What fan_out does: how many clients, and what the model is like.
struct FanOutOptions {
    int n_clients = 1000, n_stalled = 0;
    int frame_bytes = 8192, frames_per_second = 20;
    double seconds = 10;
    int catch_up_mb = 0, idle_seconds = 0;
    // Of the stand-in for a worker.
    std::string worker_model;
    std::filesystem::path data;
    int parent = 0;  ///< the server, without which it ends

    int n_frames() const {
        if (catch_up_mb > 0) return (catch_up_mb << 20) / frame_bytes;
        return std::max(1, static_cast<int>(seconds * frames_per_second));
    }
};

/// The live log that the worker writes and the clients expect.
struct SyntheticLog {
    std::uint64_t id = 0x5EED;
    std::vector<std::byte> bytes;
    std::vector<IndexRow> rows;
    std::vector<std::uint64_t> frame_ends;  ///< in the file
};

/// The same for the same options. Frames are of random bytes, which a server does not look into.
SyntheticLog make_log(const FanOutOptions& options);

}  // namespace anyrate::bench
