// What stays in GL memory between calls, seen from the wire: kept, found, counted, freed.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "halfshade/v1/render.grpc.pb.h"
#include "halfshade/v1/scene.grpc.pb.h"
#include "halfshade/v1/server.grpc.pb.h"
#include "server/digest.h"
#include "server/server.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/scene_makers.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using namespace std::chrono_literals;

class GlMemoryTest : public testing::Test {
 protected:
  GlMemoryTest() { Start({}); }
  void Start(const ServerOptions& options) {
    auto server = Server::Start(options);
    ASSERT_OK(server);
    server_ = *std::move(server);
    channel_ = server_->InProcessChannel();
    scenes_ = v1::SceneService::NewStub(channel_);
    renders_ = v1::RenderService::NewStub(channel_);
    statistics_ = v1::ServerService::NewStub(channel_);
  }

  // A plate of this edge over a floor.
  std::string MakeScene(double edge) {
    return AddScene(WriteGlb({MakePlate({0, 0, 0}, 4, 4), MakePlate({0, 1, 0}, edge, edge)}));
  }
  std::string AddScene(const std::string& glb) {
    v1::UploadBlobRequest chunk;
    chunk.set_digest(Sha256Hex(glb));
    chunk.set_size_bytes(glb.size());
    chunk.set_data(glb);
    grpc::ClientContext upload_context, create_context;
    v1::UploadBlobResponse uploaded;
    auto writer = scenes_->UploadBlob(&upload_context, &uploaded);
    writer->Write(chunk);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
    v1::CreateSceneRequest create;
    create.set_root_digest(chunk.digest());
    v1::CreateSceneResponse created;
    EXPECT_TRUE(scenes_->CreateScene(&create_context, create, &created).ok());
    return created.scene().name();
  }

  v1::RenderResponse Render(const v1::RenderRequest& request) {
    grpc::ClientContext context;
    v1::RenderResponse response;
    const grpc::Status status = renders_->Render(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  std::map<std::string, v1::Cache> Caches() {
    grpc::ClientContext context;
    v1::GetStatisticsResponse response;
    EXPECT_TRUE(statistics_->GetStatistics(&context, {}, &response).ok());
    std::map<std::string, v1::Cache> caches;
    for (const v1::Cache& cache : response.caches()) caches[cache.name()] = cache;
    return caches;
  }

  // Counters follow a render's answer, and a scene's end, by a moment.
  template <typename Condition>
  bool Becomes(Condition condition) {
    for (int i = 0; i < 5000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }

  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SceneService::Stub> scenes_;
  std::unique_ptr<v1::RenderService::Stub> renders_;
  std::unique_ptr<v1::ServerService::Stub> statistics_;
};

TEST_F(GlMemoryTest, LightDataIsFoundByTheNextCameraCountedAndFreedWithItsScene) {
  v1::RenderRequest request;
  request.set_scene(MakeScene(1));
  request.set_width(64);
  request.set_height(64);
  request.mutable_method()->mutable_multi_map()->set_map_size(256);
  v1::LookAt* look_at = request.mutable_camera()->mutable_look_at();
  look_at->mutable_eye()->set_y(5);
  look_at->mutable_eye()->set_z(1);
  look_at->mutable_target();
  v1::AreaLight* light = request.add_lights();
  light->mutable_center()->set_y(3);
  light->mutable_edge_u()->set_x(1);
  light->mutable_edge_v()->set_z(1);
  EXPECT_GT(Render(request).report().timing().light_ms(), 0);
  look_at->mutable_eye()->set_z(2);
  EXPECT_EQ(Render(request).report().timing().light_ms(), 0);
  EXPECT_TRUE(Becomes([&] { return Caches()["light_data"].hits() == 1; }));
  EXPECT_EQ(Caches()["light_data"].misses(), 1u) << "warming up is not counted";
  EXPECT_GE(Caches()["light_data"].bytes(), 64u * 256 * 256 * 4);
  EXPECT_GT(Caches()["scene_on_context"].bytes(), 0u);

  const std::string other = MakeScene(2);
  grpc::ClientContext context;
  v1::DeleteSceneRequest remove;
  remove.set_name(request.scene());
  v1::DeleteSceneResponse removed;
  EXPECT_TRUE(scenes_->DeleteScene(&context, remove, &removed).ok());
  EXPECT_TRUE(Becomes([&] { return Caches()["light_data"].bytes() + Caches()["scene_on_context"].bytes() == 0; }))
      << "freed while nobody renders";
  request.set_scene(other);
  Render(request);
  EXPECT_TRUE(Becomes([&] { return Caches()["light_data"].misses() == 2; }));
}

TEST_F(GlMemoryTest, RayScenesOfAllContextsTogetherKeepToTheirFlag) {
  ServerOptions options;
  options.contexts = 2;
  options.light_cache_mb = 1;  // or the light data of rays, counted there, would hold their hierarchy
  uint64_t kept = 0;
  for (const uint64_t ray_scene_mb : {64, 4}) {
    options.ray_scene_mb = ray_scene_mb;
    server_.reset();
    Start(options);
    v1::RenderRequest request;
    request.set_scene(AddScene(WriteGlb(halfshade::MakeScene("S6", {.triangles = 30'000}).meshes)));
    request.set_width(32);
    request.set_height(32);
    request.mutable_method()->mutable_ray()->set_rays(4);
    Render(request);
    EXPECT_TRUE(Becomes([&] { return Caches()["ray_scene"].misses() == 1; }));
    if (ray_scene_mb == 64) kept = Caches()["ray_scene"].bytes();
  }
  ASSERT_GT(kept, 2u << 20) << "more than one context's share of the bound, or nothing is tried";
  ASSERT_LT(kept, 4u << 20);
  EXPECT_EQ(Caches()["ray_scene"].bytes(), 0u);
}

// Light data of SHAFT hold the scene's shapes, and count them: with them they go.
TEST_F(GlMemoryTest, ShapesOfScenesKeepToTheirFlagAndGoWithTheirLights) {
  ServerOptions options;
  options.light_cache_mb = 4;
  options.canary_ms = 3'600'000;  // it is drawn by SHAFT too
  for (const uint64_t ray_scene_mb : {64, 6}) {
    options.ray_scene_mb = ray_scene_mb;
    server_.reset();
    Start(options);
    v1::RenderRequest request;
    request.set_width(32);
    request.set_height(32);
    request.mutable_method()->mutable_shaft()->set_rows(8);
    uint64_t one = 0;
    for (const uint32_t triangles : {30'000, 31'000}) {
      request.set_scene(AddScene(WriteGlb(halfshade::MakeScene("S6", {.triangles = triangles}).meshes)));
      const uint64_t misses = Caches()["scene_data"].misses();
      Render(request);
      EXPECT_TRUE(Becomes([&] { return Caches()["scene_data"].misses() > misses; }));
      if (one == 0) one = Caches()["scene_data"].bytes();
    }
    ASSERT_GT(one, 2u << 20) << "more than the bound, or nothing is tried; and two are more than fit as light data";
    ASSERT_LT(one, 4u << 20);
    EXPECT_EQ(Caches()["scene_data"].bytes() > one * 3 / 2, ray_scene_mb == 64);
  }
}

// PDSM of a scene that outlives the server: the next one on the folder draws no maps for it, unless its file is
// damaged.
TEST_F(GlMemoryTest, TheNextServerOnTheFolderFindsThePdsm) {
  const auto folder = std::filesystem::temp_directory_path() / ("light_store_" + std::to_string(getpid()));
  ServerOptions options;
  options.scene_store_dir = folder;
  v1::RenderRequest request;
  const auto render_anew = [&](const std::string& method) {
    server_.reset();
    Start(options);
    request.set_scene(MakeScene(1));
    request.mutable_method()->mutable_pdsm()->set_map_size(64);
    request.mutable_method()->mutable_pdsm()->set_pdsm_size(64);
    if (method == "multi_map") request.mutable_method()->mutable_multi_map()->set_k(4);
    const v1::RenderResponse response = Render(request);
    for (const v1::Pass& pass : response.report().passes()) {
      if (pass.name() == "light[0]/light_data") return pass;
    }
    ADD_FAILURE() << "no pass of light data";
    return v1::Pass();
  };
  request.set_width(32);
  request.set_height(32);
  EXPECT_EQ(render_anew("pdsm").count(), 64u);
  const v1::Pass found = render_anew("pdsm");
  EXPECT_EQ(found.count(), 0u);
  EXPECT_EQ(found.reason(), "from the store");
  options.keeps_store = false;
  EXPECT_EQ(render_anew("pdsm").count(), 64u) << "a server of a folder that goes with it neither reads nor writes";
  options.keeps_store = true;
  server_.reset();
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "derived")) {
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(1000);
    file.put('?');
    ++files;
  }
  EXPECT_EQ(files, 2) << "the light data, and the scene as it was read";
  const v1::Pass again = render_anew("pdsm");
  EXPECT_EQ(again.count(), 64u);
  EXPECT_EQ(again.reason(), "what the store has is not whole: built again");
  EXPECT_EQ(render_anew("pdsm").reason(), "from the store") << "it was replaced";
  EXPECT_EQ(render_anew("multi_map").count(), 4u);
  grpc::ClientContext context;
  v1::DeleteSceneRequest remove;
  remove.set_name(request.scene());
  v1::DeleteSceneResponse removed;
  EXPECT_TRUE(scenes_->DeleteScene(&context, remove, &removed).ok());
  EXPECT_TRUE(std::filesystem::is_empty(folder / "derived"));
  server_.reset();
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace halfshade
