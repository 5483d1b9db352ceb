#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/index.h"
#include "server/client/http_client.h"
#include "server/client/trace.h"

namespace anyrate {

/// A log, or a prefix of it, as it came over the network.
struct FetchedLog {
    std::vector<std::byte> bytes;
    std::vector<IndexRow> rows;  ///< of the whole log; empty if there was no index to be had
    std::uint64_t frames_begin = 0;
};

/// Gets the prefix of a log that answers a budget: header, index and base with one request of 8 KB, then exactly the
/// rest with one more (a budget that 8 KB hold needs none). Works with the log of a server's model, live or sealed, and
/// with any file server that knows Range; one that does not is read only as far as the budget needs.
/// @param target  path of the log, or of a model (/v1/models/{id})
/// @param budget  nullopt for the whole log
/// @throws InputError the server refuses (no such model), DecodeError what it has is no log, IoError
FetchedLog fetch_log(HttpClient& client, const std::string& target, const std::optional<Budget>& budget,
                     ArrivalTrace& trace);

/// The rows at such a target; nullopt if there is none. @throws DecodeError, IoError
std::optional<SideIndex> fetch_index(HttpClient& client, const std::string& index_target);

}  // namespace anyrate
