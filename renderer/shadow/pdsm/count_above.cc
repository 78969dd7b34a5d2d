#include "renderer/shadow/pdsm/count_above.h"

// Compiled once for each instruction set; the best that the machine has is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer/shadow/pdsm/count_above.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace halfshade::pdsm::HWY_NAMESPACE {

void CountAbove(const uint8_t* values, uint8_t level, size_t count, uint8_t* counts) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<uint8_t, kCountPadding> d;
  const auto levels = hn::Set(d, level);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto is_above = hn::VecFromMask(d, hn::Gt(hn::LoadU(d, values + i), levels));
    hn::StoreU(hn::Sub(hn::LoadU(d, counts + i), is_above), d, counts + i);  // a true lane is -1
  }
}

}  // namespace halfshade::pdsm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace halfshade::pdsm {

HWY_EXPORT(CountAbove);

void CountAbove(const uint8_t* values, uint8_t level, size_t count, uint8_t* counts) {
  HWY_DYNAMIC_DISPATCH(CountAbove)(values, level, count, counts);
}

}  // namespace halfshade::pdsm
#endif
