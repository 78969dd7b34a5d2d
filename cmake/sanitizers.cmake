# HALFSHADE_SANITIZE: "", "address,undefined", "thread" (the asan and tsan presets set it), or "address,undefined,fuzzer-no-link"
# (the fuzz preset; tests/fuzz).
set(HALFSHADE_SANITIZE "" CACHE STRING "Sanitizers for every target of ours")
if(HALFSHADE_SANITIZE)
  add_compile_options(-fsanitize=${HALFSHADE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${HALFSHADE_SANITIZE})
endif()
