#include "tests/support/render_fixture.h"

#include <cstdio>
#include <cstdlib>

namespace halfshade {
namespace {

struct TestGl {
  std::unique_ptr<gl::Context> context;
  std::unique_ptr<Renderer> renderer;

  TestGl() {
    context = OrDie(gl::Context::Create(TestContextOptions()));
    renderer = OrDie(Renderer::Create(
        context.get(), [](const EncodedImage&) { return absl::UnimplementedError("these tests have no textures"); }));
  }

  template <typename T>
  static T OrDie(absl::StatusOr<T> value) {
    if (!value.ok()) {
      std::fprintf(stderr, "%s\n", value.status().ToString().c_str());
      std::abort();
    }
    return *std::move(value);
  }
};

// Never destroyed: GL must not be torn down after main.
TestGl& Gl() {
  static TestGl& gl = *new TestGl;
  return gl;
}

}  // namespace

gl::ContextOptions TestContextOptions() {
  gl::ContextOptions options;
  const char* backend = std::getenv("HALFSHADE_TEST_GL");
  const std::string name = backend == nullptr ? "auto" : backend;
  if (name == "egl") options.backend = gl::Backend::kEgl;
  if (name == "osmesa") options.backend = gl::Backend::kOsmesa;
  return options;
}

Renderer& TestRenderer() { return *Gl().renderer; }
gl::Context& TestContext() { return *Gl().context; }

AreaLight LightAbove(double height, double size, glm::dvec2 center_xz) {
  AreaLight light;
  light.center_ws = {center_xz.x, height, center_xz.y};
  light.axis_u_ws = {1, 0, 0};
  light.axis_v_ws = {0, 0, 1};
  light.normal_ws = {0, -1, 0};
  light.width_m = light.height_m = size;
  light.radiance = light.intensity = glm::vec3(1);
  return light;
}

Camera LookFrom(glm::dvec3 eye, glm::dvec3 target) {
  Camera camera;
  camera.eye_ws = eye;
  camera.target_ws = target;
  camera.forward_ws = glm::normalize(target - eye);
  camera.right_ws = glm::normalize(glm::cross(camera.forward_ws, glm::dvec3(0, 1, 0)));
  camera.up_ws = glm::cross(camera.right_ws, camera.forward_ws);
  camera.tan_half_fovy = 0.36397023426620234;  // tan(20 degrees)
  camera.near_m = 1e-3 * glm::length(target - eye);
  return camera;
}

Camera LookDown(double height, double size_m) {
  Camera camera;
  camera.eye_ws = {0, height, 0};
  camera.target_ws = {0, 0, 0};
  camera.forward_ws = {0, -1, 0};
  camera.right_ws = {1, 0, 0};
  camera.up_ws = {0, 0, -1};
  camera.is_orthographic = true;
  camera.ortho_height_m = size_m;
  camera.near_m = 1e-3 * height;
  camera.far_m = 10 * height;
  return camera;
}

Image RenderVisibility(const FlatScene& scene, RenderRequest request, RenderReport* report) {
  request.outputs = {OutputKind::kVisibility};
  auto result = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("test");
  EXPECT_OK(result);
  if (!result.ok()) return Image();
  if (report != nullptr) *report = result->report;
  return std::move(result->images[0].image);
}

uint64_t ResolveCount(const RenderReport& report) {
  for (const PassReport& pass : report.passes) {
    if (pass.name == "light[0]/resolve") return pass.count;
  }
  return 0;
}

std::vector<TestMethod> TestMethods() {
  // k points of a digital net hold an anchored rectangle's share of the light to (log2(k) / 2 + 3 / 2) / k
  // (Niederreiter 1987, (0, m, 2)-nets in base 2).
  constexpr double kNetOf256 = 5.5 / 256;
  return {
      {.name = "hard", .options = HardOptions{512}, .others = {HardOptions{16}, HardOptions{1000}}},
      {.name = "multi_map",
       .options = MultiMapOptions{32, 512},
       .fine = MultiMapOptions{256, 512},
       .fine_samples = 256,
       .fine_step = kNetOf256,
       .others = {MultiMapOptions{1, 64}, MultiMapOptions{3, 16}, MultiMapOptions{8, 100}}},
      {.name = "ray",
       .options = RayOptions{64},
       .fine = RayOptions{256},
       .fine_samples = 256,
       .fine_step = kNetOf256,
       .others = {RayOptions{1}, RayOptions{7}, RayOptions{256, true, 0.02f}, RayOptions{64, true, 0.9f}}},
      // A blocker that no tap of the search meets covers less than half a tap's width of the light; each axis of
      // the filter is off by half a tap.
      {.name = "pcss",
       .options = PcssOptions{512, 7, 15},
       .fine = PcssOptions{1024, 31, 63},
       .fine_step = 1.0 / 62 + 2.0 / 126,
       .others = {PcssOptions{16, 1, 1}, PcssOptions{100, 3, 31}, PcssOptions{64, 7, 15, FilterWeights::kGaussian},
                  PcssOptions{256, 7, 15, FilterWeights::kMean, false}}},
      // A patch's image has straight edges whatever its size: what is left is half a texel.
      {.name = "ssm",
       .options = SsmOptions{.occluder_map_size = 256, .sub_lights = 2},
       .fine = SsmOptions{.occluder_map_size = 512, .sub_lights = 4},
       .others = {SsmOptions{.occluder_map_size = 16, .sub_lights = 1, .bins = 1, .measures_coverage = false},
                  SsmOptions{.occluder_map_size = 100, .passes = 2, .sub_lights = 3, .bins = 16},
                  SsmOptions{.occluder_map_size = 64, .sub_lights = 8, .bins = 2},
                  SsmOptions{.occluder_map_size = 64, .sub_lights = 2, .projects_map = true},
                  SsmOptions{.occluder_map_size = 16,
                             .sub_lights = 1,
                             .measures_coverage = false,
                             .accumulation = SsmAccumulation::kScatter,
                             .projects_map = true},
                  SsmOptions{.occluder_map_size = 16,
                             .passes = 2,
                             .sub_lights = 3,
                             .accumulation = SsmAccumulation::kScatter,
                             .blend = SsmBlend::kFp16Batched,
                             .projects_map = true}}},
      {.name = "pdsm",
       .options = PdsmOptions{.k = 32, .eps = 0.016f},
       .fine = PdsmOptions{.k = 256},
       .fine_samples = 256,
       .fine_step = kNetOf256,
       .others = {PdsmOptions{.k = 4, .map_size = 64, .pdsm_size = 16},
                  PdsmOptions{.k = 7,
                              .map_size = 16,
                              .pdsm_size = 100,
                              .eps = 0.1f,
                              .construction = PdsmConstruction::kScatter,
                              .layout = PdsmLayout::kIndexed,
                              .filter = PdsmFilter::kWide3},
                  PdsmOptions{.k = 4,
                              .map_size = 32,
                              .pdsm_size = 32,
                              .eps = 0.2f,
                              .construction = PdsmConstruction::kTraversal,
                              .layout = PdsmLayout::kIndexed,
                              .filter = PdsmFilter::kNearest},
                  PdsmOptions{.k = 16,
                              .map_size = 128,
                              .pdsm_size = 64,
                              .eps = 0.01f,
                              .construction = PdsmConstruction::kScatter,
                              .layout = PdsmLayout::kIndexed,
                              .has_soft_events = true},
                  PdsmOptions{.k = 16,
                              .map_size = 128,
                              .pdsm_size = 64,
                              .eps = 0.04f,
                              .construction = PdsmConstruction::kScatter,
                              .layout = PdsmLayout::kIndexed,
                              .is_surface_only = true}}},
      {.name = "sssm",
       .options = SssmOptions{512, 9, 21, FilterWeights::kMean},
       .fine = SssmOptions{1024, 31, 63, FilterWeights::kMean},
       .fine_step = 1.0 / 62 + 2.0 / 126,
       .others = {SssmOptions{16, 1, 1}, SssmOptions{100, 3, 31}, SssmOptions{256, 9, 21, FilterWeights::kMean, false},
                  SssmOptions{64, 9, 21, FilterWeights::kGaussian, true, 0.5f, 0, SssmThresholds::kAbsolute, 2}}},
      // What 16 rows miss at two edges across and two along them: tests/renderer/shadow/shaft.
      {.name = "shaft",
       .options = ShaftOptions{8},
       .fine = ShaftOptions{16},
       .fine_samples = 512,
       .fine_step = (4 * (4.0 / 3 + 1) + 2) / 512,
       .shared_samples = 256,
       .others = {ShaftOptions{32}, ShaftOptions{64}, ShaftOptions{}, ShaftOptions{8, true}}}};
}

std::vector<TestMethod> SoftShadowMapForms() {
  const SsmOptions scatter = {.occluder_map_size = 128,
                              .sub_lights = 1,
                              .measures_coverage = false,
                              .accumulation = SsmAccumulation::kScatter,
                              .projects_map = true};
  SsmOptions twice = scatter, batched = scatter;
  twice.passes = 2;
  batched.blend = SsmBlend::kFp16Batched;
  return {{.name = "ssm_map",
           .options = SsmOptions{.occluder_map_size = 256, .sub_lights = 2, .projects_map = true},
           .fine = SsmOptions{.occluder_map_size = 512, .sub_lights = 4, .projects_map = true}},
          {.name = "ssm_scatter", .options = scatter},
          {.name = "ssm_scatter_twice", .options = twice},
          {.name = "ssm_scatter_batched", .options = batched}};
}

}  // namespace halfshade
