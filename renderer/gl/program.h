// Programs from the shaders that are embedded at build (shaders/), and their cache.
//
// A source gets "#version 450 core" and the defines in front; `#include "common/x.glsl"` is resolved against shaders/,
// each file once.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "renderer/gl/handles.h"

namespace halfshade::gl {

// The embedded text of shaders/<path>, or null.
const std::string* FindShader(const std::string& path);

// The source with its includes in place. INTERNAL naming the file that includes what is not there.
absl::StatusOr<std::string> AssembleShader(const std::string& path, const std::vector<std::string>& defines);

class Program {
 public:
  // INTERNAL with path and log if a shader does not compile or link.
  static absl::StatusOr<Program> Compile(const Context& context, const std::string& vertex_path,
                                         const std::string& fragment_path, const std::vector<std::string>& defines);
  // The same from assembled sources; the paths are for messages.
  static absl::StatusOr<Program> CompileSources(const Context& context, const std::string& vertex_path,
                                                const std::string& vertex_source, const std::string& fragment_path,
                                                const std::string& fragment_source);

  void Use() const;
  // Uniforms by name; a name that the program does not use is ignored, as GL does.
  void Set(const std::string& name, int value);
  void Set(const std::string& name, float value);
  void Set(const std::string& name, const glm::vec2& value);
  void Set(const std::string& name, const glm::vec3& value);
  void Set(const std::string& name, const glm::vec4& value);
  void Set(const std::string& name, const glm::mat3& value);
  void Set(const std::string& name, const glm::mat4& value);
  void Set(const std::string& name, const std::vector<glm::vec4>& values);

 private:
  explicit Program(Handle<DeleteProgram> handle) : handle_(std::move(handle)) {}
  GLint Location(const std::string& name);
  Handle<DeleteProgram> handle_;
  std::unordered_map<std::string, GLint> locations_;
};

// Programs of one context, compiled at their first use. Pointers stay valid as long as the cache lives.
class ProgramCache {
 public:
  explicit ProgramCache(const Context* context) : context_(context) {}
  absl::StatusOr<Program*> Get(const std::string& vertex_path, const std::string& fragment_path,
                               const std::vector<std::string>& defines = {});

 private:
  const Context* context_;
  std::map<std::tuple<std::string, std::string, std::vector<std::string>>, std::unique_ptr<Program>> programs_;
};

}  // namespace halfshade::gl
