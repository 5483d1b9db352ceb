#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "proto/index.h"
#include "server/store/log_view.h"

namespace anyrate {

/// Somebody with a later lease writes the log now.
struct LeaseLost : IoError {
    using IoError::IoError;
};

/// One writer's hold on the log of a model, under a lease. Every change is on the disk when its call returns; one that
/// fails (IoError, DiskFull) leaves the log as it was. Once a later lease was taken every change throws LeaseLost
/// and changes nothing: a writer that was given up, but runs on, can do no harm.
class LogAppender {
public:
    virtual ~LogAppender() = default;

    virtual std::vector<std::byte> read() const = 0;          ///< the live log as it stands; empty if there is none
    virtual std::optional<SideIndex> read_index() const = 0;  ///< as it was published last

    /// Forgets frames and rows; who reads them keeps them.
    virtual void begin_anew() = 0;
    /// Takes away what stands behind `n_bytes`, which no published row may reach.
    virtual void cut(std::uint64_t n_bytes) = 0;
    /// @param frames  whole ones
    virtual void append(std::span<const std::byte> frames) = 0;
    /// Shows readers the log as far as its rows go.
    virtual void publish_index(std::uint64_t log_id, std::span<const IndexRow> rows) = 0;
    /// Publishes the sealed form (seal_log). The live log stays: clients that follow it count its frames, and the
    /// sealed form has others.
    virtual void seal(std::span<const IndexRow> rows) = 0;

    /// Keeps a few bytes beside the log, for whoever writes it next; a name's later bytes replace its earlier ones.
    virtual void keep_note(const std::string& name, std::span<const std::byte> bytes) = 0;
    virtual std::optional<std::vector<std::byte>> note(const std::string& name) const = 0;
    virtual void drop_note(const std::string& name) = 0;
};

/// The logs of all models: one writer each, any number of readers. Every call may throw IoError, and InputError for
/// what is not shaped like a model id.
class LogStore {
public:
    virtual ~LogStore() = default;
    /// Takes the log of a model for a lease. @param epoch  of the lease; the greater is the later
    /// @throws LeaseLost a later lease was taken already
    virtual std::unique_ptr<LogAppender> take(const std::string& id, std::uint64_t epoch) = 0;
    /// What of the log can be read: the sealed form if it is there, else the live one; nullopt before its first frame.
    virtual std::optional<LogView> open_log(const std::string& id) const = 0;
    /// The log as live clients follow it, also once the model is sealed.
    virtual std::optional<LogView> open_live_log(const std::string& id) const = 0;
};

}  // namespace anyrate
