#include "server/jobs/job_journal.h"

#include "core/error.h"

namespace anyrate {
namespace {

constexpr const char* checkpoint_note = "checkpoint";
constexpr const char* mark_note = "mark";

}  // namespace

void JobJournal::begin(const RefinementStart& start) {
    sink_.log().drop_note(mark_note);
    sink_.log().keep_note(checkpoint_note, encode_checkpoint({log_id_, start}));
}

void JobJournal::batch(std::span<const char> is_rejected) {
    LogMark mark = sink_.mark();
    mark.is_rejected.assign(is_rejected.begin(), is_rejected.end());
    sink_.log().keep_note(mark_note, encode_mark(mark));
}

std::optional<KeptProgress> kept_progress(const LogAppender& log) {
    try {
        const auto checkpoint = log.note(checkpoint_note);
        if (!checkpoint) return std::nullopt;
        KeptProgress kept{decode_checkpoint(*checkpoint), std::nullopt};
        if (const auto mark = log.note(mark_note)) kept.mark = decode_mark(*mark);
        return kept;
    } catch (const DecodeError&) {
        return std::nullopt;  // the reconstruction is made again: that costs time, but no frame
    }
}

void drop_progress(LogAppender& log) {
    log.drop_note(mark_note);
    log.drop_note(checkpoint_note);
}

}  // namespace anyrate
