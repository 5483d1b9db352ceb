#pragma once
// Little-endian numbers in byte strings, with every read checked against what remains.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"

namespace anyrate {

/// Appends numbers to a byte string.
class ByteWriter {
public:
    template <class T>
    requires std::is_unsigned_v<T>
    void put(T value) {
        for (std::size_t i = 0; i < sizeof(T); ++i) {
            bytes_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF));
        }
    }
    void put(float value) { put(std::bit_cast<std::uint32_t>(value)); }
    void put(double value) { put(std::bit_cast<std::uint64_t>(value)); }
    void put(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    /// Zero bytes up to a total size.
    void pad_to(std::size_t size) { bytes_.resize(size); }

    std::span<const std::byte> bytes() const { return bytes_; }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

/// Takes numbers from a byte string. `what` names the string in errors.
class ByteReader {
public:
    ByteReader(std::span<const std::byte> bytes, std::string what) : bytes_(bytes), what_(std::move(what)) {}

    /// @throws DecodeError if fewer bytes remain than T has
    template <class T>
    T take() {
        if constexpr (std::is_same_v<T, float>) {
            return std::bit_cast<float>(take<std::uint32_t>());
        } else if constexpr (std::is_same_v<T, double>) {
            return std::bit_cast<double>(take<std::uint64_t>());
        } else {
            std::uint64_t value = 0;
            const auto bytes = take_bytes(sizeof(T));
            for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
            return static_cast<T>(value);
        }
    }
    std::span<const std::byte> take_bytes(std::size_t n) {
        if (n > remaining()) {
            throw DecodeError(what_ + ": expected " + std::to_string(n) + " more bytes at offset " +
                              std::to_string(position_) + ", got " + std::to_string(remaining()));
        }
        position_ += n;
        return bytes_.subspan(position_ - n, n);
    }
    std::size_t remaining() const { return bytes_.size() - position_; }

private:
    std::span<const std::byte> bytes_;
    std::string what_;
    std::size_t position_ = 0;
};

}  // namespace anyrate
