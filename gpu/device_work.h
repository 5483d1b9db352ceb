#pragma once
#include <cstdint>
#include <span>

#include "gpu/gl_buffer.h"
#include "gpu/gl_program.h"

namespace anyrate {

/// What a device was given to do, since it began.
struct DeviceWork {
    std::uint64_t n_dispatches = 0;
    std::uint64_t bytes_up = 0, bytes_down = 0;  ///< copied to the device and back, images included

    void run(const GlProgram& program, std::size_t n_x, std::size_t n_y = 1) {
        program.run(n_x, n_y);
        ++n_dispatches;
    }
    void run_indirect(const GlProgram& program, const GlBuffer& counts, std::size_t offset) {
        program.run_indirect(counts, offset);
        ++n_dispatches;
    }
    template <class T>
    void write(GlBuffer& buffer, std::span<const T> data) {
        buffer.write(data);
        bytes_up += data.size_bytes();
    }
    template <class T>
    void read(const GlBuffer& buffer, std::span<T> data) {
        buffer.read(data);
        bytes_down += data.size_bytes();
    }
};

}  // namespace anyrate
