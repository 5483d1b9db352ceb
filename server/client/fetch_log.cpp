#include "server/client/fetch_log.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

#include "core/error.h"
#include "proto/log_reader.h"
#include "server/client/log_target.h"

namespace anyrate {
namespace {

constexpr std::uint64_t first_request = 8192;
constexpr std::uint64_t no_end = std::numeric_limits<std::uint64_t>::max();

std::string range_field(std::uint64_t begin, std::uint64_t end) {
    return "bytes=" + std::to_string(begin) + "-" + (end == no_end ? "" : std::to_string(end - 1));
}

/// The size behind the slash of a Content-Range field.
std::uint64_t total_size(const std::string& content_range) {
    const auto slash = content_range.find('/');
    std::uint64_t size = no_end;
    if (slash != std::string::npos)
        std::from_chars(content_range.data() + slash + 1, content_range.data() + content_range.size(), size);
    return size;
}

/// Appends body bytes until the log has `end` bytes or the body ends.
void read_until(HttpClient& client, std::vector<std::byte>& log, std::uint64_t end, ArrivalTrace& trace) {
    constexpr std::uint64_t piece = 4 * 1024;  // small, for the trace tells when each arrived
    while (log.size() < end) {
        const auto bytes = client.read(static_cast<std::size_t>(std::min(piece, end - log.size())));
        if (bytes.empty()) return;
        log.insert(log.end(), bytes.begin(), bytes.end());
        trace.note(log.size());
    }
}

/// Index and place of the base, as far as the first bytes of a log tell.
struct Head {
    std::vector<IndexRow> rows;
    std::uint64_t frames_begin = 0;
};

std::optional<Head> head_of_sealed(const std::vector<std::byte>& log) {
    LogLayout layout = read_layout(log);
    if (!layout.header.sealed || layout.index.empty()) return std::nullopt;
    return Head{std::move(layout.index), layout.frames_begin};
}

/// One download of one log: the state between its requests.
class Download {
public:
    Download(HttpClient& client, std::string target, const std::optional<Budget>& budget, ArrivalTrace& trace)
        : client_(client), target_(std::move(target)), budget_(budget), trace_(trace) {}

    FetchedLog run() {
        open_first();
        read_until(client_, log_.bytes, first_request, trace_);
        find_rows();
        const std::uint64_t end = wanted_end();
        if (log_.bytes.size() < std::min(end, size_)) read_rest(end);
        if (end < log_.bytes.size()) log_.bytes.resize(static_cast<std::size_t>(end));
        trace_.end_requests(client_.n_received());
        if (end != no_end && log_.bytes.size() < end) throw IoError("the server sent less than its index promised");
        return std::move(log_);
    }

private:
    /// Asks for bytes begin .. end - 1 of the log, if it is still the one with this ETag.
    ClientResponse request_range(std::uint64_t begin, std::uint64_t end, const std::string& etag) {
        const std::string range = range_field(begin, end);
        ClientRequest request{.target = target_, .headers = {{"Range", range}}, .body = {}};
        if (!etag.empty()) request.headers.emplace_back("If-Range", etag);
        trace_.begin_request(target_, range, client_.n_received());
        return client_.open(request);
    }

    void open_first() {
        response_ = request_range(0, first_request, "");
        if (response_.status != 200 && response_.status != 206) throw_problem(client_, response_);
        if (response_.status == 206) size_ = total_size(response_.content_range);
    }

    void find_rows() {
        auto head = head_of_sealed(log_.bytes);
        // An index beyond 8 KB: as much again, until it is whole.
        while (!head && read_layout(log_.bytes).header.sealed && log_.bytes.size() < size_) {
            const auto before = log_.bytes.size();
            read_rest(2 * before);
            if (log_.bytes.size() == before) break;
            head = head_of_sealed(log_.bytes);
        }
        if (!head && budget_) head = head_from_side_index();
        if (!head) return;
        log_.rows = std::move(head->rows);
        log_.frames_begin = head->frames_begin;
    }

    std::optional<Head> head_from_side_index() {
        if (response_.status == 200) return std::nullopt;  // no Range, so the rest of this body is the only source
        trace_.begin_request(index_target(target_), "", client_.n_received());
        auto index = fetch_index(client_, index_target(target_));
        const LogLayout layout = read_layout(log_.bytes);
        if (!index || index->log_id != layout.header.log_id) return std::nullopt;
        return Head{std::move(index->rows), layout.frames_begin};
    }

    std::uint64_t wanted_end() const {
        if (!budget_ || log_.rows.empty()) return no_end;
        return prefix_end(log_.rows, *budget_, log_.frames_begin);
    }

    /// The same body goes on if the server knew no ranges; else one more range, if the log is still the same.
    void read_rest(std::uint64_t end) {
        if (response_.status == 206) {
            const ClientResponse rest = request_range(log_.bytes.size(), end, response_.etag);
            if (rest.status == 200) throw IoError("the log changed while it was fetched; try again");
            if (rest.status != 206) throw_problem(client_, rest);
        }
        read_until(client_, log_.bytes, end, trace_);
    }

    HttpClient& client_;
    std::string target_;
    const std::optional<Budget>& budget_;
    ArrivalTrace& trace_;
    ClientResponse response_;
    std::uint64_t size_ = no_end;
    FetchedLog log_;
};

}  // namespace

std::optional<SideIndex> fetch_index(HttpClient& client, const std::string& index_target) {
    const ClientResponse response = client.open({.target = index_target, .headers = {}, .body = {}});
    if (response.status == 404) return std::nullopt;
    if (response.status != 200) throw_problem(client, response);
    const std::string body = client.read_text();
    return decode_index({reinterpret_cast<const std::byte*>(body.data()), body.size()});
}

FetchedLog fetch_log(HttpClient& client, const std::string& target, const std::optional<Budget>& budget,
                     ArrivalTrace& trace) {
    return Download(client, log_target(target), budget, trace).run();
}

}  // namespace anyrate
