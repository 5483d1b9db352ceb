#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "core/progressive/model_sink.h"
#include "proto/log_writer.h"
#include "server/store/catalog.h"
#include "server/store/live_log_file.h"

namespace anyrate {

/// A model sink whose every call is durable when it returns: the frames are in the live log, the side index has their
/// rows, and after the base and after each batch the point of the rate-distortion curve has been reported.
class DurableSink final : public ModelSink {
public:
    /// @param on_point  called after the frames of the point are durable
    DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log,
                std::function<void(const RatePoint&)> on_point);

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

    std::uint64_t log_id_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
    LiveLogFile file_;
    std::uint64_t n_bytes_ = 0;
    std::size_t n_published_ = 0;
    std::function<void(const RatePoint&)> on_point_;
    LogWriter writer_;
};

}  // namespace anyrate
