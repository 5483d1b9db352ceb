#include "server/http/file_response.h"

#include <utility>

#include "server/http/problem.h"
#include "server/http/range.h"

namespace anyrate {
namespace {

RangeAnswer wanted_range(const Request& request, const Representation& representation) {
    const auto range = request.headers.find("Range");
    if (!range || request.method != "GET") return WholeBody{};  // RFC 9110, 14.2: a range is defined for GET only
    const auto condition = request.headers.find("If-Range");
    const auto holds = [&](std::string_view tag) {
        return if_range_holds(tag, representation.etag) ||
               (representation.is_tag_of_prefix && representation.is_tag_of_prefix(tag));
    };
    if (condition && !holds(*condition)) return WholeBody{};
    return parse_range(*range, representation.bytes.n_bytes);
}

void narrow(Response& response, const FileBody& whole, const ByteRange& range) {
    response.status = 206;
    response.headers.add("Content-Range", "bytes " + std::to_string(range.begin) + "-" + std::to_string(range.end - 1) +
                                              "/" + std::to_string(whole.n_bytes));
    response.body = FileBody{whole.file, whole.begin + range.begin, range.end - range.begin, whole.memory};
}

}  // namespace

std::string cache_control(bool is_immutable) {
    return is_immutable ? "public, max-age=31536000, immutable" : "no-cache";
}

void keep_from_shared_caches(Response& response) {
    constexpr std::string_view shared = "public,";
    Headers kept;
    for (const auto& [name, value] : response.headers) {
        const bool is_shared = name == "Cache-Control" && value.starts_with(shared);
        kept.add(name, is_shared ? "private," + value.substr(shared.size()) : value);
    }
    response.headers = std::move(kept);
}

Response file_response(const Request& request, const Representation& representation) {
    Response response;
    response.headers = {{"ETag", representation.etag},
                        {"Cache-Control", cache_control(representation.is_immutable)},
                        {"Accept-Ranges", "bytes"}};
    const auto known = request.headers.find("If-None-Match");
    if (known && matches_etag(*known, representation.etag)) {
        response.status = 304;
        return response;
    }
    const RangeAnswer range = wanted_range(request, representation);
    if (std::holds_alternative<Unsatisfiable>(range)) {
        const std::string size = std::to_string(representation.bytes.n_bytes);
        throw HttpProblem(416, "the range lies outside of the " + size + " bytes",
                          {{"Content-Range", "bytes */" + size}});
    }
    response.headers.add("Content-Type", representation.content_type);
    if (const auto* part = std::get_if<ByteRange>(&range))
        narrow(response, representation.bytes, *part);
    else
        response.body = representation.bytes;
    return response;
}

}  // namespace anyrate
