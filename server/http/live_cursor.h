#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "server/store/log_view.h"

namespace anyrate {

/// Bytes begin .. end - 1 of a log.
struct LogRange {
    std::uint64_t begin = 0, end = 0;
};

/// Where one live client stands in a log: decides what it is sent next. Knows no socket.
///
/// The client sees the live form of the log (open_live_log): header, base, colours, refinements, end. A frame's row
/// number in the index is its sequence number (proto/FORMAT.md, "Frame").
class LiveCursor {
public:
    LiveCursor(std::uint32_t from, std::uint32_t max_vertices) : next_(from), max_vertices_(max_vertices) {}

    void set_max_vertices(std::uint32_t max_vertices) { max_vertices_ = max_vertices; }
    std::uint32_t next_sequence() const { return next_; }
    /// The log that the client follows; nullopt before hello().
    std::optional<std::uint64_t> log_id() const { return log_id_; }

    /// The first message about a log: {"type":"hello","log_id","next_sequence","sealed"}. Starts to follow `log`, from
    /// its start if another was followed before.
    std::string hello(const LogView& log);
    /// The next message of whole frames, at least `n_bytes` long if there are as many; header and base are messages of
    /// their own, in the live form (LogBytes). nullopt if the client has all it may have of this view.
    std::optional<LogRange> next_message(const LogView& log, std::size_t n_bytes);
    /// Whether nothing will ever come any more for this budget.
    bool is_complete(const LogView& log) const;

private:
    std::size_t last_row(const LogView& log) const;

    std::uint32_t next_;
    std::uint32_t max_vertices_;
    std::optional<std::uint64_t> log_id_;
    bool header_sent_ = false, end_sent_ = false;
};

}  // namespace anyrate
