// Rays per CPU second of TraceLight beside a bare Embree loop over the same receivers and points of the light. A
// program for people, not for CI: `trace_rate S5 .2 256 [WIDTHxHEIGHT]`.
#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "renderer/light/trace_light.h"
#include "renderer/math/sampling.h"
#include "renderer/scene/pose.h"
#include "tests/support/flat_scene_builder.h"
#include "tests/support/scene_makers.h"

namespace halfshade {
namespace {

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + double(time.tv_nsec) * 1e-9;
}

// A hierarchy of the same triangles, without any filter.
RTCScene MakeBareScene(const RayScene::Triangles& triangles) {
  const RTCDevice device = rtcNewDevice(nullptr);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, triangles.vertices.data(), 0,
                             sizeof(glm::vec4), triangles.vertices.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.indices.data(), 0,
                             3 * sizeof(uint32_t), triangles.indices.size() / 3);
  rtcCommitGeometry(geometry);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  return scene;
}

// What primary rays see of the scene and its ground, with normals.
CpuReceivers VisiblePoints(const RayScene& scene, RTCScene embree, const RenderRequest& request) {
  std::vector<glm::vec3> points, normals;
  const Camera& camera = request.camera;
  const double aspect = double(request.width) / request.height;
  for (int y = 0; y < request.height; ++y) {
    for (int x = 0; x < request.width; ++x) {
      const double ndc_x = 2 * (x + 0.5) / request.width - 1, ndc_y = 1 - 2 * (y + 0.5) / request.height;
      const glm::dvec3 ray =
          camera.forward_ws + (camera.right_ws * (ndc_x * aspect) + camera.up_ws * ndc_y) * camera.tan_half_fovy;
      const glm::vec3 origin(scene.TraceFromWorld(camera.eye_ws));
      RTCRayHit hit{};
      hit.ray = {origin.x, origin.y, origin.z, 0, float(ray.x), float(ray.y), float(ray.z), 0, INFINITY, ~0u, 0, 0};
      hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      rtcIntersect1(embree, &context, &hit);
      double t = hit.ray.tfar / scene.trace_scale();
      glm::dvec3 normal(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z);
      const double to_ground = (request.ground->height_m - camera.eye_ws.y) / ray.y;
      if (to_ground > 0 && to_ground < t) {
        t = to_ground;
        normal = {0, 1, 0};
      }
      if (!std::isfinite(t)) continue;
      if (glm::dot(normal, ray) > 0) normal = -normal;
      points.emplace_back(camera.eye_ws + ray * t);
      normals.emplace_back(glm::normalize(normal));
    }
  }
  return MakePointReceivers(points, normals);
}

enum class Bare { kPackets, kSingle };

// What anyone would write: packets of sixteen from an origin lifted off its plane, no filter; the points of the light
// are as coherent as TraceLight's, and moved for each receiver in the same way.
uint64_t TraceBare(const RayScene& scene, RTCScene embree, const AreaLight& light, const CpuReceivers& receivers,
                   int rays, Bare form) {
  std::vector<glm::uvec2> points;
  for (int i = 0; i < rays; ++i) points.emplace_back(OwenSobol2(uint32_t(i), 7) * 4294967296.0);
  std::sort(points.begin(), points.end(), [](const glm::uvec2& a, const glm::uvec2& b) {
    const auto cell = [](const glm::uvec2& p) { return (p.x >> 30) * 4 + (p.y >> 30); };
    return cell(a) < cell(b);
  });
  const glm::vec3 center(scene.TraceFromWorld(light.center_ws));
  const glm::vec3 u(light.axis_u_ws * light.width_m * scene.trace_scale());
  const glm::vec3 v(light.axis_v_ws * light.height_m * scene.trace_scale());
  std::atomic<uint64_t> visible{0};
  tbb::parallel_for(tbb::blocked_range<size_t>(0, receivers.size(), 64), [&](const tbb::blocked_range<size_t>& range) {
    uint64_t seen = 0;
    for (size_t i = range.begin(); i < range.end(); ++i) {
      const CpuReceiver receiver = receivers.At(i);
      if (!receiver.is_receiving || CutAtPlane(light, receivers, receiver).share <= 0) continue;
      const glm::vec3 origin =
          glm::vec3(scene.TraceFromWorld(receiver.position_ws)) + glm::vec3(receiver.normal_ws) * 1e-5f;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      const glm::uvec2 shift(uint32_t(i) * 0x9e3779b9u, uint32_t(i) * 0x85ebca6bu);
      glm::vec3 directions[16];
      for (int first = 0; first < rays; first += 16) {
        for (int k = 0; k < 16; ++k) {
          const glm::vec2 p = glm::vec2(glm::ivec2((points[first + k] ^ shift) >> 8u)) * 5.9604645e-8f - 0.5f;
          directions[k] = center + u * p.x + v * p.y - origin;
        }
        if (form == Bare::kPackets) {
          RTCRay16 packet;
          alignas(64) int valid[16];
          for (int k = 0; k < 16; ++k) {
            const glm::vec3& d = directions[k];
            packet.org_x[k] = origin.x, packet.org_y[k] = origin.y, packet.org_z[k] = origin.z;
            packet.dir_x[k] = d.x, packet.dir_y[k] = d.y, packet.dir_z[k] = d.z;
            packet.tnear[k] = 0, packet.tfar[k] = 1, packet.time[k] = 0, packet.mask[k] = ~0u, packet.flags[k] = 0;
            valid[k] = -1;
          }
          rtcOccluded16(valid, embree, &context, &packet);
          for (int k = 0; k < 16; ++k) seen += packet.tfar[k] >= 0;
        } else {
          for (int k = 0; k < 16; ++k) {
            const glm::vec3& d = directions[k];
            RTCRay ray = {origin.x, origin.y, origin.z, 0, d.x, d.y, d.z, 0, 1, ~0u, 0, 0};
            rtcOccluded1(embree, &context, &ray);
            seen += ray.tfar >= 0;
          }
        }
      }
    }
    visible += seen;
  });
  return visible;
}

int Main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "trace_rate SCENE LIGHT_SHARE RAYS [WIDTH HEIGHT]\n");
    return 64;
  }
  const MadeScene made = MakeScene(argv[1], {.light_share = std::atof(argv[2])});
  const int rays = std::atoi(argv[3]) / 16 * 16;
  const FlatScene scene = MakeFlatScene(made.meshes);
  RenderRequest request = RequestFor(made);
  request.width = argc > 5 ? std::atoi(argv[4]) : 320;
  request.height = argc > 5 ? std::atoi(argv[5]) : 180;
  const auto ray_scene = RayScene::Create(
      scene, *BuildPose(scene, 0), [](const EncodedImage&) { return absl::UnimplementedError("no masks here"); });
  const RTCScene bare_scene = MakeBareScene((*ray_scene)->triangles());
  const CpuReceivers receivers = VisiblePoints(**ray_scene, bare_scene, request);
  std::printf("%s: %zu triangles, %zu receivers, %d rays, scene and hierarchy %.1f MB\n", argv[1],
              (*ray_scene)->triangles().indices.size() / 3, receivers.size(), rays,
              double((*ray_scene)->SizeBytes()) / 1e6);
  const AreaLight& light = request.lights[0];
  std::vector<double> ours, bare, single;
  for (int run = 0; run < 5; ++run) {
    double begin = CpuSeconds();
    const auto traced =
        TraceLight(**ray_scene, light, receivers, {.rays = rays, .seed = 1}, [] { return absl::OkStatus(); });
    ours.push_back(CpuSeconds() - begin);
    begin = CpuSeconds();
    TraceBare(**ray_scene, bare_scene, light, receivers, rays, Bare::kPackets);
    bare.push_back(CpuSeconds() - begin);
    begin = CpuSeconds();
    TraceBare(**ray_scene, bare_scene, light, receivers, rays, Bare::kSingle);
    single.push_back(CpuSeconds() - begin);
  }
  const auto median = [](std::vector<double>& values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  const double million = double(receivers.size()) * rays * 1e-6;
  std::printf("Mrays per CPU second: TraceLight %.2f, bare packets of 16 %.2f, bare single rays %.2f\n",
              million / median(ours), million / median(bare), million / median(single));
  return 0;
}

}  // namespace
}  // namespace halfshade

int main(int argc, char** argv) { return halfshade::Main(argc, argv); }
