#include "server/jobs/durable_sink.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/error.h"
#include "proto/log_reader.h"
#include "server/store/live_log_file.h"

namespace anyrate {
namespace {

std::unique_ptr<LogAppender> empty_log(const std::filesystem::path& live) {
    auto log = std::make_unique<LiveLogFile>(LogPaths{live, {}}, std::nullopt);
    log->begin_anew();
    return log;
}

/// The whole frames of `bytes`, if they are the front of a sound log with this id; else none.
std::vector<std::byte> front_of_log(std::vector<std::byte> bytes, std::uint64_t log_id) {
    try {
        const LogLayout layout = read_layout(bytes);
        bytes.resize(layout.header.log_id == log_id ? static_cast<std::size_t>(layout.whole_bytes) : 0);
        return bytes;
    } catch (const DecodeError&) {
        return {};  // empty, cut in its header, or damaged: it will be written anew
    }
}

}  // namespace

DurableSink::DurableSink(std::uint64_t log_id, const std::filesystem::path& live_log, PointFn on_point,
                         PointFn on_preview)
    : DurableSink(empty_log(live_log), log_id, std::move(on_point), std::move(on_preview)) {}

DurableSink::DurableSink(std::unique_ptr<LogAppender> log, std::uint64_t log_id, PointFn on_point, PointFn on_preview)
    : log_id_(log_id), log_(std::move(log)), on_point_(std::move(on_point)), on_preview_(std::move(on_preview)) {
    left_ = front_of_log(log_->read(), log_id_);
    if (left_.empty()) {
        log_->begin_anew();
    } else {
        log_->cut(left_.size());
        take_over();
    }
    writer_.emplace(log_id_, byte_sink());
}

DurableSink::DurableSink(std::unique_ptr<LogAppender> log, std::uint64_t log_id, const LogMark& from, PointFn on_point)
    : log_id_(log_id),
      seconds_before_(from.seconds),
      log_(std::move(log)),
      n_bytes_(from.n_bytes),
      on_point_(std::move(on_point)) {
    const std::vector<std::byte> bytes = front_of_log(log_->read(), log_id_);
    const auto index = log_->read_index();
    const std::size_t n_rows = index && index->log_id == log_id_ ? index->rows.size() : 0;
    if (bytes.size() < from.n_bytes || n_rows < from.n_rows)
        throw DecodeError("the log ends before its mark: expected " + std::to_string(from.n_bytes) + " bytes and " +
                          std::to_string(from.n_rows) + " rows, got " + std::to_string(bytes.size()) + " and " +
                          std::to_string(n_rows));
    const auto front = std::span(bytes).first(static_cast<std::size_t>(from.n_bytes));
    writer_.emplace(front, std::span(index->rows).first(from.n_rows), byte_sink());
    left_.assign(bytes.begin() + static_cast<std::ptrdiff_t>(from.n_bytes), bytes.end());
    log_->cut(bytes.size());
    take_over();
}

/// Readers may have every row that was published: no index with fewer will replace it.
void DurableSink::take_over() {
    if (const auto index = log_->read_index(); index && index->log_id == log_id_) n_published_ = index->rows.size();
}

ByteSink DurableSink::byte_sink() {
    return [this](std::span<const std::byte> bytes) { append(bytes); };
}

void DurableSink::append(std::span<const std::byte> bytes) {
    const std::size_t n_known = std::min(bytes.size(), left_.size() - n_compared_);
    if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n_known),
                    left_.begin() + static_cast<std::ptrdiff_t>(n_compared_)))
        throw LogDiverged("the log that an earlier worker left differs from byte " + std::to_string(n_bytes_) + " on");
    n_compared_ += n_known;
    if (n_known < bytes.size()) log_->append(bytes.subspan(n_known));
    n_bytes_ += bytes.size();
}

ModelSink* DurableSink::preview() {
    if (!on_preview_ || !left_.empty()) return nullptr;  // who has the log itself needs no preview of it
    const auto on_complete = [this](std::uint32_t n_vertices, std::uint64_t n_bytes) {
        on_preview_({n_vertices, n_bytes, std::numeric_limits<double>::quiet_NaN(), seconds()});
    };
    return &preview_.emplace(~log_id_, *log_, on_complete);
}

BaseMesh DurableSink::start(const Grid& grid, const RefinementRules& rules, const BaseMesh& base) {
    if (preview_) log_->begin_anew();
    BaseMesh renumbered = writer_->start(grid, rules, base);
    publish();
    return renumbered;
}

void DurableSink::base_attributes(std::span<const Rgb8> colours, const DistortionPoint& distortion) {
    writer_->base_attributes(colours, distortion);
    publish_point(distortion);
}

void DurableSink::batch(std::span<const SplitRecord> records, const RefinableMesh& state,
                        std::span<const Rgb8> new_colours, const DistortionPoint& distortion) {
    writer_->batch(records, state, new_colours, distortion);
    publish_point(distortion);
}

void DurableSink::finish() {
    writer_->finish();
    publish();
}

void DurableSink::seal() { log_->seal(writer_->rows()); }

void DurableSink::seal(const std::filesystem::path& sealed) {
    replace_file(sealed, seal_log(log_->read(), writer_->rows()));
}

LogMark DurableSink::mark() const {
    return {.n_bytes = n_bytes_,
            .n_rows = static_cast<std::uint32_t>(writer_->rows().size()),
            .seconds = seconds(),
            .is_rejected = {}};
}

void DurableSink::publish() {
    if (writer_->rows().size() <= n_published_) return;
    n_published_ = writer_->rows().size();
    log_->publish_index(log_id_, writer_->rows());
}

void DurableSink::publish_point(const DistortionPoint& distortion) {
    publish();
    on_point_({.n_vertices = writer_->rows().back().n_vertices,
               .n_bytes = n_bytes_,
               .psi = distortion.mean,
               .seconds = seconds()});
}

double DurableSink::seconds() const {
    return seconds_before_ + std::chrono::duration<double>(std::chrono::steady_clock::now() - begun_).count();
}

}  // namespace anyrate
