#include "server/jobs/durable_sink.h"

#include <utility>

namespace anyrate {

DurableSink::DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log,
                         std::function<void(const RatePoint&)> on_point)
    : log_id_(log_id),
      file_(live_log),
      on_point_(std::move(on_point)),
      writer_(log_id, [this](std::span<const std::byte> bytes) {
          file_.append(bytes);
          n_bytes_ += bytes.size();
      }) {}

BaseMesh DurableSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
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
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun_;
    on_point_({.n_vertices = writer_.rows().back().n_vertices,
               .n_bytes = n_bytes_,
               .psi = distortion.mean,
               .seconds = elapsed.count()});
}

}  // namespace anyrate
