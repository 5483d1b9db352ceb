#pragma once
#include <filesystem>

#include "server/store/sqlite.h"

namespace anyrate {

/// Makes the tables of a new catalog, or brings those of an older format up to date. The catalog's format is that of
/// the whole data directory. @throws InputError a newer version wrote `file` @throws IoError
void bring_up_to_date(SqliteDatabase& catalog, const std::filesystem::path& file);

}  // namespace anyrate
