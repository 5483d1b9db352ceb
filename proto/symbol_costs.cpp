#include "proto/symbol_costs.h"

#include <cmath>
#include <cstdlib>

namespace anyrate {

namespace {

constexpr double entry_bits = 8;  ///< of a table, for each integer that occurs: about a byte

/// About what it takes beside a 0, of colour residuals.
double guess(std::int32_t symbol) { return symbol == 0 ? 0 : 0.8 + 1.7 * std::log2(1.0 + std::abs(symbol)); }

}  // namespace

SymbolCosts::SymbolCosts(std::span<const std::int32_t> symbols) {
    for (const std::int32_t symbol : symbols) ++known_[symbol];
    const auto n = static_cast<double>(symbols.size());
    for (auto& [symbol, value] : known_) value = std::log2(n / value) + entry_bits / value;
    unknown_ = std::log2(n) + entry_bits;
}

double SymbolCosts::bits(std::int32_t symbol) const {
    const auto found = known_.find(symbol);
    return found != known_.end() ? found->second : unknown_ + guess(symbol);
}

}  // namespace anyrate
