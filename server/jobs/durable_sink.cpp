#include "server/jobs/durable_sink.h"

#include <limits>
#include <utility>

namespace anyrate {

DurableSink::DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log, PointFn on_point,
                         PointFn on_preview)
    : log_id_(log_id),
      file_(live_log),
      on_point_(std::move(on_point)),
      on_preview_(std::move(on_preview)),
      writer_(log_id, [this](std::span<const std::byte> bytes) {
          file_.append(bytes);
          n_bytes_ += bytes.size();
      }) {}

ModelSink* DurableSink::preview() {
    if (!on_preview_) return nullptr;
    const auto on_complete = [this](std::uint32_t n_vertices, std::uint64_t n_bytes) {
        on_preview_({n_vertices, n_bytes, std::numeric_limits<double>::quiet_NaN(), seconds()});
    };
    return &preview_.emplace(~log_id_, file_, on_complete);
}

BaseMesh DurableSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    if (preview_) file_.begin_anew();
    BaseMesh renumbered = writer_.start(grid, rules, base);
    publish();
    return renumbered;
}

void DurableSink::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    writer_.base_attributes(colours, distortion);
    publish_point(distortion);
}

void DurableSink::batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                        std::span<const Rgb8> new_colours, const DistortionPoint& distortion) {
    writer_.batch(records, state, new_colours, distortion);
    publish_point(distortion);
}

void DurableSink::finish() {
    writer_.finish();
    publish();
}

void DurableSink::seal(const std::filesystem::path& sealed) { file_.seal(sealed, writer_.rows()); }

void DurableSink::publish() {
    if (writer_.rows().size() == n_published_) return;
    n_published_ = writer_.rows().size();
    file_.publish_index(log_id_, writer_.rows());
}

void DurableSink::publish_point(const DistortionPoint& distortion) {
    publish();
    on_point_({.n_vertices = writer_.rows().back().n_vertices,
               .n_bytes = n_bytes_,
               .psi = distortion.mean,
               .seconds = seconds()});
}

double DurableSink::seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
}

}  // namespace anyrate
