// A zip file: refused, or unpacked within its limits to names that stay inside.
#include <cstdint>
#include <cstdlib>

#include "core/capture/relative_name.h"
#include "core/capture/zip_archive.h"
#include "core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    const ZipLimits limits{.max_files = 16, .max_bytes = 1 << 16, .max_ratio = 100};
    try {
        std::size_t n_bytes = 0;
        const ZipContents contents = read_zip({data, size}, "x.zip", limits);
        for (const auto& [name, bytes] : contents) {
            if (relative_name(name) != name) std::abort();
            n_bytes += bytes.size();
        }
        if (contents.size() > 16 || n_bytes > (1 << 16)) std::abort();
    } catch (const InputError&) {  // refused
    }
    return 0;
}
