#include "gpu/gl_program.h"

#include <epoxy/gl.h>

#include <array>
#include <utility>
#include <vector>

#include "core/error.h"
#include "gpu/gl_error.h"

namespace anyrate {
namespace {

constexpr std::size_t most_groups = 65'535;  // that every OpenGL 4.5 takes in a direction

/// What a compiler or linker said, without the line ends behind it.
template <class GetLength, class GetText>
std::string log_of(GLuint id, GetLength get_length, GetText get_text) {
    GLint length = 0;
    get_length(id, GL_INFO_LOG_LENGTH, &length);
    std::vector<char> text(static_cast<std::size_t>(length) + 1, '\0');
    get_text(id, length, nullptr, text.data());
    std::string said(text.data());
    while (!said.empty() && (said.back() == '\n' || said.back() == '\r')) said.pop_back();
    return said;
}

struct Shader {
    explicit Shader(GLenum type) : id(glCreateShader(type)) {}
    ~Shader() { glDeleteShader(id); }
    Shader(const Shader&) = delete;
    Shader& operator=(const Shader&) = delete;
    GLuint id;
};

/// What a shader wrote, to whatever may read it next.
void make_visible() {
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                    GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
}

}  // namespace

GlProgram::GlProgram(std::string name, std::string_view source, std::string_view defines) : name_(std::move(name)) {
    const Shader shader(GL_COMPUTE_SHADER);
    const std::string head = "#version 450 core\n" + std::string(defines) + "\n#line 1\n";
    const std::array<const char*, 2> texts{head.c_str(), source.data()};
    const std::array<GLint, 2> lengths{static_cast<GLint>(head.size()), static_cast<GLint>(source.size())};
    glShaderSource(shader.id, 2, texts.data(), lengths.data());
    glCompileShader(shader.id);
    GLint is_fine = GL_FALSE;
    glGetShaderiv(shader.id, GL_COMPILE_STATUS, &is_fine);
    if (is_fine != GL_TRUE)
        throw DeviceError("OpenGL, compiling " + name_ + ": " + log_of(shader.id, glGetShaderiv, glGetShaderInfoLog));
    id_ = glCreateProgram();
    glAttachShader(id_, shader.id);
    glLinkProgram(id_);
    glDetachShader(id_, shader.id);
    glGetProgramiv(id_, GL_LINK_STATUS, &is_fine);
    if (is_fine == GL_TRUE) return;
    const std::string said = log_of(id_, glGetProgramiv, glGetProgramInfoLog);
    glDeleteProgram(id_);
    throw DeviceError("OpenGL, linking " + name_ + ": " + said);
}

GlProgram::~GlProgram() { glDeleteProgram(id_); }

void GlProgram::set(std::int32_t location, std::int32_t value) const { glProgramUniform1i(id_, location, value); }
void GlProgram::set(std::int32_t location, float value) const { glProgramUniform1f(id_, location, value); }
void GlProgram::set(std::int32_t location, double value) const { glProgramUniform1d(id_, location, value); }

std::uint32_t GlProgram::n_groups(std::size_t n_items) const {
    const std::size_t n = (n_items + group_size - 1) / group_size;
    if (n > most_groups)
        throw DeviceError("OpenGL, " + name_ + ": " + std::to_string(n_items) +
                          " items are more than a dispatch takes");
    return static_cast<std::uint32_t>(n);
}

void GlProgram::run(std::size_t n_x, std::size_t n_y) const {
    if (n_x == 0 || n_y == 0) return;
    if (n_y > most_groups)
        throw DeviceError("OpenGL, " + name_ + ": " + std::to_string(n_y) + " rows are more than a dispatch takes");
    glUseProgram(id_);
    glDispatchCompute(n_groups(n_x), static_cast<GLuint>(n_y), 1);
    make_visible();
    check_gl(name_);
}

void GlProgram::run_indirect(const GlBuffer& counts, std::size_t offset) const {
    glUseProgram(id_);
    counts.bind_counts();
    glDispatchComputeIndirect(static_cast<GLintptr>(offset));
    make_visible();
    check_gl(name_);
}

}  // namespace anyrate
