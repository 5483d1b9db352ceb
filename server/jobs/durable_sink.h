#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/progressive/model_sink.h"
#include "proto/log_writer.h"
#include "server/jobs/checkpoint.h"
#include "server/jobs/preview_sink.h"
#include "server/store/catalog.h"
#include "server/store/log_store.h"

namespace anyrate {

/// What an earlier writer left of a log is not what this one makes again: their programs or machines compute
/// differently.
struct LogDiverged : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A model sink whose every call is durable when it returns: the frames are in the live log, the side index has their
/// rows, and after the base and after each batch the point of the rate-distortion curve has been reported. A preview
/// is a log of its own with another id, at the same place, which start() replaces.
///
/// The log may have been begun by another writer. Then frames that it left behind the place where this one takes up
/// are not written again but compared: readers keep what they have, byte for byte, or the call throws LogDiverged.
class DurableSink final : public ModelSink {
public:
    using PointFn = std::function<void(const RatePoint&)>;
    /// @param on_point    called after the frames of the point are durable
    /// @param on_preview  likewise, for the preview, whose psi is NaN; without it no preview is taken
    DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log, PointFn on_point, PointFn on_preview = {});

    /// A log under a lease, from its first frame on. What is there of a log with this id is compared.
    DurableSink(std::unique_ptr<LogAppender> log, std::uint64_t log_id, PointFn on_point, PointFn on_preview);
    /// A log under a lease, from a mark on. @throws DecodeError there is no such log, or it is not what the mark says
    DurableSink(std::unique_ptr<LogAppender> log, std::uint64_t log_id, const LogMark& from, PointFn on_point);

    ModelSink* preview() override;
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override;

    /// Publishes the sealed form. @throws IoError
    void seal();                                     ///< where the lease's log has it
    void seal(const std::filesystem::path& sealed);  ///< of a log without a lease

    LogAppender& log() { return *log_; }
    /// As every decoder has it after the last frame.
    const RefinableMesh& state() const { return writer_->state(); }
    /// How far the log is; the flags are left empty.
    LogMark mark() const;

private:
    void take_over();
    ByteSink byte_sink();
    void append(std::span<const std::byte> bytes);
    void publish();
    void publish_point(const DistortionPoint& distortion);
    double seconds() const;

    std::uint64_t log_id_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    double seconds_before_ = 0;
    std::unique_ptr<LogAppender> log_;
    std::vector<std::byte> left_;  ///< frames of the earlier writer that are still to be compared
    std::size_t n_compared_ = 0;   ///< bytes of them
    std::uint64_t n_bytes_ = 0;
    std::size_t n_published_ = 0;
    PointFn on_point_, on_preview_;
    std::optional<LogWriter> writer_;
    std::optional<PreviewSink> preview_;
};

}  // namespace anyrate
