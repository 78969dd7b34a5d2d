# Warnings for our own targets; foreign headers are SYSTEM and generated code (proto, glad) is exempt.
add_library(halfshade_warnings INTERFACE)
target_compile_options(halfshade_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual
  -Wimplicit-fallthrough -Wformat=2 -Werror=unused-result -Werror=return-type)
