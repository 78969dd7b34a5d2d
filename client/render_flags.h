// The flags of `halfshade render` -> the RenderRequest that is sent.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "halfshade/v1/render.pb.h"

namespace halfshade {

// As given; empty or absent: not given.
struct RenderFlags {
  std::string scene;  // "-": a file names it
  std::string request_file;
  std::string view_file;
  std::string camera;
  std::optional<uint32_t> camera_index;
  std::vector<std::string> lights;
  std::string ground;
  std::string size;
  std::string method;
  std::vector<std::string> options;  // KEY=VALUE
  std::optional<double> max_error;
  std::optional<double> max_latency_ms;
  std::string certify;  // PIXELS,RAYS
  std::optional<uint32_t> seed;
  std::optional<uint32_t> expected_frames;
  std::string cache;                 // use, refresh
  std::vector<std::string> outputs;  // FILE, KIND=FILE
};

struct PreparedRender {
  v1::RenderRequest request;  // scene is "scenes/<hex>", or else the path of a file
  // Of request.outputs, in order; "": it is a layer of a file before it. Empty: nothing is written.
  std::vector<std::string> files;
};

// "WIDTHxHEIGHT", whole numbers of at least 1. Usage error naming `flag`.
absl::StatusOr<std::pair<uint32_t, uint32_t>> ReadSize(const std::string& flag, const std::string& text);

// The request file, then the view over it, then the other flags over both. Reads the two files and nothing else.
// Errors: usage (64), NOT_FOUND for an absent file, INVALID_ARGUMENT for a file's content.
absl::StatusOr<PreparedRender> PrepareRender(const RenderFlags& flags);

}  // namespace halfshade
