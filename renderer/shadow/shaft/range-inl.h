// Which boxes are as far from the receivers as a level of a dense mesh is drawn at. Included once per instruction set.
#include "renderer/shadow/shaft/shaft-inl.h"

#if defined(HALFSHADE_SHAFT_RANGE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_RANGE_INL_H_
#undef HALFSHADE_SHAFT_RANGE_INL_H_
#else
#define HALFSHADE_SHAFT_RANGE_INL_H_
#endif

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

// Where a level of a dense mesh is drawn: boxes whose distance from the receivers' box is in [near, far).
struct Range {
  float low[3], high[3];  // of the receivers' box, shaft space
  float metres[3];        // of its axes
  float near_m = 0, far_m = 0;
  bool IsBounded() const { return near_m > 0 || far_m < hwy::HighestValue<float>(); }
};

// Bit per box that is not wholly nearer to the receivers' box, nor wholly further from it.
HWY_INLINE uint32_t BoxesWithin(const Boxes16& boxes, const Range& range) {
  Floats nearest = Set(0), furthest = Set(0);  // squared
  for (int axis = 0; axis < 3; ++axis) {
    const Floats below = Set(range.low[axis]) - Load(boxes.low[axis]);
    const Floats above = Load(boxes.high[axis]) - Set(range.high[axis]);
    const Floats metres = Set(range.metres[axis]);
    const Floats far = Max(Max(below, above), Set(0)) * metres;
    const Floats gap =
        Max(Max(Set(range.low[axis]) - Load(boxes.high[axis]), Load(boxes.low[axis]) - Set(range.high[axis])), Set(0)) *
        metres;
    nearest = nearest + gap * gap;
    furthest = furthest + far * far;
  }
  return Bits((nearest < Set(range.far_m * range.far_m)) & (furthest >= Set(range.near_m * range.near_m)));
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
