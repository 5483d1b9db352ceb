#pragma once
#include <cstdint>
#include <functional>
#include <span>

#include "core/progressive/model_sink.h"
#include "proto/log_writer.h"
#include "server/store/log_store.h"

namespace anyrate {

/// Writes a base with its colours as a live log of its own, in the place of the log that it precedes
/// (proto/FORMAT.md, "Forms"). Both are durable when base_attributes() returns.
class PreviewSink final : public ModelSink {
public:
    /// @param file         still empty; must outlive it
    /// @param on_complete  told the vertices and bytes of the log, once its base and colours are there
    PreviewSink(std::uint64_t log_id, LogAppender& file,
                std::function<void(std::uint32_t n_vertices, std::uint64_t n_bytes)> on_complete);

    BaseMesh start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) override;
    void base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) override;
    /// @throws InputError always: a preview is not refined
    void batch(std::span<const SplitRecord> records, const RefinableMesh& state, std::span<const Rgb8> new_colours,
               const DistortionPoint& distortion) override;
    void finish() override {}  // the log stays live until it is replaced

private:
    std::uint64_t log_id_;
    LogAppender& file_;
    std::function<void(std::uint32_t, std::uint64_t)> on_complete_;
    LogWriter writer_;
};

}  // namespace anyrate
