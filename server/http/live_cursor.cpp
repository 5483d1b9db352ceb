#include "server/http/live_cursor.h"

#include <cstdio>

#include "proto/header.h"

namespace anyrate {
std::string LiveCursor::hello(const LogView& log) {
    if (log_id_ && *log_id_ != log.log_id) {
        next_ = 0;
        end_sent_ = false;
    }
    log_id_ = log.log_id;
    header_sent_ = next_ > 0;  // who resumes has it
    char text[160];
    std::snprintf(text, sizeof text, R"({"type":"hello","log_id":"%016llx","next_sequence":%u,"sealed":%s})",
                  static_cast<unsigned long long>(log.log_id), next_, log.complete ? "true" : "false");
    return text;
}

std::size_t LiveCursor::last_row(const LogView& log) const {
    return rows_for_budget(log.rows, VertexBudget{max_vertices_}, log.frames_begin);
}

std::optional<LogRange> LiveCursor::next_message(const LogView& log, std::size_t n_bytes) {
    if (!header_sent_) {
        header_sent_ = true;
        return LogRange{0, header_size};
    }
    const std::size_t last = last_row(log);
    if (next_ < last) {
        const std::uint64_t begin = log.frames_begin + (next_ == 0 ? 0 : log.rows[next_ - 1].end);
        std::uint64_t end = begin;
        // The base is a message of its own: the first picture does not wait for what comes behind it.
        const std::size_t enough = next_ == 0 ? 1 : n_bytes;
        while (next_ < last && end - begin < enough) end = log.frames_begin + log.rows[next_++].end;
        return LogRange{begin, end};
    }
    // Behind the last row stands the end frame, which only a client with the whole log gets.
    if (log.complete && next_ == log.rows.size() && !end_sent_) {
        end_sent_ = true;
        const std::uint64_t begin = log.frames_begin + log.rows.back().end;
        if (begin < log.size) return LogRange{begin, log.size};
    }
    return std::nullopt;
}

bool LiveCursor::is_complete(const LogView& log) const {
    if (!header_sent_) return false;
    const std::size_t last = last_row(log);
    // A budget inside a growing log is met only when a later frame shows that its colours are there.
    if (last < log.rows.size()) return next_ >= last;
    return log.complete && (end_sent_ || next_ > log.rows.size());
}

}  // namespace anyrate
