# What stands between the wire and plain values: checks, names, encodings; the file calls that server and client share.
# No threads, no sockets.
include(${PROJECT_SOURCE_DIR}/cmake/openimageio.cmake)
find_package(OpenSSL REQUIRED)
add_library(halfshade_server_edge STATIC
  digest.cc encode.cc file_operations.cc output_format.cc report_to_proto.cc samples.cc scene_name.cc status.cc validate.cc
  validate_camera.cc validate_field.cc validate_lights.cc validate_method.cc validate_node_overrides.cc
  validate_query.cc)
target_link_libraries(halfshade_server_edge PUBLIC halfshade_proto halfshade_image halfshade_math halfshade_plan
  halfshade_scene absl::strings PRIVATE Imath::Imath OpenImageIO::OpenImageIO OpenSSL::Crypto)
