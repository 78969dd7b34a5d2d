#include "renderer/shadow/pdsm/sort_keys.h"

#include <hwy/contrib/sort/vqsort.h>

#include <algorithm>

namespace halfshade::pdsm {
namespace {

constexpr size_t kShort = 48;  // below it a scalar sort is quicker than the set-up of the other

}  // namespace

void SortKeys(uint32_t* keys, size_t count) {
  if (count < kShort) {
    std::sort(keys, keys + count);
    return;
  }
  thread_local hwy::Sorter sorter;
  sorter(keys, count, hwy::SortAscending());
}

}  // namespace halfshade::pdsm
