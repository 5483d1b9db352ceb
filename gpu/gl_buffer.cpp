#include "gpu/gl_buffer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>
#include <string>

#include "core/error.h"
#include "gpu/gl_error.h"

namespace anyrate {
namespace {

std::size_t largest_block() {
    GLint64 bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    return static_cast<std::size_t>(bytes);
}

}  // namespace

GlBuffer::~GlBuffer() {
    if (id_ != 0) glDeleteBuffers(1, &id_);
}

void GlBuffer::reserve(std::size_t n_bytes) {
    if (n_bytes <= capacity_ && id_ != 0) return;
    const std::size_t most = largest_block();
    if (n_bytes > most)
        throw DeviceError("OpenGL: a shader of this device reads no more than " + std::to_string(most) +
                          " bytes of a buffer, " + std::to_string(n_bytes) + " are needed");
    if (id_ == 0) glCreateBuffers(1, &id_);
    // Half as much again, so that a surface which grows a little each time does not ask the driver each time.
    const std::size_t room = std::min(most, std::max<std::size_t>(n_bytes + n_bytes / 2, 256));
    capacity_ = 0;
    glNamedBufferData(id_, static_cast<GLsizeiptr>(room), nullptr, GL_DYNAMIC_COPY);
    check_gl("glNamedBufferData of " + std::to_string(room) + " bytes");
    capacity_ = room;
}

void GlBuffer::clear(std::size_t n_bytes) {
    assert(n_bytes % 4 == 0);
    reserve(n_bytes);
    if (n_bytes == 0) return;
    glClearNamedBufferSubData(id_, GL_R32UI, 0, static_cast<GLsizeiptr>(n_bytes), GL_RED_INTEGER, GL_UNSIGNED_INT,
                              nullptr);
    check_gl("glClearNamedBufferSubData");
}

void GlBuffer::bind(std::uint32_t index) const { glBindBufferBase(GL_SHADER_STORAGE_BUFFER, index, id_); }

void GlBuffer::bind_uniform(std::uint32_t index) const { glBindBufferBase(GL_UNIFORM_BUFFER, index, id_); }

void GlBuffer::bind_counts() const { glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, id_); }

void GlBuffer::copy_in(std::span<const std::byte> data) {
    if (data.empty()) return;
    glNamedBufferSubData(id_, 0, static_cast<GLsizeiptr>(data.size()), data.data());
    check_gl("glNamedBufferSubData");
}

void GlBuffer::copy_out(std::span<std::byte> data) const {
    assert(data.size() <= capacity_);
    if (data.empty()) return;
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(id_, 0, static_cast<GLsizeiptr>(data.size()), data.data());
    check_gl_and_reset("glGetNamedBufferSubData");
}

}  // namespace anyrate
