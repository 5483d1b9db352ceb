#include "server/client/zip_folder.h"

#include <archive.h>
#include <archive_entry.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;

struct FreeArchive {
    void operator()(archive* zip) const { archive_write_free(zip); }
};
using ArchiveWriter = std::unique_ptr<archive, FreeArchive>;

void expect_ok(archive* zip, int code) {
    if (code < ARCHIVE_WARN) throw IoError(std::string("cannot write the zip: ") + archive_error_string(zip));
}

fs::path temporary_path() {
    std::string name = (fs::temp_directory_path() / "anyrate-XXXXXX.zip").string();
    const FileHandle file(::mkstemps(name.data(), 4));
    if (!file) throw IoError("cannot create " + name);
    return name;
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    if (fs::is_directory(folder))
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
}

std::vector<fs::path> capture_files(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const fs::path& file : files_in(folder))
        if (file.extension() == ".json") files.push_back(file);
    for (const char* part : {"images", "masks"})
        for (const fs::path& file : files_in(folder / part)) files.push_back(file);
    std::sort(files.begin(), files.end());
    if (files.empty()) throw InputError(folder.string() + ": expected images/, masks/ and cameras.json, found none");
    return files;
}

void add_file(archive* zip, const fs::path& file, const fs::path& folder) {
    const auto bytes = read_file(file);
    const std::unique_ptr<archive_entry, decltype(&archive_entry_free)> entry(archive_entry_new(), archive_entry_free);
    archive_entry_set_pathname(entry.get(), file.lexically_relative(folder).generic_string().c_str());
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    expect_ok(zip, archive_write_header(zip, entry.get()));
    if (archive_write_data(zip, bytes.data(), bytes.size()) != static_cast<la_ssize_t>(bytes.size()))
        expect_ok(zip, ARCHIVE_FATAL);
}

}  // namespace

TemporaryZip::~TemporaryZip() {
    std::error_code ignored;  // a file left in the temporary folder harms nobody
    if (!path_.empty()) fs::remove(path_, ignored);
}

TemporaryZip zip_capture(const fs::path& folder) {
    const std::vector<fs::path> files = capture_files(folder);
    TemporaryZip result(temporary_path());
    const ArchiveWriter zip(archive_write_new());
    expect_ok(zip.get(), archive_write_set_format_zip(zip.get()));
    expect_ok(zip.get(), archive_write_set_options(zip.get(), "zip:compression=store"));
    expect_ok(zip.get(), archive_write_open_filename(zip.get(), result.path().c_str()));
    for (const fs::path& file : files) add_file(zip.get(), file, folder);
    expect_ok(zip.get(), archive_write_close(zip.get()));
    return result;
}

}  // namespace anyrate
