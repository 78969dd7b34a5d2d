#include "server/flags.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <vector>

namespace halfshade {
namespace {

constexpr int kUsage = 64;

void AddConnectionTimes(CLI::App& app, ConnectionTimes* times) {
  const auto add = [&app](const char* name, int* ms, const char* what) {
    app.add_option(name, *ms, what)->check(CLI::Range(1, 86'400'000))->capture_default_str();
  };
  add("--handshake-ms", &times->handshake_ms, "for a connection's first bytes");
  add("--connection-age-ms", &times->age_ms, "then a connection is asked to go");
  add("--connection-age-grace-ms", &times->age_grace_ms, "and has so long for its calls");
  add("--connection-idle-ms", &times->idle_ms, "without calls, then a connection is closed");
  add("--keepalive-ms", &times->keepalive_ms, "of silence before a ping");
  add("--keepalive-timeout-ms", &times->keepalive_timeout_ms, "for its answer");
}

void AddLimits(CLI::App& app, Limits* limits) {
  app.add_option("--max-message-bytes", limits->message_bytes, "largest message received")
      ->check(CLI::Range(uint64_t(1) << 16, uint64_t(1) << 30));
  app.add_option("--max-metadata-bytes", limits->metadata_bytes, "largest metadata received");
  app.add_option("--max-streams", limits->streams_per_connection, "concurrent calls of a connection");
  app.add_option("--max-image-width", limits->image_width, "pixels")->check(CLI::Range(1, 16384));
  app.add_option("--max-image-height", limits->image_height, "pixels")->check(CLI::Range(1, 16384));
  app.add_option("--max-scene-bytes", limits->scene_bytes, "bytes of a scene, and of one blob");
  app.add_option("--max-scene-triangles", limits->scene_triangles, "triangles of a scene");
  app.add_option("--max-lights", limits->lights, "lights of a request");
  app.add_option("--max-texture-pixels", limits->texture_pixels, "pixels of a texture");
  app.add_option("--max-gltf-json-bytes", limits->gltf_json_bytes, "bytes of a glTF's JSON");
  app.add_option("--max-gltf-json-depth", limits->gltf_json_depth, "depth of a glTF's JSON");
  app.add_option("--queue", limits->queue, "renders that may wait for a context")->check(CLI::Range(1, 1 << 20));
  app.add_option("--max-unfinished-uploads", limits->unfinished_uploads, "uploads under way or cut, of all clients")
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--max-render-reply-bytes", limits->render_reply_bytes, "uncompressed images of one Render reply");
}

// In the folder of this program.
std::string ProgramBeside(const char* name) {
  std::error_code error;
  return (std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / name).string();
}

}  // namespace

bool IsLoopback(const std::string& address) {
  if (address.starts_with("unix:")) return true;
  const std::string host = address.substr(0, address.rfind(':'));
  return host.starts_with("127.") || host == "localhost" || host == "[::1]";
}

int ParseDaemonFlags(int argc, const char* const* argv, DaemonFlags* flags) {
  ServerOptions& options = flags->options;
  options.listen = "127.0.0.1:50051";
  CLI::App app("halfshaded: soft shadows over gRPC");
  app.add_option("--listen", options.listen, "HOST:PORT (port 0 picks one) or unix:PATH")->capture_default_str();
  app.add_option("--http", options.http, "HOST:PORT of /livez, /readyz and /metrics, or off")->capture_default_str();
  app.add_option("--admin", options.admin, "HOST:PORT or unix:PATH of channelz: who is connected, or off")
      ->capture_default_str();
  app.add_option("--scene-store", options.scene_store_dir,
                 "folder that keeps scenes; default: a private temporary one");
  app.add_option("--scene-store-mb", options.scene_store_mb, "its bound, unfinished uploads included")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--scene-cache-mb", options.scene_cache_mb, "loaded scenes in memory")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--gl-scene-mb", options.gl_scene_mb, "scenes in GL memory, of all contexts together")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--light-cache-mb", options.light_cache_mb,
                 "shadow maps and other light data in GL memory, of all contexts together")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--view-cache-mb", options.view_cache_mb,
                 "what cameras saw, for lights that move before them, of all contexts together")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--ray-scene-mb", options.ray_scene_mb,
                 "what rays (two thirds) and shaft have of scenes on the CPU, of all contexts together")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  app.add_option("--result-cache-mb", options.result_cache_mb, "encoded replies, for identical requests; 0: none")
      ->check(CLI::Range(0, 1 << 30))
      ->capture_default_str();
  std::string gl = "auto";
  app.add_option("--gl", gl, "auto, egl or osmesa")->check(CLI::IsMember({"auto", "egl", "osmesa"}));
  app.add_option("--egl-device", options.gl.egl_device, "which EGL device")->check(CLI::NonNegativeNumber);
  app.add_option("--contexts", options.contexts,
                 "GL contexts, a thread each; of software drivers they take turns at GL")
      ->check(CLI::Range(1, 64));
  app.add_option("--canary-ms", options.canary_ms, "a context that is idle for so long shows that it still draws")
      ->check(CLI::Range(10, 3'600'000))
      ->capture_default_str();
  app.add_option("--grace-s", options.grace_s, "after SIGTERM: time for calls under way")->check(CLI::Range(0, 3600));
  app.add_option("--lame-duck-s", options.lame_duck_s, "after SIGTERM: NOT_SERVING, still taking calls")
      ->check(CLI::Range(0, 3600));
  app.add_option("--in-flight-mb", options.in_flight_mb,
                 "images that are drawn, encoded or sent at the same time, before compression")
      ->capture_default_str()
      ->check(CLI::Range(1, 1 << 20));
  app.add_option("--stream-stall-s", options.stream_stall_s,
                 "a reader of RenderStream that takes nothing for so long is dropped")
      ->capture_default_str()
      ->check(CLI::Range(1, 3600));
  options.fence.loader = ProgramBeside("halfshade-scene-loader");
  app.add_option(
         "--scene-loader", options.fence.loader,
         "program that reads scenes and images, a process each without privileges; none: this process reads them")
      ->capture_default_str();
  app.add_option("--loader-memory-mb", options.fence.memory_mb, "that such a process may take")
      ->check(CLI::Range(64, 1 << 20))
      ->capture_default_str();
  app.add_option("--loader-cpu-s", options.fence.cpu_s, "of CPU time, and a second more for each 4 MiB that it reads")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  app.add_option("--loader-wall-s", options.fence.wall_s, "until it ends, likewise")
      ->check(CLI::Range(1, 3600))
      ->capture_default_str();
  bool insecure_bind = false;
  app.add_flag("--insecure-bind", insecure_bind, "allow an address beyond loopback without TLS and token");
  app.add_option("--log-level", flags->log_level, "trace, debug, info, warn, error, off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}));
  AddConnectionTimes(app, &options.connections);
  std::string log_format = "text";
  app.add_option("--log-format", log_format, "text, or json: an object a line")->check(CLI::IsMember({"text", "json"}));
  AddLimits(app, &options.limits);
  std::vector<std::string> later_given;
  for (const char* later : {"--tls-cert", "--tls-key", "--client-ca", "--token-file"}) {
    app.add_option_function<std::string>(
        later, [&later_given, later](const std::string&) { later_given.emplace_back(later); },
        "not available in this version");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  if (!later_given.empty()) {
    std::fprintf(stderr, "%s: not available in this version\n", later_given[0].c_str());
    return kUsage;
  }
  for (const auto& [flag, address] : {std::pair("--listen", options.listen), std::pair("--admin", options.admin)}) {
    if (insecure_bind || address == "off" || IsLoopback(address)) continue;
    std::fprintf(stderr, "%s %s: reachable from outside without TLS and token; give --insecure-bind if that is meant\n",
                 flag, address.c_str());
    return kUsage;
  }
  if (options.fence.loader == "none") options.fence.loader = "";
  flags->is_json_log = log_format == "json";
  options.gl.backend = gl == "egl" ? gl::Backend::kEgl : gl == "osmesa" ? gl::Backend::kOsmesa : gl::Backend::kAuto;
  return -1;
}

}  // namespace halfshade
