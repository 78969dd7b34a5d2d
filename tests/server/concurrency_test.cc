// The server's own threads, without GL: queue, cache and pool. Run under TSan by test.sh --long.
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <thread>

#include "server/admission.h"
#include "server/byte_budget.h"
#include "server/cpu_pool.h"
#include "server/gl_worker.h"
#include "server/scene_cache.h"
#include "server/status.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

RenderJob Job(
    uint64_t id, std::function<void()> work = [] {}) {
  return {.id = id, .run = [work](WorkerRenderer&) {
            work();
            return absl::OkStatus();
          }};
}

TEST(RenderQueueTest, AFullQueueRefusesWithPushback) {
  RenderQueue queue(2, 1);
  EXPECT_OK(queue.Push(Job(1), 10s));
  EXPECT_OK(queue.Push(Job(2), 10s));
  const absl::Status status = queue.Push(Job(3), 10s);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("the queue is full: 2")));
  EXPECT_GE(std::stoi(PushbackMs(status)), 50);
}

TEST(RenderQueueTest, AWaitBeyondTheDeadlineIsRefusedAtOnce) {
  RenderQueue queue(10, 1);
  EXPECT_OK(queue.Push(Job(1), 10s));
  queue.Pop();
  queue.Report(5s);
  EXPECT_OK(queue.Push(Job(2), 1s)) << "nobody is ahead";
  EXPECT_THAT(queue.Push(Job(3), 1s),
              StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("too long for the deadline")));
  EXPECT_OK(queue.Push(Job(4), 6s));
}

TEST(RenderQueueTest, AWithdrawnJobNeverRuns) {
  RenderQueue queue(10, 1);
  EXPECT_OK(queue.Push(Job(1), 1s));
  EXPECT_OK(queue.Push(Job(2), 1s));
  EXPECT_TRUE(queue.Withdraw(1));
  EXPECT_FALSE(queue.Withdraw(1));
  EXPECT_EQ(queue.Pop()->id, 2u);
  EXPECT_FALSE(queue.Withdraw(2)) << "it runs";
}

TEST(RenderQueueTest, AClosedQueueGivesOutWhatWaitsAndTakesNothing) {
  RenderQueue queue(10, 1);
  EXPECT_OK(queue.Push(Job(1), 1s));
  queue.Close();
  EXPECT_THAT(queue.Push(Job(2), 1s), StatusIs(absl::StatusCode::kUnavailable, HasSubstr("draining")));
  EXPECT_EQ(queue.Pop()->id, 1u);
  EXPECT_FALSE(queue.Pop().has_value());
}

RenderJob JobOf(uint64_t id, const std::string& principal, const std::string& affinity = "") {
  RenderJob job = Job(id);
  job.principal = principal;
  job.affinity = affinity;
  return job;
}

std::vector<uint64_t> PopAll(RenderQueue* queue, std::string affinity = "") {
  std::vector<uint64_t> order;
  while (queue->waiting() > 0) {
    const auto job = queue->Pop([] { return false; }, 1h, affinity);
    order.push_back(job->id);
    affinity = job->affinity;
  }
  return order;
}

TEST(RenderQueueTest, PrincipalsTakeTurns) {
  RenderQueue queue(10, 1);
  for (uint64_t id = 1; id <= 4; ++id) EXPECT_OK(queue.Push(JobOf(id, "greedy"), 10s));
  EXPECT_OK(queue.Push(JobOf(5, "modest"), 10s));
  EXPECT_EQ(PopAll(&queue), (std::vector<uint64_t>{1, 5, 2, 3, 4}));
}

TEST(RenderQueueTest, AModestPrincipalsWaitIsNotThatOfTheGreedyOnesJobs) {
  RenderQueue queue(100, 1);
  EXPECT_OK(queue.Push(JobOf(1, "greedy"), 10s));
  queue.Pop();
  queue.Report(1s);
  for (uint64_t id = 2; id <= 20; ++id) EXPECT_OK(queue.Push(JobOf(id, "greedy"), 100s));
  EXPECT_OK(queue.Push(JobOf(21, "modest"), 1.5s)) << "one of the other's is before it";
  EXPECT_THAT(queue.Push(JobOf(22, "greedy"), 1.5s), StatusIs(absl::StatusCode::kResourceExhausted, testing::_));
}

TEST(RenderQueueTest, InAFullQueueTheGreedyOnesNewestJobMakesRoomUpToAnEqualShare) {
  RenderQueue queue(4, 1);
  std::vector<uint64_t> refused;
  const auto push = [&](uint64_t id, const std::string& principal) {
    RenderJob job = JobOf(id, principal);
    job.refuse = [&refused, id](const absl::Status& status) {
      EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("the queue is full: 4")));
      EXPECT_NE(PushbackMs(status), "");
      refused.push_back(id);
    };
    return queue.Push(std::move(job), 10s);
  };
  for (uint64_t id = 1; id <= 4; ++id) EXPECT_OK(push(id, "greedy"));
  EXPECT_OK(push(5, "modest"));
  EXPECT_OK(push(6, "modest"));
  EXPECT_EQ(refused, (std::vector<uint64_t>{4, 3}));
  EXPECT_THAT(push(7, "modest"), StatusIs(absl::StatusCode::kResourceExhausted, testing::_)) << "it has its half";
  EXPECT_THAT(push(8, "greedy"), StatusIs(absl::StatusCode::kResourceExhausted, testing::_));
  EXPECT_EQ(PopAll(&queue), (std::vector<uint64_t>{1, 5, 2, 6}));
}

TEST(RenderQueueTest, JobsOfOneAffinityGoTogetherButNobodyIsOvertakenForEver) {
  RenderQueue queue(100, 1);
  EXPECT_OK(queue.Push(JobOf(1, "", "a"), 10s));
  EXPECT_OK(queue.Push(JobOf(2, "", "b"), 10s));
  EXPECT_OK(queue.Push(JobOf(3, "", "a"), 10s));
  EXPECT_EQ(PopAll(&queue), (std::vector<uint64_t>{1, 3, 2}));
  EXPECT_OK(queue.Push(JobOf(1, "", "b"), 10s));
  for (uint64_t id = 2; id <= 20; ++id) EXPECT_OK(queue.Push(JobOf(id, "", "a"), 10s));
  EXPECT_EQ(PopAll(&queue, "a")[8], 1u);
}

TEST(GlWorkerTest, RunsEveryJobOnceAcrossWorkers) {
  RenderQueue queue(1000, 2);
  std::atomic<int> runs{0};
  {
    const RendererFactory factory = [] { return WorkerRenderer{nullptr, nullptr, "fake", "0", "fake"}; };
    auto a = GlWorker::Start(factory, &queue);
    auto b = GlWorker::Start(factory, &queue);
    ASSERT_OK(a);
    ASSERT_OK(b);
    EXPECT_EQ((*a)->gl_renderer(), "fake");
    for (uint64_t i = 1; i <= 500; ++i) EXPECT_OK(queue.Push(Job(i, [&] { ++runs; }), 100s));
    queue.Close();
  }
  EXPECT_EQ(runs, 500);
}

// Remembers what it is told to forget.
class ForgetfulRenderer : public Renderer {
 public:
  explicit ForgetfulRenderer(std::atomic<int>* forgotten) : forgotten_(forgotten) {}
  absl::StatusOr<RenderResult> Render(const std::string&, const FlatScene&, const RenderRequest&,
                                      const StopCheck&) override {
    return RenderResult();
  }
  void ForgetScene(const std::string& name) override {
    EXPECT_EQ(name, "scenes/a");
    ++*forgotten_;
  }
  std::vector<CacheReport> Caches() const override { return {{"light_data", 1, 2, uint64_t(*forgotten_)}}; }

 private:
  std::atomic<int>* forgotten_;
};

TEST(GlWorkerTest, ForgetsAtOnceWhenIdleAndAfterTheJobWhenBusy) {
  RenderQueue queue(10, 1);
  std::atomic<int> forgotten{0};
  const auto worker = GlWorker::Start(
      [&forgotten]() -> absl::StatusOr<WorkerRenderer> {
        return WorkerRenderer{nullptr, std::make_unique<ForgetfulRenderer>(&forgotten), "fake", "0", "fake"};
      },
      &queue);
  ASSERT_OK(worker);
  EXPECT_TRUE((*worker)->Caches().empty()) << "nothing drawn yet";
  const auto wait_for = [&](int count) {
    for (int i = 0; i < 2000 && forgotten < count; ++i) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(forgotten, count);
  };
  (*worker)->ForgetScene("scenes/a");
  wait_for(1);
  std::atomic<bool> may_end{false};
  EXPECT_OK(queue.Push(Job(1,
                           [&] {
                             while (!may_end) std::this_thread::sleep_for(1ms);
                           }),
                       10s));
  while (queue.waiting() > 0) std::this_thread::sleep_for(1ms);
  (*worker)->ForgetScene("scenes/a");
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(forgotten, 1) << "the context is in use";
  may_end = true;
  wait_for(2);
  queue.Close();
  (*worker)->Join();
  ASSERT_EQ((*worker)->Caches().size(), 1u);
  EXPECT_EQ((*worker)->Caches()[0].bytes, 2u);
  (*worker)->ForgetScene("scenes/a");  // too late, and harmless
}

// Fails its canary when it is told to.
class MortalRenderer : public ForgetfulRenderer {
 public:
  MortalRenderer(std::atomic<int>* forgotten, std::atomic<bool>* is_lost)
      : ForgetfulRenderer(forgotten), is_lost_(is_lost) {}
  absl::Status CheckCanary() override {
    return is_lost_->exchange(false) ? absl::UnavailableError("lost") : absl::OkStatus();
  }

 private:
  std::atomic<bool>* is_lost_;
};

struct MortalFactory {
  std::atomic<int> calls{0}, forgotten{0}, lost_now{0}, lost_ever{0};
  std::atomic<int> failures_to_come{0};
  std::atomic<bool> is_lost{false};

  absl::StatusOr<std::unique_ptr<GlWorker>> StartWorker(RenderQueue* queue, std::chrono::milliseconds canary) {
    ContextWatch watch;
    watch.canary = canary;
    watch.on_health = [this](bool is_well) {
      lost_now += is_well ? -1 : 1;
      if (!is_well) ++lost_ever;
    };
    return GlWorker::Start(
        [this]() -> absl::StatusOr<WorkerRenderer> {
          if (calls++ > 0 && failures_to_come > 0) {
            --failures_to_come;
            return absl::FailedPreconditionError("no GL");
          }
          return WorkerRenderer{nullptr, std::make_unique<MortalRenderer>(&forgotten, &is_lost), "fake", "0", "fake"};
        },
        queue, watch);
  }
};

bool Becomes(const std::atomic<int>& value, int wanted) {
  for (int i = 0; i < 5000 && value != wanted; ++i) std::this_thread::sleep_for(1ms);
  return value == wanted;
}

TEST(GlWorkerTest, AContextThatDrawsNoMoreIsMadeAnewUntilThatSucceeds) {
  MortalFactory factory;
  RenderQueue queue(10, 1);
  const auto worker = factory.StartWorker(&queue, 1h);
  ASSERT_OK(worker);
  factory.is_lost = true;
  factory.failures_to_come = 2;
  RenderJob job = Job(1);
  job.run = [](WorkerRenderer&) { return absl::UnavailableError("lost"); };
  EXPECT_OK(queue.Push(std::move(job), 10s));
  EXPECT_TRUE(Becomes(factory.calls, 4)) << "the start, two failures and a success";
  EXPECT_TRUE(Becomes(factory.lost_now, 0));
  EXPECT_EQ(factory.lost_ever, 1);
  std::atomic<int> runs{0};
  EXPECT_OK(queue.Push(Job(2, [&] { ++runs; }), 10s));
  EXPECT_TRUE(Becomes(runs, 1));
  queue.Close();
}

TEST(GlWorkerTest, AnIdleContextShowsItsCanary) {
  MortalFactory factory;
  RenderQueue queue(10, 1);
  const auto worker = factory.StartWorker(&queue, 5ms);
  ASSERT_OK(worker);
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(factory.calls, 1) << "it draws";
  factory.is_lost = true;
  EXPECT_TRUE(Becomes(factory.calls, 2));
  queue.Close();
}

TEST(GlWorkerTest, AFailedJobWithoutALossKeepsItsContext) {
  MortalFactory factory;
  RenderQueue queue(10, 1);
  auto worker = factory.StartWorker(&queue, 1h);
  ASSERT_OK(worker);
  RenderJob job = Job(1);
  job.run = [](WorkerRenderer&) { return absl::InternalError("a shader's fault"); };
  EXPECT_OK(queue.Push(std::move(job), 10s));
  queue.Close();
  (*worker)->Join();
  EXPECT_EQ(factory.calls, 1);
  EXPECT_EQ(factory.lost_ever, 0);
}

TEST(GlWorkerTest, EndsWhileNoContextCanBeHad) {
  MortalFactory factory;
  RenderQueue queue(10, 1);
  const auto worker = factory.StartWorker(&queue, 1ms);
  ASSERT_OK(worker);
  factory.failures_to_come = 1 << 20;
  factory.is_lost = true;
  EXPECT_TRUE(Becomes(factory.lost_now, 1));
  queue.Close();
}

TEST(GlWorkerTest, AFactoryThatFailsIsTheStartsError) {
  RenderQueue queue(1, 1);
  const auto worker = GlWorker::Start(
      []() -> absl::StatusOr<WorkerRenderer> { return absl::FailedPreconditionError("no GL"); }, &queue);
  EXPECT_THAT(worker, StatusIs(absl::StatusCode::kFailedPrecondition, HasSubstr("no GL")));
}

TEST(CpuPoolTest, RunsEverythingBeforeItEnds) {
  std::atomic<int> runs{0};
  {
    CpuPool pool(3);
    for (int i = 0; i < 300; ++i) pool.Run([&] { ++runs; });
  }
  EXPECT_EQ(runs, 300);
}

TEST(CpuPoolTest, PrincipalsTakeTurnsAndEachOnesWorkKeepsItsOrder) {
  std::string order;
  {
    CpuPool pool(1);
    std::promise<void> gate;
    pool.Run([open = gate.get_future().share()] { open.wait(); });
    for (const char* work : {"a1", "a2", "a3", "b1", "c1", "c2"}) {
      pool.Run([&order, work] { order += work; }, std::string(1, work[0]));
    }
    gate.set_value();
  }
  EXPECT_EQ(order, "a1b1c1a2c2a3");
}

TEST(ByteBudgetTest, AHoldIsGivenBackAndNeverMoreIsGivenThanThereIs) {
  ByteBudget budget(100);
  {
    auto first = budget.Take(60, "images");
    ASSERT_OK(first);
    EXPECT_OK(budget.Take(40, "images"));
    const auto second = budget.Take(41, "images");
    EXPECT_THAT(second,
                StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("images: 41 bytes, and 60 of the 100")));
    EXPECT_NE(PushbackMs(second.status()), "");
    const ByteBudget::Hold moved = *std::move(first);
    EXPECT_EQ(budget.used(), 60u);
  }
  EXPECT_EQ(budget.used(), 0u);
  EXPECT_OK(budget.Take(100, "images"));
  EXPECT_THAT(budget.Take(101, "images"), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("at most 100")));
}

TEST(ByteBudgetTest, ManyThreadsNeverHoldMoreThanThereIs) {
  ByteBudget budget(10);
  std::atomic<int> held{0}, most{0}, taken{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      while (taken < 2000) {
        const auto hold = budget.Take(4, "images");
        if (!hold.ok()) continue;
        ++taken;
        const int now = held += 4;
        for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) {
        }
        held -= 4;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_LE(most, 10);
  EXPECT_EQ(budget.used(), 0u);
}

FlatScene SceneOf(size_t vertices) {
  FlatScene scene;
  scene.positions.resize(vertices);
  return scene;
}

TEST(SceneCacheTest, IdenticalLoadsAreDoneOnce) {
  SceneCache cache(1 << 20);
  std::atomic<int> loads{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      EXPECT_OK(cache.Get("a", [&]() -> absl::StatusOr<FlatScene> {
        ++loads;
        std::this_thread::sleep_for(20ms);
        return SceneOf(10);
      }));
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(loads, 1);
}

// Gets a scene of 1000 vertices and says whether it had to be loaded.
class CacheOf {
 public:
  explicit CacheOf(uint64_t max_bytes) : cache(max_bytes) {}
  absl::StatusOr<SceneCache::ScenePtr> Get(const std::string& name, size_t vertices = 1000) {
    was_loaded = false;
    return cache.Get(name, [&]() -> absl::StatusOr<FlatScene> {
      was_loaded = true;
      return SceneOf(vertices);
    });
  }
  SceneCache cache;
  bool was_loaded = false;
};
const uint64_t kOne = SceneOf(1000).SizeBytes();

TEST(SceneCacheTest, TheLeastRecentlyUsedGoesFirst) {
  CacheOf cache(2 * kOne);
  ASSERT_OK(cache.Get("a"));
  ASSERT_OK(cache.Get("b"));
  ASSERT_OK(cache.Get("a"));
  ASSERT_OK(cache.Get("c"));
  EXPECT_EQ(cache.cache.counters().bytes, 2 * kOne);
  ASSERT_OK(cache.Get("a"));
  EXPECT_FALSE(cache.was_loaded);
  ASSERT_OK(cache.Get("b"));
  EXPECT_TRUE(cache.was_loaded) << "b was the least recently used";
  EXPECT_EQ(cache.cache.counters().hits, 2u);
  EXPECT_EQ(cache.cache.counters().misses, 4u);
}

TEST(SceneCacheTest, SaysWhichSceneLeaves) {
  const uint64_t one = SceneOf(1000).SizeBytes();
  std::vector<std::string> dropped;
  SceneCache cache(2 * one, [&](const std::string& name) { dropped.push_back(name); });
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_OK(cache.Get(name, [] { return absl::StatusOr<FlatScene>(SceneOf(1000)); }));
  }
  EXPECT_EQ(dropped, std::vector<std::string>({"a"})) << "evicted";
  cache.Forget("c");
  cache.Forget("unknown");
  EXPECT_EQ(dropped, std::vector<std::string>({"a", "c"}));
}

TEST(SceneCacheTest, ASceneInUseIsNeitherEvictedNorLeftOutOfTheCount) {
  CacheOf cache(2 * kOne);
  const auto a = *cache.Get("a");
  ASSERT_OK(cache.Get("b"));
  ASSERT_OK(cache.Get("c"));
  ASSERT_OK(cache.Get("a"));
  EXPECT_FALSE(cache.was_loaded) << "the oldest, but in use";
  cache.cache.Forget("a");
  EXPECT_EQ(cache.cache.counters().bytes, 2 * kOne) << "its user still has it";
  EXPECT_EQ(a->positions.size(), 1000u);
}

TEST(SceneCacheTest, WhereScenesInUseLeaveNoRoomTheNextIsRefusedForNowAndNotLoadedAgain) {
  CacheOf cache(2 * kOne);
  auto a = *cache.Get("a");
  const auto b = *cache.Get("b");
  for (const bool is_known : {false, true}) {
    const absl::Status status = cache.Get("c").status();
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted,
                                 HasSubstr(std::to_string(2 * kOne) + " of the " + std::to_string(2 * kOne) +
                                           " of the scene cache are in use")));
    EXPECT_NE(PushbackMs(status), "");
    EXPECT_EQ(cache.was_loaded, !is_known);
    EXPECT_EQ(cache.cache.counters().bytes, 2 * kOne);
  }
  a.reset();
  EXPECT_OK(cache.Get("c"));
  ASSERT_OK(cache.Get("b"));
  EXPECT_FALSE(cache.was_loaded) << "in use: a went instead";
}

TEST(SceneCacheTest, ARefusalEvictsNothing) {
  CacheOf cache(3 * kOne);
  const auto a = *cache.Get("a");
  ASSERT_OK(cache.Get("b"));
  EXPECT_THAT(cache.Get("large", 2500), StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("in use")));
  ASSERT_OK(cache.Get("b"));
  EXPECT_FALSE(cache.was_loaded);
}

TEST(SceneCacheTest, ASceneLargerThanTheCacheIsRefusedForGoodWithTheNumbers) {
  CacheOf cache(kOne);
  EXPECT_OK(cache.Get("a"));
  const absl::Status status = cache.Get("b", 1001).status();
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kInvalidArgument,
                               HasSubstr("the scene takes " + std::to_string(SceneOf(1001).SizeBytes()) +
                                         " bytes; the scene cache of this server holds " + std::to_string(kOne))));
  EXPECT_EQ(PushbackMs(status), "");
}

TEST(SceneCacheTest, AFailedLoadIsNotKept) {
  CacheOf cache(kOne);
  EXPECT_THAT(cache.cache.Get("a", [] { return absl::StatusOr<FlatScene>(absl::InvalidArgumentError("bad")); }),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("bad")));
  EXPECT_EQ(cache.cache.counters().bytes, 0u);
  EXPECT_OK(cache.Get("a"));
}

TEST(SceneCacheTest, WhateverTheThreadsDoTheBoundHoldsAndNothingStaysCounted) {
  SceneCache cache(4 * kOne);
  std::vector<std::thread> threads;
  std::atomic<int> served{0}, over{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 500; ++i) {
        const std::string name(1, char('a' + (i * 7 + t * 3) % 12));
        const auto scene = cache.Get(name, [] { return absl::StatusOr<FlatScene>(SceneOf(1000)); });
        EXPECT_TRUE(scene.ok() || absl::IsResourceExhausted(scene.status())) << scene.status();
        served += scene.ok();
        over += cache.counters().bytes > 4 * kOne;
        if (i % 50 == 0) cache.Forget(name);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(served, 1000);
  EXPECT_EQ(over, 0);
  for (char name = 'a'; name < 'a' + 12; ++name) cache.Forget(std::string(1, name));
  EXPECT_EQ(cache.counters().bytes, 0u);
}

}  // namespace
}  // namespace halfshade
