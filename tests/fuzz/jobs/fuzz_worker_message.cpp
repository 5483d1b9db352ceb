// Any line of a worker; what is accepted says the same once it is encoded and decoded again.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/error.h"
#include "server/jobs/worker_message.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        const WorkerMessage message = decode_worker_message({reinterpret_cast<const char*>(data), size});
        const std::string line = encode_worker_message(message);
        if (encode_worker_message(decode_worker_message(line)) != line) std::abort();
    } catch (const DecodeError&) {
    }
    return 0;
}
