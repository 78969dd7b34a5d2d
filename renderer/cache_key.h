// Keys of caches: the bytes of what an entry depends on.
#pragma once

#include <string>
#include <type_traits>

namespace halfshade {

template <typename... Values>
void AppendBytes(std::string* key, const Values&... values) {
  static_assert((std::is_trivially_copyable_v<Values> && ...));
  (key->append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
}

}  // namespace halfshade
