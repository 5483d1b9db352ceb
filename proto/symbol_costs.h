#pragma once
#include <cstdint>
#include <map>
#include <span>

namespace anyrate {

/// What Draco spends on the integers of an attribute, whose frequencies stand in a table in front of them.
class SymbolCosts {
public:
    /// Before anything is known of the attribute: a guess.
    SymbolCosts() = default;
    /// Of an attribute of these integers; one that is not among them costs its place in the table, too.
    explicit SymbolCosts(std::span<const std::int32_t> symbols);

    /// Bits; what all integers cost alike may be left out.
    double bits(std::int32_t symbol) const;

private:
    std::map<std::int32_t, double> known_;
    double unknown_ = 0;
};

}  // namespace anyrate
