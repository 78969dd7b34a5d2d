#include "server/process_memory.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>
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

TEST(ProcessMemoryTest, WhatWasFreedGoesBackToTheSystemByItself) {
  if (!kIsPlainMemory) GTEST_SKIP() << "a sanitizer's allocator keeps what is freed";
  constexpr size_t kMuch = 200'000'000;
  const uint64_t before = ResidentBytes();
  std::vector<std::unique_ptr<char[]>> last;
  LeaveHoles(kMuch, &last);
  const auto is_back = [&] { return ResidentBytes() < before + kMuch / 10; };
  for (int i = 0; i < 300 && !is_back(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_TRUE(is_back()) << ResidentBytes() << " now, " << before << " before";
}

}  // namespace
}  // namespace halfshade
