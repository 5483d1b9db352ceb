#include "server/store/mapped_file.h"

#include <sys/mman.h>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {

MappedFile::MappedFile(const std::filesystem::path& file) {
    const FileHandle handle = open_if_exists(file);
    if (!handle) throw IoError("cannot open " + file.string());
    const auto size = static_cast<std::size_t>(file_size(handle));
    if (size == 0) return;  // nothing can be mapped of it
    void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, handle.get(), 0);
    if (memory == MAP_FAILED) throw IoError("cannot map " + file.string());
    bytes_ = {static_cast<const std::byte*>(memory), size};
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace anyrate
