#include "server/result_cache.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace halfshade {
namespace {

ResultCache::Reply ReplyOf(size_t bytes, char fill) {
  auto reply = std::make_shared<v1::RenderResponse>();
  reply->add_images()->set_data(std::string(bytes, fill));
  return reply;
}

// What each call was told: the first byte of the reply, '!' to lead.
struct Told {
  std::vector<std::string> events;
  ResultCache::OnReply As(const std::string& name) {
    return [this, name](const ResultCache::Reply& reply) {
      events.push_back(name + (reply == nullptr ? "!" : reply->images(0).data().substr(0, 1)));
    };
  }
};
using Events = std::vector<std::string>;

TEST(ResultCacheTest, TheFirstLeadsTheOthersGetItsReplyAndSoDoLaterOnes) {
  ResultCache cache(1 << 20);
  Told told;
  EXPECT_TRUE(cache.Lead("a", 1, told.As("1")));
  EXPECT_FALSE(cache.IsAwaited("a"));
  EXPECT_FALSE(cache.Lead("a", 2, told.As("2")));
  EXPECT_FALSE(cache.Lead("a", 3, told.As("3")));
  EXPECT_TRUE(cache.Lead("b", 4, told.As("4"))) << "another request";
  EXPECT_TRUE(cache.IsAwaited("a"));
  EXPECT_EQ(told.events, Events());
  cache.Publish("a", ReplyOf(100, 'x'));
  EXPECT_EQ(told.events, Events({"2x", "3x"}));
  EXPECT_FALSE(cache.Lead("a", 5, told.As("5")));
  EXPECT_EQ(told.events, Events({"2x", "3x", "5x"}));
  EXPECT_EQ(cache.counters().hits, 3u);
  EXPECT_EQ(cache.counters().misses, 2u);
  EXPECT_GE(cache.counters().bytes, 100u);
}

TEST(ResultCacheTest, WhereTheLeaderGivesUpTheNextLeadsAndWhoWithdrewIsToldNothing) {
  ResultCache cache(1 << 20);
  Told told;
  EXPECT_TRUE(cache.Lead("a", 1, told.As("1")));
  EXPECT_FALSE(cache.Lead("a", 2, told.As("2")));
  EXPECT_FALSE(cache.Lead("a", 3, told.As("3")));
  EXPECT_FALSE(cache.Lead("a", 4, told.As("4")));
  cache.Withdraw("a", 2);
  cache.Abandon("a");
  EXPECT_EQ(told.events, Events({"3!"}));
  EXPECT_TRUE(cache.IsAwaited("a")) << "by 4";
  cache.Withdraw("a", 4);
  EXPECT_FALSE(cache.IsAwaited("a"));
  cache.Abandon("a");
  EXPECT_EQ(told.events, Events({"3!"}));
  EXPECT_TRUE(cache.Lead("a", 5, told.As("5"))) << "nobody draws it any more";
}

TEST(ResultCacheTest, KeepsWhatFitsAndDropsTheLeastRecentlyUsed) {
  ResultCache cache(1000);
  Told told;
  const auto render = [&](const std::string& key, size_t bytes) {
    if (cache.Lead(key, 1, told.As(key))) cache.Publish(key, ReplyOf(bytes, 'x'));
  };
  render("a", 400);
  render("b", 400);
  render("a", 0);
  EXPECT_EQ(told.events, Events({"ax"}));
  render("c", 400);  // drops b
  EXPECT_LE(cache.counters().bytes, 1000u);
  render("a", 0);
  EXPECT_EQ(told.events, Events({"ax", "ax"}));
  EXPECT_TRUE(cache.Lead("b", 1, told.As("b")));
  cache.Abandon("b");
  EXPECT_TRUE(cache.Wants("b", 1000));
  EXPECT_FALSE(cache.Wants("b", 1001));
  render("huge", 1001);
  EXPECT_TRUE(cache.Lead("huge", 1, told.As("huge"))) << "larger than the cache";
  EXPECT_FALSE(cache.Lead("huge", 2, told.As("huge")));
  EXPECT_TRUE(cache.Wants("huge", 1001)) << "somebody waits";
}

TEST(ResultCacheTest, OfNoBytesKeepsNothingAndIdenticalRequestsUnderWayAreOneAllTheSame) {
  ResultCache cache(0);
  Told told;
  EXPECT_TRUE(cache.Lead("a", 1, told.As("1")));
  EXPECT_FALSE(cache.Lead("a", 2, told.As("2")));
  cache.Publish("a", ReplyOf(10, 'x'));
  EXPECT_EQ(told.events, Events({"2x"}));
  EXPECT_EQ(cache.counters().bytes, 0u);
  EXPECT_TRUE(cache.Lead("a", 3, told.As("3")));
}

}  // namespace
}  // namespace halfshade
