#include "server/store/sqlite.h"

#include <string_view>

#include "core/error.h"
#include "server/store/file.h"

namespace anyrate {

SqliteDatabase::SqliteDatabase(const std::filesystem::path& file) {
    if (sqlite3_open(file.c_str(), &handle_) != SQLITE_OK) {
        const std::string sentence = "cannot open " + file.string() + ": " + sqlite3_errmsg(handle_);
        sqlite3_close(handle_);
        throw IoError(sentence);
    }
    sqlite3_busy_timeout(handle_, 5000);
}

void SqliteDatabase::run_script(const char* sql) {
    if (sqlite3_exec(handle_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

void SqliteDatabase::expect_in_place() const {
    int has_moved = 0;
    sqlite3_file_control(handle_, "main", SQLITE_FCNTL_HAS_MOVED, &has_moved);
    if (has_moved) throw IoError("catalog: its file was removed or replaced");
    constexpr std::string_view signature = "SQLite format 3";
    const auto begin = read_at(open_if_exists(sqlite3_db_filename(handle_, "main")), 0, signature.size());
    if (as_text(begin) != signature) throw IoError("catalog: its file does not begin as a database does");
}

void SqliteDatabase::back_up(const std::filesystem::path& file) const {
    const SqliteDatabase copy(file);
    sqlite3_backup* backup = sqlite3_backup_init(copy.handle_, "main", handle_, "main");
    if (!backup) copy.fail();
    const int copied = sqlite3_backup_step(backup, -1);
    const int finished = sqlite3_backup_finish(backup);
    if (copied != SQLITE_DONE || finished != SQLITE_OK) copy.fail();
}

void SqliteDatabase::fail() const {
    const std::string sentence = std::string("catalog: ") + sqlite3_errmsg(handle_);
    if (sqlite3_errcode(handle_) == SQLITE_FULL) throw DiskFull(sentence);
    throw IoError(sentence);
}

bool SqliteStatement::next() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) check(code);
    return false;
}

std::string SqliteStatement::text(int column) {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return {bytes ? bytes : "", static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

void SqliteStatement::bind_text(int position, const std::string& text) {
    check(sqlite3_bind_text(statement_, position, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
}

}  // namespace anyrate
