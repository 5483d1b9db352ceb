#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace anyrate {

/// Whole files by name that never change once they are there: captures and sealed logs. A name is "<model>/<file>",
/// both of a-z, 0-9, '.', '_' and '-', neither beginning with a '.'; every call with another throws InputError, and
/// every call may throw IoError.
class BlobStore {
public:
    virtual ~BlobStore() = default;
    /// Durable when it returns, and seen whole or not at all. What had the name before is replaced.
    virtual void put(const std::string& name, std::span<const std::byte> bytes) = 0;
    /// The same with a local file, which is gone afterwards.
    virtual void adopt(const std::string& name, const std::filesystem::path& file) = 0;
    virtual std::optional<std::uint64_t> size(const std::string& name) const = 0;  ///< nullopt: there is none
    /// Up to `n` bytes from an offset; fewer only where the blob ends; nullopt if there is none.
    virtual std::optional<std::vector<std::byte>> read(const std::string& name, std::uint64_t offset,
                                                       std::size_t n) const = 0;
    /// One that is not there is no error.
    virtual void remove(const std::string& name) = 0;
    /// The blobs of a model, in the order of their names.
    virtual std::vector<std::string> list(const std::string& model) const = 0;
};

/// Whether a text is a name as BlobStore takes it.
bool is_blob_name(const std::string& name);

}  // namespace anyrate
