# What stands between the wire and plain values: checks, names, encodings. No threads, no sockets.
find_package(OpenImageIO REQUIRED)
find_package(OpenSSL REQUIRED)
# Debian's target names a folder of OpenCV's headers, which come with another package and which we don't need.
get_target_property(openimageio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER openimageio_includes EXCLUDE REGEX opencv)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${openimageio_includes}")
add_library(halfshade_server_edge STATIC
  digest.cc encode.cc report_to_proto.cc scene_name.cc status.cc validate.cc validate_camera.cc validate_field.cc
  validate_lights.cc validate_method.cc validate_node_overrides.cc validate_query.cc)
target_link_libraries(halfshade_server_edge PUBLIC halfshade_proto halfshade_image halfshade_math halfshade_plan
  halfshade_scene absl::strings PRIVATE OpenImageIO::OpenImageIO OpenSSL::Crypto)
