// Sixteen lanes, whatever the machine: one vector of AVX-512, two of AVX2, four of SSE4. What is computed with them is
// the same to the bit on each: no fused multiply-adds, no approximate reciprocals. Included once per instruction set.
#include <hwy/highway.h>

#if defined(HALFSHADE_SHAFT_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef HALFSHADE_SHAFT_LANES_INL_H_
#undef HALFSHADE_SHAFT_LANES_INL_H_
#else
#define HALFSHADE_SHAFT_LANES_INL_H_
#endif

HWY_BEFORE_NAMESPACE();
namespace halfshade {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// As many as one vector holds, for what floats are too short for; and as many floats.
using DoubleTag = hn::CappedTag<double, 8>;
using FewFloatsTag = hn::Rebind<float, DoubleTag>;
using Doubles = hn::Vec<DoubleTag>;
constexpr size_t kDoubleLanes = hn::MaxLanes(DoubleTag());

using FloatTag = hn::CappedTag<float, 16>;
using WordTag = hn::Rebind<uint32_t, FloatTag>;
constexpr size_t kPartLanes = hn::MaxLanes(FloatTag());
constexpr size_t kParts = 16 / kPartLanes;

struct Floats {
  hn::Vec<FloatTag> part[kParts];
};
struct Words {
  hn::Vec<WordTag> part[kParts];
};
struct Mask {
  hn::Mask<FloatTag> part[kParts];
};

HWY_INLINE Floats Set(float value) {
  Floats result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::Set(FloatTag(), value);
  return result;
}
HWY_INLINE Words SetWords(uint32_t value) {
  Words result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::Set(WordTag(), value);
  return result;
}
// `from` is aligned to 64 bytes.
HWY_INLINE Floats Load(const float* from) {
  Floats result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::Load(FloatTag(), from + i * kPartLanes);
  return result;
}
HWY_INLINE void Store(const Floats& from, float* to) {
  for (size_t i = 0; i < kParts; ++i) hn::Store(from.part[i], FloatTag(), to + i * kPartLanes);
}
HWY_INLINE void Store(const Words& from, uint32_t* to) {
  for (size_t i = 0; i < kParts; ++i) hn::Store(from.part[i], WordTag(), to + i * kPartLanes);
}
HWY_INLINE Words LoadWords(const uint32_t* from) {
  Words result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::Load(WordTag(), from + i * kPartLanes);
  return result;
}

#define HALFSHADE_LANES(Result, Name, Operand, Expression)           \
  HWY_INLINE Result Name(const Operand& a, const Operand& b) {       \
    Result result;                                                   \
    for (size_t i = 0; i < kParts; ++i) result.part[i] = Expression; \
    return result;                                                   \
  }
HALFSHADE_LANES(Floats, operator+, Floats, hn::Add(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, operator-, Floats, hn::Sub(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, operator*, Floats, hn::Mul(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, operator/, Floats, hn::Div(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, Min, Floats, hn::Min(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, Max, Floats, hn::Max(a.part[i], b.part[i]))
HALFSHADE_LANES(Floats, CopySign, Floats, hn::CopySign(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator>, Floats, hn::Gt(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator>=, Floats, hn::Ge(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator<, Floats, hn::Lt(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator<=, Floats, hn::Le(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator==, Floats, hn::Eq(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator&, Mask, hn::And(a.part[i], b.part[i]))
HALFSHADE_LANES(Mask, operator|, Mask, hn::Or(a.part[i], b.part[i]))
HALFSHADE_LANES(Words, operator&, Words, hn::And(a.part[i], b.part[i]))
HALFSHADE_LANES(Words, operator|, Words, hn::Or(a.part[i], b.part[i]))
HALFSHADE_LANES(Words, operator^, Words, hn::Xor(a.part[i], b.part[i]))
HALFSHADE_LANES(Words, operator+, Words, hn::Add(a.part[i], b.part[i]))
HALFSHADE_LANES(Words, operator-, Words, hn::Sub(a.part[i], b.part[i]))
#undef HALFSHADE_LANES

HWY_INLINE Floats Abs(const Floats& a) {
  Floats result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::Abs(a.part[i]);
  return result;
}
HWY_INLINE Floats Select(const Mask& mask, const Floats& yes, const Floats& no) {
  Floats result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::IfThenElse(mask.part[i], yes.part[i], no.part[i]);
  return result;
}
// All bits of a lane, or none.
HWY_INLINE Words AsWords(const Mask& mask) {
  Words result;
  for (size_t i = 0; i < kParts; ++i)
    result.part[i] = hn::BitCast(WordTag(), hn::VecFromMask(FloatTag(), mask.part[i]));
  return result;
}
// All bits of the lanes whose sign bit is set.
HWY_INLINE Words SpreadSign(const Floats& a) {
  Words result;
  const hn::Rebind<int32_t, FloatTag> signed_tag;
  for (size_t i = 0; i < kParts; ++i) {
    result.part[i] = hn::BitCast(WordTag(), hn::BroadcastSignBit(hn::BitCast(signed_tag, a.part[i])));
  }
  return result;
}
HWY_INLINE Words CountOnes(const Words& a) {
  Words result;
  for (size_t i = 0; i < kParts; ++i) result.part[i] = hn::PopulationCount(a.part[i]);
  return result;
}

// A bit per lane.
HWY_INLINE uint32_t Bits(const Mask& mask) {
  uint32_t bits = 0;
  for (size_t i = 0; i < kParts; ++i) {
    uint8_t bytes[8] = {};
    hn::StoreMaskBits(FloatTag(), mask.part[i], bytes);
    bits |= (uint32_t(bytes[0]) | uint32_t(bytes[1]) << 8) << (i * kPartLanes);
  }
  return bits;
}
HWY_INLINE Mask LanesOf(uint32_t bits) {
  Mask result;
  for (size_t i = 0; i < kParts; ++i) {
    const uint32_t part = bits >> (i * kPartLanes);
    const uint8_t bytes[8] = {uint8_t(part), uint8_t(part >> 8)};
    result.part[i] = hn::LoadMaskBits(FloatTag(), bytes);
  }
  return result;
}
// A bit per lane that has any.
HWY_INLINE uint32_t LanesWithBits(const Words& a) {
  Mask none;
  for (size_t i = 0; i < kParts; ++i) {
    none.part[i] = hn::RebindMask(FloatTag(), hn::Eq(a.part[i], hn::Zero(WordTag())));
  }
  return Bits(none) ^ 0xffff;
}
HWY_INLINE bool Any(const Mask& mask) {
  for (size_t i = 0; i < kParts; ++i) {
    if (!hn::AllFalse(FloatTag(), mask.part[i])) return true;
  }
  return false;
}
HWY_INLINE bool AllOnes(const Words& a) {
  for (size_t i = 0; i < kParts; ++i) {
    if (!hn::AllTrue(WordTag(), hn::Eq(a.part[i], hn::Set(WordTag(), ~0u)))) return false;
  }
  return true;
}
HWY_INLINE float Least(const Floats& a) {
  hn::Vec<FloatTag> least = a.part[0];
  for (size_t i = 1; i < kParts; ++i) least = hn::Min(least, a.part[i]);
  return hn::GetLane(hn::MinOfLanes(FloatTag(), least));
}
HWY_INLINE float Greatest(const Floats& a) {
  hn::Vec<FloatTag> greatest = a.part[0];
  for (size_t i = 1; i < kParts; ++i) greatest = hn::Max(greatest, a.part[i]);
  return hn::GetLane(hn::MaxOfLanes(FloatTag(), greatest));
}

// Bits from the whole number nearest to t on: all where t is negative (or no number), none where it is 32 or more.
HWY_INLINE Words BitsFrom(const Floats& t) {
  Words result;
  const auto ones = hn::Set(WordTag(), ~0u);
  for (size_t i = 0; i < kParts; ++i) {
    // Beside 2^23 floats are whole numbers, and their low bits tell which: quicker than a conversion.
    const auto clamped = hn::Min(hn::Max(t.part[i], hn::Zero(FloatTag())), hn::Set(FloatTag(), 32.0f));
    const auto whole = hn::BitCast(WordTag(), hn::Add(clamped, hn::Set(FloatTag(), 8388608.0f)));
    const auto count = hn::And(whole, hn::Set(WordTag(), 63));
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
    result.part[i] = hn::Shl(ones, count);  // the shifts of AVX2 and AVX-512 leave nothing from 32 on
#else
    const auto shifted = hn::Shl(ones, hn::And(count, hn::Set(WordTag(), 31)));
    result.part[i] = hn::IfThenZeroElse(hn::Eq(count, hn::Set(WordTag(), 32)), shifted);
#endif
  }
  return result;
}

}  // namespace HWY_NAMESPACE
}  // namespace halfshade
HWY_AFTER_NAMESPACE();

#endif
