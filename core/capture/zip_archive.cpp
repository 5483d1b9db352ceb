#include "core/capture/zip_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <locale.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "core/capture/faults.h"
#include "core/capture/relative_name.h"
#include "core/error.h"

namespace anyrate {
namespace {

struct CloseArchive {
    void operator()(archive* a) const { archive_read_free(a); }
};
using ArchivePtr = std::unique_ptr<archive, CloseArchive>;

/// A small capture's text may pack far better than any ratio worth setting; below this size the ratio says nothing.
constexpr std::int64_t ratio_free_bytes = 16 << 20;

/// libarchive converts names to the thread's locale and loses those that do not fit, and a program that never asked for
/// another runs in "C". While this lives the thread has a locale that all names fit.
class Utf8Locale {
public:
    Utf8Locale() : utf8_(newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)) {
        if (!utf8_) throw IoError("the locale C.UTF-8 is not installed");
        before_ = uselocale(utf8_);
    }
    ~Utf8Locale() {
        uselocale(before_);
        freelocale(utf8_);
    }
    Utf8Locale(const Utf8Locale&) = delete;
    Utf8Locale& operator=(const Utf8Locale&) = delete;

private:
    locale_t utf8_, before_;
};

std::string reason(archive* a) {
    const char* text = archive_error_string(a);
    return text ? text : "damaged";
}

/// A reader that starts from the central directory at the end of the file, so a zip that was cut off is refused and not
/// read as far as it goes.
ArchivePtr new_zip_reader() {
    ArchivePtr reader(archive_read_new());
    if (!reader || archive_read_support_format_zip_seekable(reader.get()) != ARCHIVE_OK)
        throw IoError("libarchive cannot read zip files here");
    return reader;
}

class Unpacker {
public:
    Unpacker(archive* reader, std::string name, std::int64_t n_packed_bytes, const ZipLimits& limits)
        : reader_(reader), name_(std::move(name)), n_packed_bytes_(n_packed_bytes), limits_(limits) {}

    void unpack(const TakeZipFile& take, const WantZipFile& wanted) {
        std::set<std::string> seen;
        std::int64_t n_entries = 0;
        while (archive_entry* entry = next_entry()) {
            if (++n_entries > limits_.max_files)
                throw_fault(name_,
                            "more than " + std::to_string(limits_.max_files) + " entries, the most a capture may have");
            if (archive_entry_filetype(entry) == AE_IFDIR) continue;  // nothing is written: its name does no harm
            const std::string file = checked_name(entry);
            check_kind(entry, file);
            if (!seen.insert(file).second) throw_fault(name_, "holds " + file + " twice; expected every file once");
            if (wanted && !wanted(file)) continue;
            check_promise(entry);
            take(file, read_data(file));
        }
    }

private:
    archive_entry* next_entry() {
        archive_entry* entry = nullptr;
        const int status = archive_read_next_header(reader_, &entry);
        if (status == ARCHIVE_EOF) return nullptr;
        // A warning is about a name that is not UTF-8, or a date: no matter.
        if (status != ARCHIVE_OK && status != ARCHIVE_WARN)
            throw_fault(name_, "not a readable zip file (" + reason(reader_) + "); expected a complete one");
        return entry;
    }

    std::string checked_name(archive_entry* entry) const {
        const char* raw = archive_entry_pathname_utf8(entry);
        if (!raw) raw = archive_entry_pathname(entry);
        if (!raw) throw_fault(name_, "holds a file whose name cannot be read; expected UTF-8 names");
        const auto name = relative_name(raw);
        if (!name)
            throw_fault(name_, "holds \"" + std::string(raw) + "\"; expected names that stay inside the capture");
        return *name;
    }

    void check_kind(archive_entry* entry, const std::string& file) const {
        if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry) || archive_entry_symlink(entry))
            throw_fault(name_, "holds " + file + ", a link or a special file; expected plain files and folders only");
        if (archive_entry_is_encrypted(entry)) throw_fault(name_, file + " is encrypted; expected no password");
    }

    /// A bomb that says what it is need not be unpacked to be refused.
    void check_promise(archive_entry* entry) const {
        if (!archive_entry_size_is_set(entry)) return;
        check_size(n_unpacked_bytes_ + std::clamp<std::int64_t>(archive_entry_size(entry), 0, limits_.max_bytes + 1));
    }

    /// Unpacks the current entry, believing no size but that of what has come out so far.
    std::vector<std::uint8_t> read_data(const std::string& file) {
        std::vector<std::uint8_t> data;
        std::array<std::uint8_t, 1 << 16> block;
        while (true) {
            const la_ssize_t n = archive_read_data(reader_, block.data(), block.size());
            if (n < 0)
                throw_fault(name_, file + " cannot be unpacked (" + reason(reader_) + "); expected an intact zip file");
            if (n == 0) return data;
            n_unpacked_bytes_ += n;
            check_size(n_unpacked_bytes_);
            data.insert(data.end(), block.begin(), block.begin() + n);
        }
    }

    void check_size(std::int64_t n_bytes) const {
        if (n_bytes > limits_.max_bytes)
            throw_fault(name_, "unpacks to more than " + std::to_string(limits_.max_bytes) +
                                   " bytes, the most a capture may have");
        if (n_bytes > ratio_free_bytes && n_bytes / limits_.max_ratio > n_packed_bytes_)
            throw_fault(name_, "unpacks to more than " + std::to_string(limits_.max_ratio) +
                                   " times its size; expected photographs, which do not pack that well");
    }

    archive* reader_;
    std::string name_;
    std::int64_t n_packed_bytes_;
    ZipLimits limits_;
    std::int64_t n_unpacked_bytes_ = 0;
};

void unpack(archive* reader, const std::string& name, std::int64_t n_packed_bytes, const ZipLimits& limits,
            const TakeZipFile& take, const WantZipFile& wanted = {}) {
    const Utf8Locale locale;
    Unpacker(reader, name, n_packed_bytes, limits).unpack(take, wanted);
}

TakeZipFile into(ZipContents& contents) {
    return [&contents](const std::string& name, std::vector<std::uint8_t> data) {
        contents.emplace(name, std::move(data));
    };
}

}  // namespace

void visit_zip(const std::filesystem::path& file, const std::string& name, const ZipLimits& limits,
               const TakeZipFile& take, const WantZipFile& wanted) {
    std::error_code error;
    const auto n_bytes = std::filesystem::file_size(file, error);
    if (error || !std::ifstream(file)) throw IoError(file.string() + ": cannot be opened for reading");
    const ArchivePtr reader = new_zip_reader();
    if (archive_read_open_filename(reader.get(), file.c_str(), 1 << 16) != ARCHIVE_OK)
        throw_fault(name, "not a zip file (" + reason(reader.get()) + "); expected a folder or a zip file");
    unpack(reader.get(), name, static_cast<std::int64_t>(n_bytes), limits, take, wanted);
}

ZipContents read_zip(const std::filesystem::path& file, const ZipLimits& limits) {
    ZipContents contents;
    visit_zip(file, file.filename().string(), limits, into(contents));
    return contents;
}

ZipContents read_zip(std::span<const std::uint8_t> bytes, const std::string& name, const ZipLimits& limits) {
    const ArchivePtr reader = new_zip_reader();
    if (archive_read_open_memory(reader.get(), bytes.data(), bytes.size()) != ARCHIVE_OK)
        throw_fault(name, "not a zip file (" + reason(reader.get()) + "); expected a folder or a zip file");
    ZipContents contents;
    unpack(reader.get(), name, static_cast<std::int64_t>(bytes.size()), limits, into(contents));
    return contents;
}

}  // namespace anyrate
