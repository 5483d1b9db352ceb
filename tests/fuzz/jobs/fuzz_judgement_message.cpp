// Any line of a process that looks through an upload; what is accepted says the same once it is encoded and decoded
// again.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/error.h"
#include "server/jobs/judgement_message.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    try {
        const JudgementMessage message = decode_judgement_message({reinterpret_cast<const char*>(data), size});
        const std::string line = encode_judgement_message(message);
        if (encode_judgement_message(decode_judgement_message(line)) != line) std::abort();
    } catch (const DecodeError&) {
    }
    return 0;
}
