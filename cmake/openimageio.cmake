# OpenImageIO, for the folder that includes this.
find_package(Imath CONFIG REQUIRED)
find_package(OpenImageIO REQUIRED)
# Debian's target names a folder of OpenCV's headers, which come with another package and which we don't need.
get_target_property(openimageio_includes OpenImageIO::OpenImageIO INTERFACE_INCLUDE_DIRECTORIES)
list(FILTER openimageio_includes EXCLUDE REGEX opencv)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${openimageio_includes}")
