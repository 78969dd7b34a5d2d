#include "renderer/gl/object_cache.h"

#include <gtest/gtest.h>

namespace halfshade::gl {
namespace {

struct Sized {
  uint64_t bytes = 0;
  uint64_t SizeBytes() const { return bytes; }
};

// Keys of one character: an entry takes two bytes more than its object.
std::shared_ptr<Sized> Of(uint64_t bytes) { return std::make_shared<Sized>(Sized{bytes - 2}); }

TEST(ObjectCacheTest, TheLeastRecentlyUsedGoesFirst) {
  ObjectCache<Sized> cache(300);
  for (const char* key : {"a", "b", "c"}) cache.Keep(key, Of(100));
  EXPECT_EQ(cache.bytes(), 300u) << "all three fit exactly";
  EXPECT_NE(cache.Find("a"), nullptr);
  cache.Keep("d", Of(100));
  EXPECT_EQ(cache.Find("b"), nullptr);
  EXPECT_NE(cache.Find("a"), nullptr);
  EXPECT_NE(cache.Find("c"), nullptr);
  EXPECT_EQ(cache.bytes(), 300u);
  EXPECT_EQ(cache.hits(), 3u);
  EXPECT_EQ(cache.misses(), 1u);
}

TEST(ObjectCacheTest, OneByteOverTheBoundIsOneTooMany) {
  ObjectCache<Sized> cache(200);
  cache.Keep("a", Of(100));
  cache.Keep("b", Of(101));
  EXPECT_EQ(cache.Find("a"), nullptr);
  EXPECT_EQ(cache.bytes(), 101u);
}

TEST(ObjectCacheTest, WhatIsHeldStaysAndGoesWhenItIsLetGo) {
  ObjectCache<Sized> cache(150);
  auto held = Of(100);
  cache.Keep("a", held);
  cache.Keep("b", Of(100));
  EXPECT_EQ(cache.Find("b"), nullptr) << "of the two only b could go";
  EXPECT_EQ(cache.Find("a"), held);
  auto large = Of(1000);
  cache.Keep("c", large);
  EXPECT_EQ(cache.bytes(), 1100u) << "both in use";
  large.reset();
  cache.Trim();
  EXPECT_EQ(cache.bytes(), 100u);
  EXPECT_EQ(cache.Find("c"), nullptr) << "larger than the whole bound: never kept beyond its use";
}

TEST(ObjectCacheTest, RoomIsMadeBeforeWhatIsToFillIt) {
  ObjectCache<Sized> cache(300);
  for (const char* key : {"a", "b", "c"}) cache.Keep(key, Of(100));
  cache.MakeRoom(0);
  EXPECT_EQ(cache.bytes(), 300u);
  cache.MakeRoom(101);
  EXPECT_EQ(cache.bytes(), 100u);
  EXPECT_NE(cache.Find("c"), nullptr) << "the last used";
  const auto held = Of(100);
  cache.Keep("d", held);
  cache.MakeRoom(1000);
  EXPECT_EQ(cache.bytes(), 100u) << "all that nobody holds";
  EXPECT_EQ(cache.Find("d"), held);
}

TEST(ObjectCacheTest, KeepingAgainReplacesAndMeasuresAnew) {
  ObjectCache<Sized> cache(1000);
  auto object = Of(100);
  cache.Keep("a", object);
  object->bytes = 498;
  cache.Keep("a", object);
  EXPECT_EQ(cache.bytes(), 500u);
  cache.Keep("a", Of(10));
  EXPECT_EQ(cache.bytes(), 10u);
  EXPECT_EQ(cache.Find("a")->bytes, 8u);
}

TEST(ObjectCacheTest, ForgetsByPrefixAlone) {
  ObjectCache<Sized> cache(1000);
  for (const char* key : {"s1/a", "s1/b", "s10/a", "s2"}) cache.Keep(key, Of(100));
  cache.Forget("s1/");
  EXPECT_EQ(cache.Find("s1/a"), nullptr);
  EXPECT_EQ(cache.Find("s1/b"), nullptr);
  EXPECT_NE(cache.Find("s10/a"), nullptr);
  EXPECT_NE(cache.Find("s2"), nullptr);
  cache.Clear();
  EXPECT_EQ(cache.bytes(), 0u);
  EXPECT_EQ(cache.hits() + cache.misses(), 0u);
  EXPECT_EQ(cache.Find("s2"), nullptr);
}

}  // namespace
}  // namespace halfshade::gl
