#include "renderer/shadow/pdsm/stored_functions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace halfshade::pdsm {
namespace {

static_assert(std::endian::native == std::endian::little);

// Raised whenever other functions come of the same maps, or the same in another form.
constexpr char kMagic[16] = "halfshade pdsm1";
constexpr int kMaxSize = 1 << 14;
constexpr size_t kMaxSlices = 255;

// FNV-1a over words of 64 bits, and the bytes that are left. Against accidents; who can write to the store can do as he
// likes, and numbers are checked below.
uint64_t Checksum(const char* bytes, size_t count) {
  constexpr uint64_t kPrime = 0x100000001b3;
  uint64_t sum = 0xcbf29ce484222325;
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    uint64_t word;
    std::memcpy(&word, bytes + i, 8);
    sum = (sum ^ word) * kPrime;
    sum ^= sum >> 32;  // high bits reach low ones
  }
  for (; i < count; ++i) sum = (sum ^ uint8_t(bytes[i])) * kPrime;
  return sum;
}

class Writer {
 public:
  template <typename T>
  void Add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  template <typename T>
  void AddAll(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    Add(uint64_t(values.size()));
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  Reader(const char* bytes, size_t count) : at_(bytes), left_(count) {}
  template <typename T>
  bool Get(T* value) {
    if (left_ < sizeof(T)) return false;
    std::memcpy(static_cast<void*>(value), at_, sizeof(T));
    at_ += sizeof(T);
    left_ -= sizeof(T);
    return true;
  }
  template <typename T>
  bool GetAll(std::vector<T>* values) {
    uint64_t count = 0;
    if (!Get(&count) || count > left_ / sizeof(T)) return false;
    values->resize(count);
    std::memcpy(static_cast<void*>(values->data()), at_, count * sizeof(T));
    at_ += count * sizeof(T);
    left_ -= count * sizeof(T);
    return true;
  }
  bool IsAtEnd() const { return left_ == 0; }

 private:
  const char* at_;
  size_t left_;
};

bool IsUsable(const Grid& grid) {
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0; };
  return grid.size > 0 && grid.size <= kMaxSize && grid.map_size > 0 && grid.map_size <= kMaxSize &&
         grid.map_texels > 0 && grid.map_texels <= kMaxSize && is_positive(grid.texel.x) && is_positive(grid.texel.y) &&
         std::isfinite(grid.corner.x) && std::isfinite(grid.corner.y) && is_positive(grid.z_near);
}

bool AreUsable(const AttenuationFunctions& functions) {
  const size_t rays = size_t(functions.size) * functions.size;
  if (functions.first.size() != rays + 1 || functions.first[0] != 0 ||
      functions.first.back() != functions.vertices.size() ||
      !std::is_sorted(functions.first.begin(), functions.first.end())) {
    return false;
  }
  for (size_t ray = 0; ray < rays; ++ray) {
    float depth = 1;
    for (const Vertex& vertex : functions.Function(ray)) {
      if (!(vertex.depth >= 0 && vertex.depth <= depth && vertex.value >= 0 && vertex.value <= 1)) return false;
      depth = vertex.depth;
    }
  }
  return true;
}

bool IsUsable(const SliceVolume& volume) {
  const size_t slices = volume.depths.size();
  return slices >= 2 && slices <= kMaxSlices && volume.maps > 0 &&
         volume.counts.size() == slices * volume.size * volume.size &&
         std::all_of(volume.counts.begin(), volume.counts.end(), [&](const SliceCounts& counts) {
           return counts.hidden <= volume.maps && counts.hidden_from_beyond <= counts.hidden;
         });
}

}  // namespace

std::string Store(const StoredFunctions& stored) {
  Writer writer;
  writer.Add(kMagic);
  writer.Add(uint64_t(0));  // the checksum's place
  const size_t begin = writer.bytes().size();
  const Grid& grid = stored.grid;
  writer.Add(int32_t(grid.size));
  writer.Add(int32_t(grid.map_size));
  writer.Add(int32_t(grid.map_texels));
  writer.Add(uint32_t(stored.functions.index()));
  for (const double value : {grid.corner.x, grid.corner.y, grid.texel.x, grid.texel.y, grid.z_near}) writer.Add(value);
  if (const auto* functions = std::get_if<AttenuationFunctions>(&stored.functions)) {
    writer.AddAll(functions->first);
    writer.AddAll(functions->vertices);
  } else {
    const auto& volume = std::get<SliceVolume>(stored.functions);
    writer.Add(int32_t(volume.maps));
    writer.AddAll(volume.depths);
    writer.AddAll(volume.counts);
  }
  std::string bytes = std::move(writer.bytes());
  const uint64_t checksum = Checksum(bytes.data() + begin, bytes.size() - begin);
  std::memcpy(bytes.data() + begin - sizeof(checksum), &checksum, sizeof(checksum));
  return bytes;
}

std::optional<StoredFunctions> Restore(const std::string& bytes) {
  Reader head(bytes.data(), bytes.size());
  char magic[sizeof(kMagic)];
  uint64_t checksum = 0;
  if (!head.Get(&magic) || std::memcmp(magic, kMagic, sizeof(kMagic)) != 0 || !head.Get(&checksum)) return {};
  const size_t begin = sizeof(kMagic) + sizeof(checksum);
  if (Checksum(bytes.data() + begin, bytes.size() - begin) != checksum) return {};
  Reader reader(bytes.data() + begin, bytes.size() - begin);
  StoredFunctions stored;
  Grid& grid = stored.grid;
  int32_t size = 0, map_size = 0, map_texels = 0;
  uint32_t form = 0;
  if (!reader.Get(&size) || !reader.Get(&map_size) || !reader.Get(&map_texels) || !reader.Get(&form)) return {};
  grid.size = size;
  grid.map_size = map_size;
  grid.map_texels = map_texels;
  for (double* value : {&grid.corner.x, &grid.corner.y, &grid.texel.x, &grid.texel.y, &grid.z_near}) {
    if (!reader.Get(value)) return {};
  }
  if (!IsUsable(grid)) return {};
  if (form == 0) {
    AttenuationFunctions functions;
    functions.size = size;
    if (!reader.GetAll(&functions.first) || !reader.GetAll(&functions.vertices) || !AreUsable(functions)) return {};
    stored.functions = std::move(functions);
  } else {
    SliceVolume volume;
    int32_t maps = 0;
    if (!reader.Get(&maps) || !reader.GetAll(&volume.depths) || !reader.GetAll(&volume.counts)) return {};
    volume.size = size;
    volume.maps = maps;
    if (form != 1 || !IsUsable(volume)) return {};
    stored.functions = std::move(volume);
  }
  if (!reader.IsAtEnd()) return {};
  return stored;
}

}  // namespace halfshade::pdsm
