// Content-Digest and Digest fields.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/http/digest.h"
#include "server/http/problem.h"

using namespace anyrate;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string field(reinterpret_cast<const char*>(data), size);
    for (const char* name : {"Content-Digest", "Digest"}) {
        Request request;
        request.headers.add(name, field);
        try {
            const auto digest = digest_of_request(request);
            // One spelling of a digest is read, and it is the one that is written.
            if (digest && field.find(to_base64(*digest)) == std::string::npos) std::abort();
        } catch (const HttpProblem& problem) {
            if (problem.status != 400) std::abort();
        }
    }
    return 0;
}
