#include "server/jobs/preview_sink.h"

#include <utility>

#include "core/error.h"
#include "proto/header.h"

namespace anyrate {

PreviewSink::PreviewSink(std::uint64_t log_id, LogAppender& file,
                         std::function<void(std::uint32_t n_vertices, std::uint64_t n_bytes)> on_complete)
    : log_id_(log_id),
      file_(file),
      on_complete_(std::move(on_complete)),
      writer_(log_id, [this](std::span<const std::byte> bytes) { file_.append(bytes); }) {}

BaseMesh PreviewSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    return writer_.start(grid, rules, base);
}

void PreviewSink::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    writer_.base_attributes(colours, distortion);
    file_.publish_index(log_id_, writer_.rows());
    const IndexRow& last = writer_.rows().back();
    on_complete_(last.n_vertices, header_size + last.end);
}

void PreviewSink::batch(std::span<const SplitRecord>, const RefinableMesh&, std::span<const Rgb8>,
                        const DistortionPoint&) {
    throw InputError("preview: expected a base and its colours, got refinements");
}

}  // namespace anyrate
