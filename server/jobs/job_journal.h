#pragma once
#include "core/reconstruction/refinement_journal.h"
#include "server/jobs/durable_sink.h"

namespace anyrate {

/// Keeps a reconstruction's checkpoint and marks beside its log, under the log's lease.
class JobJournal final : public RefinementJournal {
public:
    /// @param sink  which writes the log; must outlive it
    JobJournal(DurableSink& sink, std::uint64_t log_id) : sink_(sink), log_id_(log_id) {}

    void begin(const RefinementStart& start) override;
    void batch(std::span<const char> is_rejected) override;

private:
    DurableSink& sink_;
    std::uint64_t log_id_;
};

/// What is needed to go on with a log.
struct KeptProgress {
    Checkpoint checkpoint;
    std::optional<LogMark> mark;  ///< nullopt: from the base on
};
/// nullopt if nothing was kept, or it is damaged or of another version of this program.
std::optional<KeptProgress> kept_progress(const LogAppender& log);
/// Of a model that is finished, or begins anew.
void drop_progress(LogAppender& log);

}  // namespace anyrate
