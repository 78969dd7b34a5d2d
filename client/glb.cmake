# GLB files from plain meshes and from OBJ.
find_package(tinyobjloader CONFIG REQUIRED)
add_library(halfshade_glb STATIC glb_writer.cc obj_to_glb.cc)
target_link_libraries(halfshade_glb PUBLIC halfshade_base PRIVATE nlohmann_json::nlohmann_json
  tinyobjloader::tinyobjloader)
