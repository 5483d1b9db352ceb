#pragma once
#include <cstdint>
#include <filesystem>

namespace anyrate {

struct BackUp {
    std::size_t n_models = 0;
    std::uint64_t n_bytes = 0;
};

/// Copies a data directory as it stands at one moment to a new folder, while a server may work on it: `serve --data`
/// the copy, and every model that was there at the beginning is there, the unfinished ones ready to go on; those that
/// somebody deletes meanwhile are not. Uploads that are still arriving are left out. Everything is on the disk when it
/// returns, and the folder has its name only then.
/// @throws InputError `target` is there already, or `data` is no data directory @throws IoError
BackUp back_up(const std::filesystem::path& data, const std::filesystem::path& target);

}  // namespace anyrate
