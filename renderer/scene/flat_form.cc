#include "renderer/scene/flat_form.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "renderer/scene/check_flat_scene.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

static_assert(std::endian::native == std::endian::little);
// A field more belongs below, and into the version.
static_assert(sizeof(FlatScene) == 31 * sizeof(std::vector<int>) + 2 * sizeof(uint64_t));
static_assert(sizeof(Mesh) == 80 && sizeof(Cluster) == 32 && sizeof(Node) == 200 && sizeof(Material) == 128);
static_assert(sizeof(Texture) == 12 && sizeof(EncodedImage) == 72 && sizeof(SceneCamera) == 72);
static_assert(sizeof(Animation) == 48 && sizeof(Rest) == 88);

constexpr char kMagic[8] = {'H', 'S', 'F', 'L', 'A', 'T', '\r', '\n'};
constexpr size_t kChecksumBytes = sizeof(XXH64_hash_t);
constexpr size_t kBufferBytes = 64 << 10;

// Bytes as they stand in memory, none of them padding.
template <typename T>
inline constexpr bool kIsPlain = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;
template <glm::length_t N, typename T>
inline constexpr bool kIsPlain<glm::vec<N, T>> = true;
template <glm::length_t N, typename T>
inline constexpr bool kIsPlain<glm::mat<N, N, T>> = true;
template <typename T>
inline constexpr bool kIsPlain<glm::qua<T>> = true;
template <>
inline constexpr bool kIsPlain<Box3f> = sizeof(Box3f) == 6 * sizeof(float);
template <>
inline constexpr bool kIsPlain<InstancePlace> = sizeof(InstancePlace) == 10 * sizeof(float);
template <>
inline constexpr bool kIsPlain<BindVertex> = sizeof(BindVertex) == 10 * sizeof(float);
template <>
inline constexpr bool kIsPlain<Influence> = sizeof(Influence) == 8;
template <>
inline constexpr bool kIsPlain<MorphDelta> = sizeof(MorphDelta) == 9 * sizeof(float);
template <>
inline constexpr bool kIsPlain<Cluster> = sizeof(Cluster) == 32;
template <>
inline constexpr bool kIsPlain<Skin> = sizeof(Skin) == 8;
template <>
inline constexpr bool kIsPlain<Deformed> = sizeof(Deformed) == 36;
template <typename T>
inline constexpr bool kIsPlain<T*> = false;

// What the form holds, in its order, once for both directions.
constexpr auto kFields = [](auto& io, auto& it) {
  using T = std::remove_cvref_t<decltype(it)>;
  if constexpr (std::is_same_v<T, Mesh>) {
    io(it.origin, it.first_vertex, it.vertex_count, it.first_index, it.index_count, it.first_cluster, it.cluster_count,
       it.material, it.bounds);
  } else if constexpr (std::is_same_v<T, Node>) {
    io(it.name, it.parent, it.local, it.first_mesh, it.mesh_count, it.camera, it.skin, it.first_place, it.place_count,
       it.first_weight, it.weight_count);
  } else if constexpr (std::is_same_v<T, SceneRoots>) {
    io(it.name, it.roots);
  } else if constexpr (std::is_same_v<T, MaterialTexture>) {
    io(it.texture, it.texcoord);
  } else if constexpr (std::is_same_v<T, Material>) {
    io(it.name, it.base_color, it.base_color_texture, it.metallic, it.roughness, it.metallic_roughness_texture,
       it.normal_texture, it.normal_scale, it.occlusion_texture, it.occlusion_strength, it.emissive,
       it.emissive_texture, it.alpha_mode, it.alpha_cutoff, it.is_double_sided);
  } else if constexpr (std::is_same_v<T, Texture>) {
    io(it.image, it.wrap_s, it.wrap_t, it.magnifies_to_nearest, it.minifies_to_nearest, it.mip_filter);
  } else if constexpr (std::is_same_v<T, EncodedImage>) {
    io(it.name, it.bytes, it.width, it.height);
  } else if constexpr (std::is_same_v<T, SceneCamera>) {
    io(it.name, it.is_orthographic, it.fovy_rad, it.ortho_height_m, it.near_m, it.far_m);
  } else if constexpr (std::is_same_v<T, AnimationChannel>) {
    io(it.node, it.path, it.interpolation, it.first_time, it.key_count, it.first_value, it.width);
  } else if constexpr (std::is_same_v<T, Animation>) {
    io(it.name, it.first_channel, it.channel_count, it.duration_s);
  } else if constexpr (std::is_same_v<T, Rest>) {
    io(it.node, it.translation, it.rotation, it.scale);
  } else {
    static_assert(std::is_same_v<T, FlatScene>);
    io(it.positions, it.normals, it.texcoords, it.texcoords1, it.tangents, it.colors, it.indices, it.meshes,
       it.clusters, it.materials, it.textures, it.images, it.nodes, it.cameras, it.scenes, it.default_scene, it.places,
       it.morph_weights, it.skins, it.skin_joints, it.joint_from_mesh, it.deformed, it.bind_vertices, it.bind_indices,
       it.influences, it.morph_deltas, it.animations, it.channels, it.animation_times, it.animation_values, it.rests,
       it.warnings, it.degenerate_triangles_dropped);
  }
};

class Writer {
 public:
  explicit Writer(const ByteSink& sink) : sink_(sink) { XXH3_64bits_reset(&hash_); }

  template <typename... Values>
  void operator()(const Values&... values) {
    (Put(values), ...);
  }
  void Bytes(const void* bytes, size_t size) {
    if (!ok_ || size == 0) return;
    XXH3_64bits_update(&hash_, bytes, size);
    if (buffer_.size() + size > kBufferBytes) Flush();
    if (size > kBufferBytes) {
      ok_ = ok_ && sink_(bytes, size);
    } else {
      buffer_.append(static_cast<const char*>(bytes), size);
    }
  }
  bool Finish() {
    const XXH64_hash_t checksum = XXH3_64bits_digest(&hash_);
    Bytes(&checksum, kChecksumBytes);
    Flush();
    return ok_;
  }

 private:
  template <typename T>
  void Put(const T& value) {
    if constexpr (kIsPlain<T> || std::is_enum_v<T>) {
      Bytes(&value, sizeof(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      Put(uint8_t(value));
    } else {
      kFields(*this, value);
    }
  }
  void Put(const std::string& text) {
    Put(uint64_t(text.size()));
    Bytes(text.data(), text.size());
  }
  template <typename T>
  void Put(const std::vector<T>& values) {
    Put(uint64_t(values.size()));
    if constexpr (kIsPlain<T>) {
      Bytes(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) Put(value);
    }
  }
  void Flush() {
    ok_ = ok_ && (buffer_.empty() || sink_(buffer_.data(), buffer_.size()));
    buffer_.clear();
  }

  const ByteSink& sink_;
  XXH3_state_t hash_;
  std::string buffer_;
  bool ok_ = true;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}

  template <typename... Values>
  void operator()(Values&... values) {
    (Get(values), ...);
  }
  // Nothing was missing, nothing is left over.
  bool IsDone() const { return ok_ && left_.empty(); }

 private:
  void Bytes(void* bytes, size_t size) {
    ok_ = ok_ && size <= left_.size();
    if (!ok_ || size == 0) return;
    std::memcpy(bytes, left_.data(), size);
    left_.remove_prefix(size);
  }
  // Of elements that take at least `element_bytes` each.
  size_t Count(size_t element_bytes) {
    uint64_t count = 0;
    Bytes(&count, sizeof(count));
    ok_ = ok_ && count <= left_.size() / element_bytes;
    return ok_ ? size_t(count) : 0;
  }
  template <typename T>
  void Get(T& value) {
    if constexpr (kIsPlain<T> || std::is_enum_v<T>) {
      Bytes(&value, sizeof(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      uint8_t byte = 0;
      Get(byte);
      ok_ = ok_ && byte <= 1;
      value = byte != 0;
    } else {
      kFields(*this, value);
    }
  }
  void Get(std::string& text) {
    text.resize(Count(1));
    Bytes(text.data(), text.size());
  }
  template <typename T>
  void Get(std::vector<T>& values) {
    if constexpr (kIsPlain<T>) {
      values.resize(Count(sizeof(T)));
      Bytes(values.data(), values.size() * sizeof(T));
    } else {
      // No element takes less than the count of its name, or a texture's nine bytes.
      for (size_t count = Count(8); ok_ && count > 0; --count) Get(values.emplace_back());
    }
  }

  std::string_view left_;
  bool ok_ = true;
};

absl::Status Unreadable(const std::string& why) { return absl::DataLossError("flat scene: " + why); }

}  // namespace

bool WriteFlatScene(const FlatScene& scene, const ByteSink& sink) {
  Writer writer(sink);
  writer.Bytes(kMagic, sizeof(kMagic));
  writer(kFlatFormVersion);
  kFields(writer, scene);
  return writer.Finish();
}

std::string FlatSceneBytes(const FlatScene& scene) {
  std::string bytes;
  WriteFlatScene(scene, [&bytes](const void* piece, size_t size) {
    bytes.append(static_cast<const char*>(piece), size);
    return true;
  });
  return bytes;
}

absl::StatusOr<FlatScene> ReadFlatScene(std::string_view bytes) {
  constexpr size_t kHeaderBytes = sizeof(kMagic) + sizeof(kFlatFormVersion);
  if (bytes.size() < kHeaderBytes + kChecksumBytes || std::memcmp(bytes.data(), kMagic, sizeof(kMagic)) != 0) {
    return Unreadable("these " + std::to_string(bytes.size()) + " bytes are none");
  }
  uint32_t version = 0;
  std::memcpy(&version, bytes.data() + sizeof(kMagic), sizeof(version));
  if (version != kFlatFormVersion) {
    return Unreadable("version " + std::to_string(version) + "; this build reads " + std::to_string(kFlatFormVersion));
  }
  XXH64_hash_t checksum = 0;
  std::memcpy(&checksum, bytes.end() - kChecksumBytes, kChecksumBytes);
  bytes.remove_suffix(kChecksumBytes);
  if (XXH3_64bits(bytes.data(), bytes.size()) != checksum) return Unreadable("its checksum is wrong");
  Reader reader(bytes.substr(kHeaderBytes));
  FlatScene scene;
  kFields(reader, scene);
  if (!reader.IsDone()) return Unreadable("its counts do not fit its bytes");
  RETURN_IF_ERROR(CheckFlatScene(scene));
  return scene;
}

}  // namespace halfshade
