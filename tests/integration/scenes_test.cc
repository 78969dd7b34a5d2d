// Uploads, scenes and the scene cache over a real port, with a renderer that draws nothing: what is cut goes on, what
// is kept comes back, what is bounded stays so.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "client/glb_writer.h"
#include "tests/integration/scenes_fixture.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/process_memory.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;
using grpc::StatusCode;
using testing::HasSubstr;

// A sphere of about `rings` * rings * 4 triangles: a scene of some size.
std::string SphereGlb(int rings, double radius) { return WriteGlb({MakeSphere({0, 0, 0}, radius, rings)}); }

TEST_F(ScenesTest, AnUploadCutAtEveryChunkGoesOnFromThere) { CutEverywhere(40 * 4096 + 17, 4096, true); }

TEST_F(ScenesTest, FromOffsetZeroAnUploadStartsOver) {
  const std::string bytes = Noise(5000, 1), digest = Sha256Hex(bytes);
  Send(bytes, 0, 3000, 1000, digest);
  ASSERT_EQ(CommittedAfterCut(digest, 3000), 3000u);
  EXPECT_TRUE(Send(bytes, 0, 5000, 1000, digest).ok());
  EXPECT_TRUE(Query(digest).complete());
  EXPECT_EQ(Query(digest).committed_bytes(), 5000u);
}

TEST_F(ScenesTest, AnOffsetBeyondWhatIsCommittedIsRefusedWithTheNextByte) {
  const std::string bytes = Noise(5000, 1), digest = Sha256Hex(bytes);
  Send(bytes, 0, 3000, 1000, digest);
  ASSERT_EQ(CommittedAfterCut(digest, 3000), 3000u);
  const grpc::Status status = Send(bytes, 3001, 5000, 1000, digest);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "offset_bytes: 3001; the next byte is 3000");
  EXPECT_TRUE(Send(bytes, 3000, 5000, 1000, digest).ok());
}

TEST_F(ScenesTest, AWrongDigestAtTheEndTakesThePartWithIt) {
  const std::string bytes = Noise(5000, 1), digest = Sha256Hex("something else");
  Send(bytes, 0, 3000, 1000, digest);
  ASSERT_EQ(CommittedAfterCut(digest, 3000), 3000u);
  EXPECT_EQ(Send(bytes, 3000, 5000, 1000, digest).error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(Query(digest).committed_bytes(), 0u);
  EXPECT_EQ(Statistics().blob_bytes(), 0u);
}

TEST_F(ScenesTest, QueryUploadOfWhatIsNotThereIsZeroAndOfNonsenseIsRefused) {
  EXPECT_EQ(Query(std::string(64, 'a')).committed_bytes(), 0u);
  EXPECT_FALSE(Query(std::string(64, 'a')).complete());
  grpc::ClientContext context;
  v1::QueryUploadRequest request;
  request.set_digest("nonsense");
  v1::QueryUploadResponse response;
  const grpc::Status status = scenes_->QueryUpload(&context, request, &response);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("digest: \"nonsense\""));
}

TEST_F(ScenesTest, OfTwoUploadsOfOneBlobTheSecondIsToldToComeBackAndFindsItThere) {
  const std::string bytes = Noise(5000, 1), digest = Sha256Hex(bytes);
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto first = scenes_->UploadBlob(&context, &response);
  v1::UploadBlobRequest chunk;
  chunk.set_digest(digest);
  chunk.set_size_bytes(bytes.size());
  chunk.set_data(bytes.substr(0, 2000));
  ASSERT_TRUE(first->Write(chunk));
  while (!IsTaken(digest, 2000)) std::this_thread::sleep_for(1ms);
  const grpc::Status second = Send(bytes, 0, 5000, 5000, digest);
  EXPECT_EQ(second.error_code(), StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(second.error_message(), HasSubstr("another call is uploading"));
  chunk.set_offset_bytes(2000);
  chunk.set_data(bytes.substr(2000));
  ASSERT_TRUE(first->Write(chunk));
  first->WritesDone();
  EXPECT_TRUE(first->Finish().ok());
  EXPECT_EQ(response.committed_bytes(), 5000u);
  EXPECT_TRUE(Send(bytes, 0, 5000, 5000, digest).ok()) << "it is here";
  const grpc::Status wrong_size = Send(bytes + "x", 0, 5001, 5001, digest);
  EXPECT_EQ(wrong_size.error_message(), "size_bytes: 5001; the blob is here and has 5000");
}

TEST_F(ScenesTest, ManyClientsOfOneBlobEndWithOneWholeBlob) {
  const std::string bytes = Noise(300'000, 3), digest = Sha256Hex(bytes);
  std::vector<std::thread> clients;
  std::atomic<int> done{0};
  for (int i = 0; i < 8; ++i) {
    clients.emplace_back([&] {
      for (int round = 0; round < 200; ++round) {
        const grpc::Status status = Send(bytes, 0, bytes.size(), 10'000, digest);
        if (status.ok()) {
          ++done;
          return;
        }
        EXPECT_EQ(status.error_code(), StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
        std::this_thread::sleep_for(20ms);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(done, 8);
  EXPECT_EQ(ReadAll(folder_ / ("blobs/" + digest)), bytes);
  EXPECT_EQ(Statistics().blob_bytes(), bytes.size());
}

TEST_F(ScenesTest, TheBoundsOfStoreAndUploadsHoldOnBothSides) {
  options_.scene_store_mb = 1;
  options_.limits.unfinished_uploads = 1;
  Start();
  const std::string whole = Noise(1 << 20, 5);
  EXPECT_EQ(Send(whole + "x", 0, whole.size() + 1, 1 << 20, Sha256Hex(whole + "x")).error_message(),
            "size_bytes: 1048577; the scene store holds at most 1048576");
  const std::string a = Noise(5000, 1), b = Noise(5000, 2);
  Send(a, 0, 1000, 1000, Sha256Hex(a));
  ASSERT_EQ(CommittedAfterCut(Sha256Hex(a), 1000), 1000u);
  Send(b, 0, 1000, 1000, Sha256Hex(b));
  ASSERT_EQ(CommittedAfterCut(Sha256Hex(b), 1000), 1000u);
  EXPECT_EQ(Query(Sha256Hex(a)).committed_bytes(), 0u) << "one unfinished upload is kept";
  EXPECT_TRUE(Send(whole, 0, whole.size(), 1 << 20, Sha256Hex(whole)).ok()) << "at the cost of the unfinished one";
  EXPECT_EQ(Query(Sha256Hex(b)).committed_bytes(), 0u);
  EXPECT_EQ(Statistics().blob_bytes(), 1u << 20);
  const grpc::Status full = Send("x", 0, 1, 1, Sha256Hex("x"));
  EXPECT_EQ(full.error_code(), StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(full.error_message(),
            "the scene store is full: 1048576 of 1048576 bytes are taken, 1 more do not fit; delete scenes");
}

TEST_F(ScenesTest, ASceneWhoseBlobTheDiskDamagedIsNotFoundAndComesBackWithItsUpload) {
  const std::string glb = SphereGlb(4, 1), digest = Sha256Hex(glb);
  ASSERT_TRUE(Send(glb, 0, glb.size(), 1 << 20, digest).ok());
  std::string scene;
  ASSERT_TRUE(CreateScene(digest, &scene).ok());
  std::string damaged = glb;
  damaged[damaged.size() / 2] ^= 4;
  folder_.Write("blobs/" + digest, damaged);
  Start();
  v1::RenderResponse response;
  EXPECT_TRUE(Render(scene, &response).ok()) << "its flat form is whole, and nothing else is read";
  server_.reset();
  std::filesystem::remove_all(folder_ / "derived");
  Start();
  const grpc::Status status = Render(scene, &response);
  EXPECT_EQ(status.error_code(), StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr(digest + " was damaged"));
  EXPECT_EQ(CreateScene(digest).error_code(), StatusCode::NOT_FOUND);
  ASSERT_TRUE(Send(glb, 0, glb.size(), 1 << 20, digest).ok());
  EXPECT_TRUE(Render(scene, &response).ok());
}

TEST_F(ScenesTest, ASceneLargerThanTheCacheIsRefusedForGoodAndListedWithTheReason) {
  const std::string glb = SphereGlb(150, 1), digest = Sha256Hex(glb);  // about 3 MB in memory
  ASSERT_TRUE(Send(glb, 0, glb.size(), 1 << 20, digest).ok());
  std::string scene;
  ASSERT_TRUE(CreateScene(digest, &scene).ok());
  options_.scene_cache_mb = 1;
  Start();
  const grpc::Status status = CreateScene(digest);
  EXPECT_EQ(status.error_code(), StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("the scene cache of this server holds 1048576"));
  EXPECT_FALSE(pushback_);
  grpc::ClientContext context;
  v1::ListScenesResponse list;
  ASSERT_TRUE(scenes_->ListScenes(&context, {}, &list).ok());
  ASSERT_EQ(list.scenes_size(), 1);
  EXPECT_EQ(list.scenes(0).name(), scene);
  EXPECT_THAT(list.scenes(0).warnings(0), HasSubstr("the scene cache of this server holds"));
}

TEST_F(ScenesTest, AQueryLetsGoOfItsScene) {
  options_.scene_cache_mb = 2;
  Start();
  for (int i = 0; i < 12; ++i) {
    const std::string glb = SphereGlb(100, 1 + 0.1 * i), digest = Sha256Hex(glb);
    ASSERT_TRUE(Send(glb, 0, glb.size(), 1 << 20, digest).ok());
    std::string name;
    ASSERT_TRUE(CreateScene(digest, &name).ok());
    // A scene in use is not evicted: were two of them kept, there would be no room for a third.
    const grpc::Status status = QueryPoint(name);
    EXPECT_TRUE(status.ok()) << i << ": " << status.error_message();
  }
}

// GL buffers are not in it: the renderer is blank.
TEST_F(ScenesTest, MemoryIsFlatOverFiveHundredRendersOfTwelveScenesThatDoNotFitTheCache) {
  options_.scene_cache_mb = 8;
  Start();
  std::vector<std::string> names;
  for (int i = 0; i < 12; ++i) {
    const std::string glb = SphereGlb(100, 1 + 0.1 * i), digest = Sha256Hex(glb);
    ASSERT_TRUE(Send(glb, 0, glb.size(), 1 << 20, digest).ok());
    ASSERT_TRUE(CreateScene(digest, &names.emplace_back()).ok());
    if (i == 0) {
      ASSERT_GT(12 * Statistics().caches(0).bytes(), 8u << 20) << "they must not fit";
    }
  }
  double warm_mb = 0;
  std::atomic<uint64_t> most_bytes{0}, hits_reported{0};
  for (int round = 0; round < 5; ++round) {
    std::vector<std::thread> clients;
    for (int client = 0; client < 2; ++client) {
      clients.emplace_back([&, client] {
        for (int i = 0; i < 50; ++i) {
          v1::RenderResponse response;
          // Mostly scenes in turn, which a least-recently-used cache always misses; some again at once.
          const grpc::Status status = Render(names[size_t(i % 3 == 2 ? i - 1 : i + 6 * client) % 12], &response);
          ASSERT_TRUE(status.ok()) << status.error_message();
          hits_reported += response.report().caches(0).hits();
          most_bytes = std::max<uint64_t>(most_bytes, Statistics().caches(0).bytes());
        }
      });
    }
    for (std::thread& client : clients) client.join();
    if (round == 0) warm_mb = ResidentMb();
  }
  const v1::Cache cache = Statistics().caches(0);
  EXPECT_EQ(cache.name(), "scene");
  EXPECT_LE(most_bytes, 8u << 20);
  EXPECT_GT(cache.misses(), 100u) << "12 are enough without evictions";
  EXPECT_GT(hits_reported, 50u);
  EXPECT_EQ(Statistics().renders_ok(), 500u);
  // A scene takes 1.1 MB: one leaked at every load would make 150 MB; the allocator's own ups and downs make 7.
  EXPECT_TRUE(!kIsPlainMemory || ResidentMb() - warm_mb < 40) << "from " << warm_mb << " MB";
  std::printf("resident: %.1f MB after 100 renders, %.1f MB after 500; %d loads\n", warm_mb, ResidentMb(),
              int(cache.misses()));
}

}  // namespace
}  // namespace halfshade
