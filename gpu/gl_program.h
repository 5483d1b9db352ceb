#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "gpu/gl_buffer.h"

namespace anyrate {

/// A compute shader that the driver has compiled.
class GlProgram {
public:
    /// @param name     for messages
    /// @param source   GLSL behind its `#version` line
    /// @param defines  `#define` lines that go before it
    /// @throws DeviceError the driver refuses it, with what it says
    GlProgram(std::string name, std::string_view source, std::string_view defines = {});
    ~GlProgram();
    GlProgram(const GlProgram&) = delete;
    GlProgram& operator=(const GlProgram&) = delete;

    void set(std::int32_t location, std::int32_t value) const;
    void set(std::int32_t location, float value) const;
    void set(std::int32_t location, double value) const;

    /// Runs it for items 0 .. n_x - 1 in each of n_y rows, and makes what it wrote visible to what comes next.
    /// @throws DeviceError
    void run(std::size_t n_x, std::size_t n_y = 1) const;

    /// Runs as many work groups as three numbers of 32 bits in a buffer say by then. @param offset  of them, bytes
    /// @throws DeviceError
    void run_indirect(const GlBuffer& counts, std::size_t offset) const;

    /// Work groups of so many items. @throws DeviceError they are more than a dispatch takes
    std::uint32_t n_groups(std::size_t n_items) const;

    static constexpr std::size_t group_size = 64;  ///< items of a row that make a work group

private:
    std::string name_;
    std::uint32_t id_ = 0;
};

}  // namespace anyrate
