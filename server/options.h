// What a server is started with; each field is a flag of halfshaded.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "renderer/gl/context.h"
#include "server/fence.h"
#include "server/gl_worker.h"
#include "server/limits.h"

namespace halfshade {

// How long a connection may take for what.
struct ConnectionTimes {
  int handshake_ms = 10'000;
  int age_ms = 600'000;  // then it is asked to go, within the grace
  int age_grace_ms = 60'000;
  int idle_ms = 300'000;
  int keepalive_ms = 60'000;  // of silence before a ping, which is answered within the timeout
  int keepalive_timeout_ms = 20'000;
};

struct ServerOptions {
  std::string listen;           // "127.0.0.1:0" picks a port, "unix:PATH"; "": no port, InProcessChannel alone
  std::string http = "off";     // address of /livez, /readyz and /metrics, or "off"
  std::string admin = "off";    // address of channelz (who is connected, what is under way), or "off"
  std::string scene_store_dir;  // "": a private temporary folder, removed at the end
  uint64_t scene_store_mb = 4096;
  bool keeps_store = true;  // after the server's end: else no light data is written there
  uint64_t scene_cache_mb = 1024;
  uint64_t gl_scene_mb = 1024;     // scenes in GL memory, the contexts' equal shares together
  uint64_t light_cache_mb = 512;   // light data in GL memory, likewise
  uint64_t view_cache_mb = 256;    // what cameras saw, likewise
  uint64_t ray_scene_mb = 768;     // what rays (two thirds) and SHAFT have of scenes on the CPU, likewise
  uint64_t result_cache_mb = 256;  // replies as they were encoded; 0: none is kept
  FenceOptions fence;              // of `loader` "": scenes are read in this process, as is right for the caller's own
  gl::ContextOptions gl;
  int contexts = 1;
  int canary_ms = 10'000;        // a context that had nothing to do for so long shows that it draws
  int grace_s = 30;              // how long calls in flight may take once draining
  uint64_t in_flight_mb = 2048;  // images drawn, encoded or sent at the same time, before compression
  int stream_stall_s = 30;       // a reader of RenderStream that takes nothing for so long is dropped
  int lame_duck_s = 0;           // NOT_SERVING but still taking calls, before the grace begins
  ConnectionTimes connections;
  Limits limits;
  RendererFactory renderer_factory;  // empty: a GL context and its renderer; tests give a fake
};

}  // namespace halfshade
