// Requests as they come from the network, where the hot path looks at them first.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "server/http/hot_path.h"

using namespace anyrate;

namespace {

constexpr std::uint64_t log_size = 1000;

HotLogs& logs() {
    static HotLogs* hot = [] {
        auto* made = new HotLogs(1);  // so short that nothing is read
        LogView view;
        view.sealed = view.complete = true;
        view.size = log_size;
        made->keep(std::string(26, 'a'), view, "\"tag\"", made->generation());
        return made;
    }();
    return *hot;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view received(reinterpret_cast<const char*>(data), size);
    std::string header;
    const auto answer = answer_hot(received, logs(), header);
    if (!answer) return 0;
    // It ends where the request does, and names bytes that are there.
    if (answer->n_request_bytes > size) std::abort();
    if (received.substr(0, answer->n_request_bytes).find("\r\n\r\n") + 4 != answer->n_request_bytes) std::abort();
    if (answer->body.n_bytes == 0 || answer->body.begin + answer->body.n_bytes > log_size) std::abort();
    if (header.size() < 4 || header.find("\r\n\r\n") != header.size() - 4) std::abort();
    return 0;
}
