#pragma once
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/http/access_record.h"
#include "server/http/bearer.h"
#include "server/http/live_feed.h"
#include "server/http/metrics.h"
#include "server/http/net.h"
#include "server/http/service.h"
#include "server/http/sessions.h"
#include "server/jobs/model_events.h"

namespace anyrate {

/// Every wait has a deadline, every body a limit.
struct HttpLimits {
    std::size_t max_connections = 10'000;
    std::size_t max_header_bytes = 16 * 1024;
    std::uint64_t max_upload_bytes = 1ull << 30;
    std::uint64_t max_small_body_bytes = 64 * 1024;  ///< of a request that takes no upload
    std::chrono::seconds header_patience =
        std::chrono::seconds(20);                                   ///< from one response to the end of the next header
    std::chrono::seconds body_patience = std::chrono::seconds(30);  ///< for each 64 KB of a body
    /// For a reader that takes less than 4 KB. Deadlines and progress are looked at four times a second: it is gone 30
    /// s after it took its last bytes at the latest.
    std::chrono::seconds write_patience = std::chrono::seconds(29);
    std::size_t live_message_bytes = 16 * 1024;  ///< frames are coalesced up to about this
    std::size_t live_queue_bytes = 256 * 1024;   ///< of a live client in the kernel
};

/// What all connections share; outlives them.
struct ServerContext {
    Service& service;
    const Router& router;
    ModelEvents& events;
    Sessions& sessions;
    LiveFeeds& live_feeds;
    Metrics& metrics;
    asio::thread_pool& quick_pool;   ///< catalog and files
    asio::thread_pool& heavy_pool;   ///< decoding of meshes
    asio::thread_pool& upload_pool;  ///< what came with a body: syncing, hashing, judging, packing
    std::size_t hot_route = 0;       ///< number of the route of logs
    HttpLimits limits;
    AccessRules access;
    std::vector<std::string> cors_origins;                ///< that browsers may ask from; "*" for any
    std::function<void(const std::string&)> log;          ///< takes a line for the operator
    std::function<void(const AccessRecord&)> log_access;  ///< takes requests; empty for none
    int log_from_status = 0;                              ///< only requests whose answer has such a status or a higher
};

}  // namespace anyrate
