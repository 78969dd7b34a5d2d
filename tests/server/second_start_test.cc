// What a scene of a million triangles costs to read behind the fence, in time and memory, and to take from the store at
// the next start.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "client/glb_writer.h"
#include "renderer/scene/flat_form.h"
#include "server/cpu_pool.h"
#include "server/digest.h"
#include "server/fence.h"
#include "server/scene_catalog.h"
#include "server/scene_name.h"
#include "tests/client/temporary_folder.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/process_memory.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

// CPU milliseconds of this process and of the children that it waited for.
double CpuMs() {
  double ms = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    struct rusage usage {};
    getrusage(who, &usage);
    ms += 1e3 * double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
          1e-3 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  }
  return ms;
}

// Another reader, and how many files it read.
class CountingReader final : public SceneReader {
 public:
  explicit CountingReader(SceneReader* reader) : reader_(reader) {}
  absl::StatusOr<FlatScene> Load(const std::string& root, const FileMap& files,
                                 const SceneLoadLimits& limits) override {
    ++loads_;
    return reader_->Load(root, files, limits);
  }
  absl::StatusOr<Rgba8Image> Decode(const EncodedImage& image, uint64_t max_pixels) override {
    return reader_->Decode(image, max_pixels);
  }
  int loads() const { return loads_; }

 private:
  SceneReader* const reader_;
  int loads_ = 0;
};

class SecondStartTest : public testing::Test {
 protected:
  void SetUp() override {
    FenceOptions options;
    options.loader = HALFSHADE_SCENE_LOADER;
    auto fence = Fence::Raise(options);
    ASSERT_OK(fence);
    fence_ = *std::move(fence);
    reader_ = std::make_unique<CountingReader>(fence_.get());
  }
  // What `work` costs at a new start.
  template <typename Work>
  double AtAStart(const Work& work) {
    SceneCache cache(uint64_t(1) << 30);
    auto store = Store::Open(folder_.path(), {uint64_t(1) << 30});
    EXPECT_OK(store);
    CpuPool pool(1);
    DerivedStore derived(store->get(), &pool);
    auto catalog = SceneCatalog::Open(store->get(), &cache, reader_.get(), &derived, {});
    EXPECT_OK(catalog);
    const double begin = CpuMs();
    EXPECT_OK(work(**store, **catalog));
    return CpuMs() - begin;
  }
  const TemporaryFolder folder_;
  std::unique_ptr<Fence> fence_;
  std::unique_ptr<CountingReader> reader_;
};

// What either takes is printed, for server/README.md.
TEST_F(SecondStartTest, AMillionTrianglesComeFromTheStoreUnread) {
  const std::string glb = WriteGlb({MakeSphere({0, 0, 0}, 1, 500)});
  const std::string digest = Sha256Hex(glb), name = SceneName(digest, {});
  AtAStart([&](Store& store, SceneCatalog&) { return store.Put(StoreKind::kBlob, digest, glb); });
  std::vector<double> first, second;
  const auto load = [&](Store&, SceneCatalog& catalog) {
    double ms = 0;
    return catalog.Load(name, &ms).status();
  };
  for (int i = 0; i < 5; ++i) {
    first.push_back(AtAStart([&](Store&, SceneCatalog& catalog) {
      if (i > 0) return fence_->Load(glb, {}, {}).status();
      v1::CreateSceneRequest request;  // what the next starts find
      request.set_root_digest(digest);
      return catalog.Create(request).status();
    }));
    second.push_back(AtAStart(load));
  }
  std::sort(first.begin(), first.end());
  std::sort(second.begin(), second.end());
  std::printf("read behind the fence: %.0f ms of CPU time; from the store: %.0f ms\n", first[2], second[2]);
  EXPECT_EQ(reader_->loads(), 1);
}

// The loader's share is the least limit under which it reads the file: of its address space, so more than it touches.
TEST_F(SecondStartTest, AMillionTrianglesTakeFarLessMemoryThanTheBound) {
  const std::string glb = WriteGlb({MakeSphere({0, 0, 0}, 1, 500)});
  FenceOptions options;
  options.loader = HALFSHADE_SCENE_LOADER;
  uint64_t too_little_mb = 0, enough_mb = 512;
  while (enough_mb - too_little_mb > 1) {
    options.memory_mb = (too_little_mb + enough_mb) / 2;
    const auto fence = Fence::Raise(options);
    (fence.ok() && (*fence)->Load(glb, {}, {}).ok() ? enough_mb : too_little_mb) = options.memory_mb;
  }
  enough_mb += 2;  // where a huge page begins differs from run to run
  options.memory_mb = enough_mb;
  auto fence = Fence::Raise(options);
  ASSERT_OK(fence);
  PurgeFreedMemory();
  ForgetPeak();
  const uint64_t before = OwnPeakBytes();
  const auto scene = (*fence)->Load(glb, {}, {});
  ASSERT_OK(scene);
  const double mib = 1 << 20, sent = double(glb.size()) / mib, own = double(OwnPeakBytes() - before) / mib;
  const double memory_files = sent + double(FlatSceneBytes(*scene).size()) / mib;
  const double all = double(enough_mb) + own + memory_files;
  std::printf("sent %.1f MiB; the loader %llu, the server %.0f, the files between them %.0f: %.1f of what is sent\n",
              sent, static_cast<unsigned long long>(enough_mb), own, memory_files, all / sent);
  // Measured 7.9: twice that. The promise is 100, and 256 MiB.
  EXPECT_LT(all, 16 * sent);
}

}  // namespace
}  // namespace halfshade
