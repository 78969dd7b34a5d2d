#include "server/process_memory.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/support/process_memory.h"

namespace halfshade {
namespace {

// Of so many small blocks all but the last: what lies before it can't leave by the heap's end.
void LeaveHoles(size_t bytes, std::vector<std::unique_ptr<char[]>>* last) {
  constexpr size_t kBlock = 1000;
  std::vector<std::unique_ptr<char[]>> blocks;
  for (size_t i = 0; i < bytes / kBlock; ++i) blocks.push_back(std::make_unique<char[]>(kBlock));
  last->push_back(std::move(blocks.back()));
}

TEST(ProcessMemoryTest, WhatWasFreedGoesBackToTheSystemWhereItHasComeToBeMuch) {
  if (!kIsPlainMemory) GTEST_SKIP() << "a sanitizer's allocator keeps what is freed";
  constexpr size_t kMuch = 200'000'000;
  std::vector<std::unique_ptr<char[]>> last;
  LeaveHoles(kMuch, &last);
  const uint64_t before = ResidentBytes();
  ReturnFreedMemory();
  EXPECT_LT(ResidentBytes() + kMuch * 9 / 10, before);
}

}  // namespace
}  // namespace halfshade
