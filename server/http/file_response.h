#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace anyrate {

/// Bytes that may be asked for in part, and what a cache must know of them.
struct Representation {
    FileBody bytes;
    std::string content_type;
    std::string etag;           ///< strong, with its quotes
    bool is_immutable = false;  ///< the same bytes for ever under this address
    /// Whether a tag is that of these bytes when they were fewer, of a file that only grows: then ranges may still be
    /// joined to what was got under it. Empty if there is no such tag.
    std::function<bool(std::string_view etag)> is_tag_of_prefix = {};
};

/// Answers a GET or HEAD: 200, 206 with If-Range looked at, 304 by If-None-Match, 416. No byte is encoded anew.
/// @throws HttpProblem 416
Response file_response(const Request& request, const Representation& representation);

/// Nobody but the client keeps the answer: what needs a token must not come from a cache that asks for none.
void keep_from_shared_caches(Response& response);

/// The Cache-Control field of bytes that never change, or may.
std::string cache_control(bool is_immutable);

}  // namespace anyrate
