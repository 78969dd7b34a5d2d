// What this server refuses beyond. Each has a flag of halfshaded, and a line in GetServerInfo
// where v1 has a field for it.
#pragma once

#include <cstdint>

namespace halfshade {

struct Limits {
  uint64_t message_bytes = 8ull << 20;
  uint64_t metadata_bytes = 16ull << 10;
  uint32_t streams_per_connection = 64;
  uint32_t image_width = 8192;
  uint32_t image_height = 8192;
  uint64_t scene_bytes = 512ull << 20;
  uint64_t scene_triangles = 20'000'000;
  uint32_t lights = 64;
  uint64_t texture_pixels = 64ull << 20;
  uint64_t gltf_json_bytes = 64ull << 20;
  uint32_t gltf_json_depth = 64;
  uint32_t queue = 64;                       // requests that may wait for a context
  uint32_t unfinished_uploads = 256;         // under way or cut
  uint64_t render_reply_bytes = 4ull << 20;  // uncompressed images of one Render reply
};

}  // namespace halfshade
