#include "client/rendezvous.h"

#include <gtest/gtest.h>

#include <map>

namespace halfshade {
namespace {

const std::vector<std::string> kServers = {"a:1", "b:1", "c:1", "d:1"};

std::string Scene(int i) { return "scenes/" + std::to_string(i); }

TEST(RendezvousTest, TheOrderOfTheListDoesNotMatter) {
  const std::vector<std::string> reversed(kServers.rbegin(), kServers.rend());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(RendezvousOrder(kServers, Scene(i)), RendezvousOrder(reversed, Scene(i)));
}

TEST(RendezvousTest, AServerThatLeavesMovesOnlyItsOwnScenesAndToTheirSecondChoice) {
  const std::vector<std::string> without_c = {"a:1", "b:1", "d:1"};
  for (int i = 0; i < 400; ++i) {
    const std::vector<std::string> before = RendezvousOrder(kServers, Scene(i));
    EXPECT_EQ(RendezvousOrder(without_c, Scene(i))[0], before[0] == "c:1" ? before[1] : before[0]);
  }
}

TEST(RendezvousTest, ScenesAreSpreadOverAllServers) {
  std::map<std::string, int> count;
  for (int i = 0; i < 4000; ++i) ++count[RendezvousOrder(kServers, Scene(i))[0]];
  // 1000 each, sigma 27: five of them.
  for (const std::string& server : kServers) EXPECT_NEAR(count[server], 1000, 137);
}

// Fixed values: a client of another build must find the same server.
TEST(RendezvousTest, TheChoiceIsTheSameInEveryBuild) {
  EXPECT_EQ(RendezvousOrder({"a:1", "b:1", "c:1"}, "scenes/0"), (std::vector<std::string>{"b:1", "a:1", "c:1"}));
}

}  // namespace
}  // namespace halfshade
