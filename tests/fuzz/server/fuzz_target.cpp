// Request targets: path and query.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "server/http/problem.h"
#include "server/http/query.h"
#include "server/http/target.h"

using namespace anyrate;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        Target target = parse_target({reinterpret_cast<const char*>(data), size});
        // What no file system may ever see.
        if (target.path.empty() || target.path.front() != '/') std::abort();
        const Request request{.path = target.path, .query = target.query};
        query_budget(request);
    } catch (const HttpProblem& problem) {
        if (problem.status < 400 || problem.status > 499) std::abort();
    }
    return 0;
}
