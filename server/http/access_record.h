#pragma once
#include <cstdint>
#include <string>

namespace anyrate {

/// One request and its answer, for the operator.
struct AccessRecord {
    std::string request_id, client, method, path;
    int status = 0;
    std::uint64_t n_bytes = 0;  ///< of the body that was sent
    double seconds = 0;
    std::string error;  ///< what the operator should know and the client should not
};

}  // namespace anyrate
