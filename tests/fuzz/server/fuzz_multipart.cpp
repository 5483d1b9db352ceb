// multipart/form-data: the first line of an input is the Content-Type, the rest the body.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "server/http/capture_handlers.h"
#include "server/http/multipart.h"
#include "server/http/problem.h"
#include "server/jobs/capture_verdict.h"
#include "server/store/file.h"

using namespace anyrate;

namespace {

bool leads_out(const std::string& path) {
    const std::string framed = "/" + path + "/";
    return path.front() == '/' || framed.find("/../") != std::string::npos || path.find('\0') != std::string::npos;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view input(reinterpret_cast<const char*>(data), size);
    const auto line = std::min(input.find('\n'), input.size());
    const auto body = as_bytes(input.substr(std::min(line + 1, input.size())));
    try {
        for (const FormPart& part : parse_multipart(body, multipart_boundary(input.substr(0, line)))) {
            if (part.bytes.size() > body.size()) std::abort();
            const std::string path = expect_capture_path(part.filename);
            if (leads_out(path)) std::abort();
            inspect_capture_file(path, part.bytes);
        }
    } catch (const HttpProblem& problem) {
        if (problem.status != 400) std::abort();
    }
    return 0;
}
