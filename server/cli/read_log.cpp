#include "server/cli/read_log.h"

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {

std::vector<std::byte> read_log(const std::filesystem::path& file) {
    if (!std::filesystem::is_regular_file(file)) {
        throw InputError(file.string() + ": expected the log of a model (.arl), found no such file");
    }
    return read_file(file);
}

}  // namespace anyrate
