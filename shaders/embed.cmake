# Writes OUT: a function that finds the text of each of FILES (relative to ROOT) by its path.
set(text "#include <map>\n#include <string>\n\nnamespace halfshade::gl {\nconst std::string* FindShader(const std::string& path);\n")
string(APPEND text "const std::string* FindShader(const std::string& path) {\n")
string(APPEND text "  static const std::map<std::string, std::string>& shaders = *new std::map<std::string, std::string>{\n")
foreach(file ${FILES})
  # Brackets and semicolons are special in CMake lists; the whole file is one quoted string here and stays intact.
  file(READ ${ROOT}/${file} source)
  string(APPEND text "    {\"${file}\", R\"GLSL(${source})GLSL\"},\n")
endforeach()
string(APPEND text "  };\n  const auto found = shaders.find(path);\n")
string(APPEND text "  return found == shaders.end() ? nullptr : &found->second;\n}\n}  // namespace halfshade::gl\n")
file(WRITE ${OUT} "${text}")
