#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>

#include "core/progressive/model_sink.h"
#include "proto/log_writer.h"
#include "server/jobs/preview_sink.h"
#include "server/store/catalog.h"
#include "server/store/live_log_file.h"

namespace anyrate {

/// A model sink whose every call is durable when it returns: the frames are in the live log, the side index has their
/// rows, and after the base and after each batch the point of the rate-distortion curve has been reported. A preview
/// is a log of its own with another id, at the same place, which start() replaces.
class DurableSink final : public ModelSink {
public:
    using PointFn = std::function<void(const RatePoint&)>;
    /// @param on_point    called after the frames of the point are durable
    /// @param on_preview  likewise, for the preview, whose psi is NaN; without it no preview is taken
    DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log, PointFn on_point, PointFn on_preview = {});

    ModelSink* preview() override;
    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override;

    /// Publishes the sealed form beside the live log. @throws IoError
    void seal(const std::filesystem::path& sealed);

private:
    void publish();
    void publish_point(const DistortionPoint& distortion);
    double seconds() const;

    std::uint64_t log_id_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    LiveLogFile file_;
    std::uint64_t n_bytes_ = 0;
    std::size_t n_published_ = 0;
    PointFn on_point_, on_preview_;
    LogWriter writer_;
    std::optional<PreviewSink> preview_;
};

}  // namespace anyrate
