#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace anyrate {

/// Memory of the device that shaders read and write (a shader storage buffer). The context must be current wherever it
/// is used.
class GlBuffer {
public:
    GlBuffer() = default;
    ~GlBuffer();
    GlBuffer(const GlBuffer&) = delete;
    GlBuffer& operator=(const GlBuffer&) = delete;

    /// Makes room for so many bytes; what it held is lost if it has to grow.
    /// @throws DeviceError there is no such memory
    void reserve(std::size_t n_bytes);

    /// Copies to the device, from its first byte on, making room.
    template <class T>
    void write(std::span<const T> data) {
        reserve(data.size_bytes());
        copy_in(std::as_bytes(data));
    }
    /// Copies from the device, which first finishes what it was told to do. @param data  no more than was reserved
    template <class T>
    void read(std::span<T> data) const {
        copy_out(std::as_writable_bytes(data));
    }
    /// Zeros of 32 bits, as many bytes as a multiple of 4.
    void clear(std::size_t n_bytes);

    /// To what a shader declares with `binding = index`.
    void bind(std::uint32_t index) const;

    /// To the uniform block that a shader declares with `binding = index`.
    void bind_uniform(std::uint32_t index) const;

    /// To where an indirect dispatch reads its counts of work groups.
    void bind_counts() const;

    std::size_t capacity() const { return capacity_; }

private:
    void copy_in(std::span<const std::byte> data);
    void copy_out(std::span<std::byte> data) const;

    std::uint32_t id_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace anyrate
