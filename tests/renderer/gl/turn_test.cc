#include "renderer/gl/turn.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

namespace halfshade::gl {
namespace {

// Long enough for a thread that could go on to do so.
void LetOthersRun() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }

TEST(TurnTest, OneThreadAtATimeHasIt) {
  int inside = 0, most = 0, count = 0;  // of those who have the turn: no lock but it
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 200; ++k) {
        const Turn turn;
        most = std::max(most, ++inside);
        ++count;
        --inside;
        PassTurn();
        ++count;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(most, 1);
  EXPECT_EQ(count, 4 * 2 * 200);
}

TEST(TurnTest, WhoAskedFirstHasItFirstAndPassingGoesToTheEndOfTheLine) {
  std::string order;
  std::vector<std::thread> threads;
  {
    const Turn turn;
    for (const char name : {'a', 'b', 'c'}) {
      threads.emplace_back([&order, name] {
        const Turn own;
        order += name;
      });
      LetOthersRun();
    }
    PassTurn();
    order += 'd';
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(order, "abcd");
}

TEST(TurnTest, WhoHasItKeepsItWhereItIsAskedForOnceMore) {
  std::atomic<bool> is_other_in = false;
  std::thread other;
  {
    const Turn turn;
    { const Turn again; }
    other = std::thread([&] {
      const Turn own;
      is_other_in = true;
    });
    LetOthersRun();
    EXPECT_FALSE(is_other_in);
  }
  other.join();
  EXPECT_TRUE(is_other_in);
}

TEST(TurnTest, APauseLetsOthersIn) {
  const Turn turn;
  std::atomic<bool> is_other_in = false;
  std::thread other([&] {
    const Turn own;
    is_other_in = true;
  });
  {
    const TurnPause pause;
    other.join();  // or never
  }
  EXPECT_TRUE(is_other_in);
}

TEST(TurnTest, HardwareWaitsForNobody) {
  const Turn turn;
  std::thread hardware([] {
    const Turn own(false);
    PassTurn();
    const TurnPause pause;
  });
  hardware.join();  // or never
}

}  // namespace
}  // namespace halfshade::gl
