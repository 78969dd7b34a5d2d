#include "renderer/scene_loader/container.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace halfshade {
namespace {

constexpr uint32_t kMagic = 0x46546c67;  // "glTF"
constexpr uint32_t kJsonChunk = 0x4e4f534a;
constexpr uint32_t kBinChunk = 0x004e4942;

uint32_t ReadU32(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

absl::Status GlbError(const std::string& fault) { return absl::InvalidArgumentError("GLB: " + fault); }

absl::StatusOr<GltfContainer> OpenGlb(const std::string& root) {
  if (root.size() < 12) return GlbError("the header is cut off after " + std::to_string(root.size()) + " bytes");
  const uint32_t version = ReadU32(root, 4);
  const uint32_t length = ReadU32(root, 8);
  if (version != 2) return GlbError("version " + std::to_string(version) + "; only 2 is supported");
  if (length > root.size()) {
    return GlbError("length " + std::to_string(length) + "; the file has " + std::to_string(root.size()) + " bytes");
  }
  GltfContainer container;
  container.is_glb = true;
  if (length < root.size()) {
    container.trailing_bytes = root.size() - length;
  }
  int chunks = 0;
  for (size_t at = 12; at < length; ++chunks) {
    if (at + 8 > length) return GlbError("chunk " + std::to_string(chunks) + ": its header is cut off");
    const uint32_t size = ReadU32(root, at);
    const uint32_t type = ReadU32(root, at + 4);
    at += 8;
    if (size > length - at) {
      return GlbError("chunk " + std::to_string(chunks) + ": " + std::to_string(size) + " bytes; " +
                      std::to_string(length - at) + " are left");
    }
    if (size % 4 != 0) return GlbError("chunk " + std::to_string(chunks) + ": its length is not a multiple of 4");
    if ((chunks == 0) != (type == kJsonChunk)) {
      return GlbError("chunk " + std::to_string(chunks) + ": the first chunk, and no other, must be JSON");
    }
    if (type == kJsonChunk) {
      container.json = root.substr(at, size);
    } else if (type == kBinChunk) {
      if (chunks != 1) return GlbError("chunk " + std::to_string(chunks) + ": BIN must be the second chunk");
      container.bin = root.data() + at;
      container.bin_size = size;
    }
    at += size;
  }
  if (chunks == 0) return GlbError("there is no JSON chunk");
  return container;
}

// Each costs a parser some hundred bytes; kMaxElements of glTF hold a few each.
constexpr uint32_t kMaxContainers = 4 << 20;

absl::Status ScanNesting(const std::string& json, uint32_t max_depth) {
  uint32_t depth = 0, containers = 0;
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      in_string = c != '"';
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{' || c == '[') {
      if (++depth > max_depth) {
        return absl::InvalidArgumentError("JSON: nested deeper than " + std::to_string(max_depth));
      }
      if (++containers > kMaxContainers) {
        return absl::InvalidArgumentError("JSON: over " + std::to_string(kMaxContainers) + " objects and arrays");
      }
    }
    if ((c == '}' || c == ']') && depth > 0) --depth;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<GltfContainer> OpenContainer(const std::string& root, const SceneLoadLimits& limits) {
  absl::StatusOr<GltfContainer> container = GltfContainer();
  if (root.size() >= 4 && ReadU32(root, 0) == kMagic) {
    container = OpenGlb(root);
    if (!container.ok()) return container;
  } else {
    container->json = root;
  }
  if (container->json.starts_with("\xef\xbb\xbf"))
    return absl::InvalidArgumentError("JSON: begins with a byte order mark (BOM)");
  if (container->json.size() > limits.max_json_bytes) {
    return absl::InvalidArgumentError("JSON: " + std::to_string(container->json.size()) + " bytes; at most " +
                                      std::to_string(limits.max_json_bytes));
  }
  if (const absl::Status status = ScanNesting(container->json, limits.max_json_depth); !status.ok()) return status;
  return container;
}

bool PercentDecode(const std::string& text, std::string* decoded) {
  decoded->clear();
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
  };
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      *decoded += text[i];
      continue;
    }
    if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0) return false;
    *decoded += char(digit(text[i + 1]) * 16 + digit(text[i + 2]));
    i += 2;
  }
  return true;
}

bool IsDataUri(const std::string& uri) {
  const std::string scheme = "data:";
  return uri.size() >= scheme.size() && std::equal(scheme.begin(), scheme.end(), uri.begin(), [](char a, char b) {
           return a == (b >= 'A' && b <= 'Z' ? b + ('a' - 'A') : b);
         });
}

bool DecodeDataUri(const std::string& uri, std::string* bytes) {
  const size_t comma = uri.find(',');
  if (comma == std::string::npos) return false;
  const std::string media_type = uri.substr(0, comma);
  if (!media_type.ends_with(";base64") || media_type.find(";;") != std::string::npos) return false;
  static const std::array<int8_t, 256> kValues = [] {
    std::array<int8_t, 256> values{};
    values.fill(-1);
    const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int i = 0; i < 64; ++i) values[uint8_t(digits[i])] = int8_t(i);
    return values;
  }();
  size_t end = uri.size();
  for (int padding = 0; padding < 2 && end > comma + 1 && uri[end - 1] == '='; ++padding) --end;
  bytes->clear();
  bytes->reserve((end - comma) / 4 * 3 + 3);
  uint32_t bits = 0;
  int count = 0;
  for (size_t i = comma + 1; i < end; ++i) {
    const int value = kValues[uint8_t(uri[i])];
    if (value < 0) return false;
    bits = bits << 6 | uint32_t(value);
    count += 6;
    if (count >= 8) {
      count -= 8;
      *bytes += char(bits >> count & 0xff);
    }
  }
  return count < 6;
}

}  // namespace halfshade
