#include "server/store/zip_writer.h"

#include <archive.h>
#include <archive_entry.h>

#include <cerrno>

#include "core/error.h"

namespace anyrate {

struct ZipWriter::State {
    struct FreeArchive {
        void operator()(archive* open) const { archive_write_free(open); }
    };
    std::unique_ptr<archive, FreeArchive> zip{archive_write_new()};

    void expect_ok(int code) {
        if (code >= ARCHIVE_WARN) return;
        const std::string message = std::string("cannot write the zip: ") + archive_error_string(zip.get());
        const int cause = archive_errno(zip.get());
        if (cause == ENOSPC || cause == EDQUOT) throw DiskFull(message);
        throw IoError(message);
    }
};

ZipWriter::ZipWriter(const std::filesystem::path& file) : state_(std::make_unique<State>()) {
    archive* zip = state_->zip.get();
    state_->expect_ok(archive_write_set_format_zip(zip));
    state_->expect_ok(archive_write_set_options(zip, "zip:compression=store"));
    state_->expect_ok(archive_write_open_filename(zip, file.c_str()));
}

ZipWriter::~ZipWriter() = default;

void ZipWriter::add(const std::string& name, std::span<const std::byte> bytes) {
    archive* zip = state_->zip.get();
    const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(), archive_entry_free);
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    state_->expect_ok(archive_write_header(zip, entry.get()));
    if (archive_write_data(zip, bytes.data(), bytes.size()) != static_cast<la_ssize_t>(bytes.size()))
        state_->expect_ok(ARCHIVE_FATAL);
}

void ZipWriter::finish() { state_->expect_ok(archive_write_close(state_->zip.get())); }

}  // namespace anyrate
