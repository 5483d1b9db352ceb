#pragma once
#include <cstdint>
#include <utility>
#include <vector>

namespace anyrate {

/// Remembers the integers that one operation overwrites, so that an operation that fails half-way leaves no trace.
/// The arrays must not be reallocated between a set() and the undo() or clear() that ends the operation.
class UndoJournal {
public:
    void set(std::int32_t& slot, std::int32_t value) {
        overwritten_.emplace_back(&slot, slot);
        slot = value;
    }
    /// Puts the old values back, newest first.
    void undo() {
        for (; !overwritten_.empty(); overwritten_.pop_back()) *overwritten_.back().first = overwritten_.back().second;
    }
    void clear() { overwritten_.clear(); }

private:
    std::vector<std::pair<std::int32_t*, std::int32_t>> overwritten_;
};

}  // namespace anyrate
