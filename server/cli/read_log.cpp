#include "server/cli/read_log.h"

#include <array>
#include <cstdio>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

std::vector<std::byte> read_standard_input() {
    std::vector<std::byte> bytes;
    std::array<std::byte, 1 << 16> piece;
    while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), stdin)) {
        bytes.insert(bytes.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(n));
    }
    if (std::ferror(stdin)) throw IoError("the standard input cannot be read");
    return bytes;
}

}  // namespace

std::vector<std::byte> read_log(const std::filesystem::path& file) {
    if (file == "-") return read_standard_input();
    if (!std::filesystem::is_regular_file(file)) {
        const bool is_there = std::filesystem::exists(file);
        throw InputError(file.string() + ": expected the log of a model (.arl), found " +
                         (is_there ? "what is no file" : "no such file"));
    }
    return read_file(file);
}

const char* log_name(const std::filesystem::path& file) { return file == "-" ? "standard input" : file.c_str(); }

void warn_if_cut(const LogLayout& layout, std::size_t n_bytes, const std::filesystem::path& file) {
    if (layout.whole_bytes == n_bytes) return;
    std::fprintf(stderr, "%s: cut inside the frame at offset %llu; its %zu whole frames are read\n", log_name(file),
                 static_cast<unsigned long long>(layout.whole_bytes), layout.frames.size());
}

}  // namespace anyrate
