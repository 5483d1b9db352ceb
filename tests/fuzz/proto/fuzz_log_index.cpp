// Any bytes as index rows and as a side index; every budget of what is accepted has an answer.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/error.h"
#include "proto/index.h"

namespace {

void ask(std::span<const anyrate::IndexRow> rows) {
    using namespace anyrate;
    for (const Budget& budget : {Budget{VertexBudget{1000}}, Budget{ByteBudget{1000}}, Budget{DistortionBudget{10}}}) {
        if (rows_for_budget(rows, budget, 96) > rows.size()) __builtin_trap();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anyrate;
    const auto bytes = std::as_bytes(std::span(data, size));
    try {
        ask(decode_index_rows(bytes));
    } catch (const DecodeError&) {
    }
    try {
        ask(decode_index(bytes).rows);
    } catch (const DecodeError&) {
    }
    return 0;
}
