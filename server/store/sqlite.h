#pragma once
#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>

namespace anyrate {

/// The SQLite database of a catalog, open. What fails throws IoError, or DiskFull where the disk has no room.
class SqliteDatabase {
public:
    /// Opens `file`, or makes it; waits up to 5 s for other processes that write to it.
    explicit SqliteDatabase(const std::filesystem::path& file);
    ~SqliteDatabase() { sqlite3_close(handle_); }
    SqliteDatabase(const SqliteDatabase&) = delete;
    SqliteDatabase& operator=(const SqliteDatabase&) = delete;

    sqlite3* handle() const { return handle_; }

    /// Runs one statement to its first row. @param values  of its parameters, in their order
    template <class... Values>
    void run(const std::string& sql, const Values&... values);
    /// Runs statements that have no parameters.
    void run_script(const char* sql);
    /// All of `body` happens, or nothing. @return what it returns
    template <class Body>
    auto transaction(const Body& body);
    /// Rows that the last statement changed.
    int n_changes() const { return sqlite3_changes(handle_); }

    /// SQLite goes on with what it has in memory when the file under it is removed, replaced or overwritten; nothing of
    /// that would be there after a restart: throws then.
    void expect_in_place() const;
    /// Copies the database as it stands at one moment to a new file, while others use it.
    void back_up(const std::filesystem::path& file) const;

    /// Throws what the last call that failed says.
    [[noreturn]] void fail() const;

private:
    sqlite3* handle_ = nullptr;
};

/// One prepared statement with its values bound, stepped row by row.
class SqliteStatement {
public:
    template <class... Values>
    SqliteStatement(const SqliteDatabase& database, const std::string& sql, const Values&... values)
        : database_(database) {
        check(sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &statement_, nullptr));
        [[maybe_unused]] int position = 0;
        (bind(++position, values), ...);
    }
    ~SqliteStatement() { sqlite3_finalize(statement_); }
    SqliteStatement(const SqliteStatement&) = delete;
    SqliteStatement& operator=(const SqliteStatement&) = delete;

    /// @return whether there is another row
    bool next();
    std::int64_t integer(int column) { return sqlite3_column_int64(statement_, column); }
    double real(int column) { return sqlite3_column_double(statement_, column); }
    bool is_null(int column) { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
    std::string text(int column);

private:
    template <class Value>
    void bind(int position, const Value& value) {
        if constexpr (std::is_same_v<Value, std::nullopt_t>)
            check(sqlite3_bind_null(statement_, position));
        else if constexpr (std::is_floating_point_v<Value>)
            check(sqlite3_bind_double(statement_, position, value));
        else if constexpr (std::is_integral_v<Value>)
            check(sqlite3_bind_int64(statement_, position, static_cast<std::int64_t>(value)));
        else
            bind_text(position, value);
    }
    void bind(int position, const std::optional<double>& value) {
        if (value)
            bind(position, *value);
        else
            bind(position, std::nullopt);
    }
    void bind_text(int position, const std::string& text);
    void check(int code) const {
        if (code != SQLITE_OK) database_.fail();
    }

    const SqliteDatabase& database_;
    sqlite3_stmt* statement_ = nullptr;
};

template <class... Values>
void SqliteDatabase::run(const std::string& sql, const Values&... values) {
    SqliteStatement(*this, sql, values...).next();
}

template <class Body>
auto SqliteDatabase::transaction(const Body& body) {
    run_script("BEGIN IMMEDIATE");
    try {
        auto result = body();
        run_script("COMMIT");
        return result;
    } catch (...) {
        sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
        throw;
    }
}

}  // namespace anyrate
