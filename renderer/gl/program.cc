#include "renderer/gl/program.h"

#include <glm/gtc/type_ptr.hpp>
#include <set>
#include <sstream>

#include "renderer/status.h"

namespace halfshade::gl {
namespace {

absl::Status AppendShader(const std::string& path, std::set<std::string>& included, std::string& out) {
  const std::string* text = FindShader(path);
  if (text == nullptr) return absl::InternalError("shaders/" + path + ": there is no such shader");
  std::istringstream lines(*text);
  std::string line;
  while (std::getline(lines, line)) {
    constexpr char kInclude[] = "#include \"";
    if (!line.starts_with(kInclude)) {
      out += line + "\n";
      continue;
    }
    const size_t begin = sizeof(kInclude) - 1;
    const std::string target = line.substr(begin, line.find('"', begin) - begin);
    if (!included.insert(target).second) continue;
    if (absl::Status status = AppendShader(target, included, out); !status.ok()) {
      return absl::InternalError("shaders/" + path + ": " + std::string(status.message()));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<Handle<DeleteShader>> CompileShader(const Context& context, GLenum type, const std::string& path,
                                                   const std::string& source) {
  const GladGLContext& gl = context.gl();
  Handle<DeleteShader> shader(context, gl.CreateShader(type));
  const char* text = source.c_str();
  gl.ShaderSource(shader.id(), 1, &text, nullptr);
  gl.CompileShader(shader.id());
  GLint is_ok = GL_FALSE;
  gl.GetShaderiv(shader.id(), GL_COMPILE_STATUS, &is_ok);
  if (is_ok == GL_TRUE) return shader;
  GLint length = 0;
  gl.GetShaderiv(shader.id(), GL_INFO_LOG_LENGTH, &length);
  std::string log(std::max(length, 1), '\0');
  gl.GetShaderInfoLog(shader.id(), length, nullptr, log.data());
  return absl::InternalError("shaders/" + path + " does not compile: " + log.c_str());
}

}  // namespace

absl::StatusOr<std::string> AssembleShader(const std::string& path, const std::vector<std::string>& defines) {
  std::string source = "#version 450 core\n";
  for (const std::string& define : defines) source += "#define " + define + "\n";
  std::set<std::string> included;
  RETURN_IF_ERROR(AppendShader(path, included, source));
  return source;
}

absl::StatusOr<Program> Program::Compile(const Context& context, const std::string& vertex_path,
                                         const std::string& fragment_path, const std::vector<std::string>& defines) {
  ASSIGN_OR_RETURN(const std::string vertex_source, AssembleShader(vertex_path, defines));
  ASSIGN_OR_RETURN(const std::string fragment_source, AssembleShader(fragment_path, defines));
  return CompileSources(context, vertex_path, vertex_source, fragment_path, fragment_source);
}

absl::StatusOr<Program> Program::CompileSources(const Context& context, const std::string& vertex_path,
                                                const std::string& vertex_source, const std::string& fragment_path,
                                                const std::string& fragment_source) {
  const GladGLContext& gl = context.gl();
  ASSIGN_OR_RETURN(const auto vertex, CompileShader(context, GL_VERTEX_SHADER, vertex_path, vertex_source));
  ASSIGN_OR_RETURN(const auto fragment, CompileShader(context, GL_FRAGMENT_SHADER, fragment_path, fragment_source));
  Handle<DeleteProgram> program(context, gl.CreateProgram());
  gl.AttachShader(program.id(), vertex.id());
  gl.AttachShader(program.id(), fragment.id());
  gl.LinkProgram(program.id());
  GLint is_ok = GL_FALSE;
  gl.GetProgramiv(program.id(), GL_LINK_STATUS, &is_ok);
  if (is_ok == GL_TRUE) return Program(std::move(program));
  GLint length = 0;
  gl.GetProgramiv(program.id(), GL_INFO_LOG_LENGTH, &length);
  std::string log(std::max(length, 1), '\0');
  gl.GetProgramInfoLog(program.id(), length, nullptr, log.data());
  return absl::InternalError("shaders/" + vertex_path + " and " + fragment_path + " do not link: " + log.c_str());
}

void Program::Use() const { handle_.gl().UseProgram(handle_.id()); }

GLint Program::Location(const std::string& name) {
  const auto [entry, is_new] = locations_.try_emplace(name, -1);
  if (is_new) entry->second = handle_.gl().GetUniformLocation(handle_.id(), name.c_str());
  return entry->second;
}

void Program::Set(const std::string& name, int value) {
  handle_.gl().ProgramUniform1i(handle_.id(), Location(name), value);
}
void Program::Set(const std::string& name, float value) {
  handle_.gl().ProgramUniform1f(handle_.id(), Location(name), value);
}
void Program::Set(const std::string& name, const glm::vec2& value) {
  handle_.gl().ProgramUniform2fv(handle_.id(), Location(name), 1, glm::value_ptr(value));
}
void Program::Set(const std::string& name, const glm::vec3& value) {
  handle_.gl().ProgramUniform3fv(handle_.id(), Location(name), 1, glm::value_ptr(value));
}
void Program::Set(const std::string& name, const glm::vec4& value) {
  handle_.gl().ProgramUniform4fv(handle_.id(), Location(name), 1, glm::value_ptr(value));
}
void Program::Set(const std::string& name, const glm::mat3& value) {
  handle_.gl().ProgramUniformMatrix3fv(handle_.id(), Location(name), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::Set(const std::string& name, const glm::mat4& value) {
  handle_.gl().ProgramUniformMatrix4fv(handle_.id(), Location(name), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::Set(const std::string& name, const std::vector<glm::vec4>& values) {
  if (values.empty()) return;
  handle_.gl().ProgramUniform4fv(handle_.id(), Location(name), GLsizei(values.size()), glm::value_ptr(values[0]));
}

absl::StatusOr<Program*> ProgramCache::Get(const std::string& vertex_path, const std::string& fragment_path,
                                           const std::vector<std::string>& defines) {
  std::unique_ptr<Program>& program = programs_[{vertex_path, fragment_path, defines}];
  if (program == nullptr) {
    ASSIGN_OR_RETURN(Program compiled, Program::Compile(*context_, vertex_path, fragment_path, defines));
    program = std::make_unique<Program>(std::move(compiled));
  }
  return program.get();
}

}  // namespace halfshade::gl
