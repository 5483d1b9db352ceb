#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/store/log_view.h"

namespace anyrate {

/// The bytes of a log in its live form, read once from the disk and shared by all clients that are sent them. Grows
/// with its log: what was read is kept.
class LogBytes {
public:
    /// The bytes of `log`, of which only those are read that `before` has not. A sealed header, of a model without a
    /// live file, promises an index that a live client does not get: it is replaced by that of the live form.
    /// @param before  bytes of an earlier view, or nullptr @throws IoError
    static std::shared_ptr<const LogBytes> read(const LogView& log, const std::shared_ptr<const LogBytes>& before);

    /// Bytes begin .. end - 1 of the file as the pieces that they lie in; valid as long as this object is.
    std::vector<std::span<const std::byte>> slice(std::uint64_t begin, std::uint64_t end) const;

private:
    struct Piece {
        std::uint64_t begin = 0;
        std::shared_ptr<const std::vector<std::byte>> bytes;
    };
    std::uint64_t log_id_ = 0;
    bool sealed_ = false;
    std::uint64_t size_ = 0;
    std::vector<Piece> pieces_;  ///< one behind the other
};

}  // namespace anyrate
