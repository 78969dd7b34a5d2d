#include "renderer/shadow/shaft/tile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

#include "renderer/math/camera.h"
#include "renderer/math/light_frame.h"
#include "renderer/shadow/shaft/sparse.h"

namespace halfshade {
namespace {

constexpr double kFourUlps = 4 * 1.1920929e-7;

double Size(const glm::dvec3& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); }

// A hash of (seed, receiver): splitmix64 (Steele, Lea and Flood 2014).
uint64_t Hash(uint32_t seed, uint32_t index) {
  uint64_t x = ((uint64_t(seed) << 32) | index) + 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

float Fraction(uint64_t bits) { return float(bits & 0xffffff) * 0x1p-24f; }

void CopyLane(int from, int to, Tile* tile) {
  for (float* values : {tile->x, tile->y, tile->z, tile->normal_x, tile->normal_y, tile->normal_z, tile->offset,
                        tile->error_m, tile->up_x, tile->up_y, tile->up, tile->shift_x, tile->shift_y}) {
    values[to] = values[from];
  }
}

// To the bit.
bool HaveOnePlane(const Tile& tile, int a, int b) {
  return tile.normal_x[a] == tile.normal_x[b] && tile.normal_y[a] == tile.normal_y[b] &&
         tile.normal_z[a] == tile.normal_z[b] && tile.offset[a] == tile.offset[b];
}

bool IsActive(const Tile& tile, int i) { return (tile.active[i / Tile::kLanes] >> (i % Tile::kLanes) & 1) != 0; }

// What follows from the active lanes; the others become copies of one of them. False: none is.
bool FinishLanes(Tile* tile) {
  const auto is_any = [](uint32_t lanes) { return lanes != 0; };
  const auto first_block = std::find_if(std::begin(tile->active), std::end(tile->active), is_any) - tile->active;
  if (first_block == Tile::kBlocks) return false;
  const int first_active = int(first_block) * Tile::kLanes + std::countr_zero(tile->active[first_block]);
  tile->shares_one_plane = true;
  for (int block = 0; block < Tile::kBlocks; ++block) {
    const int first = block * Tile::kLanes;
    const int model = tile->active[block] != 0 ? first + std::countr_zero(tile->active[block]) : first_active;
    tile->cut[block] &= tile->active[block];
    tile->shares_plane[block] = true;
    for (int i = first; i < first + Tile::kLanes; ++i) {
      if (!IsActive(*tile, i)) CopyLane(model, i, tile);
      tile->shares_plane[block] = tile->shares_plane[block] && HaveOnePlane(*tile, i, model);
    }
    tile->shares_one_plane =
        tile->shares_one_plane && tile->shares_plane[block] && HaveOnePlane(*tile, model, first_active);
  }
  return true;
}

// Of a row of bins along an axis of shaft space, from the least of a tile's receivers to the greatest of them.
struct Gap {
  static constexpr int kBins = 32;
  int axis = -1;  // below 0: there is none
  float low = 0, bins_per_length = 0;
  int first_beyond = 0;  // bin

  bool IsBeyond(const Tile& tile, int i) const { return BinOf(AlongAxis(tile)[i]) >= first_beyond; }
  int BinOf(float value) const { return std::min(kBins - 1, int((value - low) * bins_per_length)); }
  const float* AlongAxis(const Tile& tile) const { return axis == 0 ? tile.x : axis == 1 ? tile.y : tile.z; }
};

// The widest where no receiver of the tile is. Shaft space's unit is the light's edge: what is small beside that widens
// no hull.
Gap FindGap(const Tile& tile) {
  constexpr float kLeastExtent = 0.25f;
  constexpr int kLeastBins = 3;
  Gap widest;
  int most = kLeastBins - 1;
  for (int axis = 0; axis < 3; ++axis) {
    Gap gap;
    gap.axis = axis;
    const float* values = gap.AlongAxis(tile);
    const auto [low, high] = std::minmax_element(values, values + Tile::kMost);
    if (!(*high - *low > kLeastExtent)) continue;
    gap.low = *low;
    gap.bins_per_length = Gap::kBins / (*high - *low);
    uint32_t taken = 0;
    for (int i = 0; i < Tile::kMost; ++i) taken |= 1u << gap.BinOf(values[i]);
    int last = 0;  // bin that is taken
    for (; taken != 0; taken &= taken - 1) {
      gap.first_beyond = std::countr_zero(taken);
      if (gap.first_beyond - last - 1 > most) {
        most = gap.first_beyond - last - 1;
        widest = gap;
      }
      last = gap.first_beyond;
    }
  }
  return widest;
}

}  // namespace

bool KeepBlocks(uint32_t blocks, Tile* tile) {
  for (int block = 0; block < Tile::kBlocks; ++block) {
    if ((blocks >> block & 1) == 0) tile->active[block] = 0;
  }
  return FinishLanes(tile);
}

void SplitTile(Tile* tile, std::vector<Tile>* apart) {
  apart->clear();
  apart->reserve(kMostApart);  // none of them moves
  for (size_t k = 0; k <= apart->size() && apart->size() < kMostApart;) {
    Tile* near = k == 0 ? tile : &(*apart)[k - 1];
    const Gap gap = FindGap(*near);
    if (gap.axis < 0) {
      ++k;
      continue;
    }
    Tile* beyond = &apart->emplace_back(*near);
    for (int i = 0; i < Tile::kMost; ++i) {
      Tile* other = gap.IsBeyond(*beyond, i) ? near : beyond;
      other->active[i / Tile::kLanes] &= ~(1u << (i % Tile::kLanes));
    }
    FinishLanes(near);
    FinishLanes(beyond);
  }
}

TileFiller::TileFiller(const CpuReceivers& receivers, const AreaLight& light, const ShaftSpace& space, uint32_t seed,
                       bool is_sparse)
    : receivers_(receivers),
      space_(space),
      seed_(seed),
      width_(receivers.width),
      height_(receivers.height),
      is_sparse_(is_sparse),
      edges_(light.width_m, light.height_m) {
  if (is_sparse) {
    width_ = (width_ + SparseGrid::kBlock - 1) / SparseGrid::kBlock;
    height_ = (height_ + SparseGrid::kBlock - 1) / SparseGrid::kBlock;
  }
  if (receivers.ArePoints()) {
    tile_width_ = Tile::kMost;
    tile_height_ = 1;
    block_width_ = Tile::kLanes;
  }
  columns_ = (width_ + tile_width_ - 1) / tile_width_;
  rows_ = (height_ + tile_height_ - 1) / tile_height_;
  const LightFrame frame = MakeLightFrame(light);
  light_from_world_ = frame.light_from_world_rotation;
  eye_ls_ = PointToLight(frame, receivers.camera.eye_ws);
  ray_from_ndc_ = light_from_world_ * RayFromNdc(receivers.camera, double(receivers.width) / receivers.height);
}

bool TileFiller::Fill(int index, Tile* tile) const {
  const int left = index % columns_ * tile_width_, top = index / columns_ * tile_height_;
  const int block_height = Tile::kLanes / block_width_, blocks_across = tile_width_ / block_width_;
  tile->size_m = 0;
  tile->is_loose = false;
  PlaneInLight last = ToLight(glm::vec4(0));
  for (int block = 0; block < Tile::kBlocks; ++block) {
    tile->active[block] = tile->cut[block] = 0;
    tile->block_hash[block] = uint32_t(Hash(~seed_, uint32_t(index * Tile::kBlocks + block)) >> 32);
    for (int lane = 0; lane < Tile::kLanes; ++lane) {
      int x = left + block % blocks_across * block_width_ + lane % block_width_;
      int y = top + block / blocks_across * block_height + lane / block_width_;
      if (x >= width_ || y >= height_) continue;
      if (is_sparse_) {
        x = SparseGrid::PixelOf(x, receivers_.width);
        y = SparseGrid::PixelOf(y, receivers_.height);
      }
      const size_t receiver = size_t(y) * receivers_.width + x;
      const int i = block * Tile::kLanes + lane;
      const glm::dvec2 ndc(2 * (x + 0.5) / receivers_.width - 1, 1 - 2 * (y + 0.5) / receivers_.height);
      if (!receivers_.IsReceiving(receiver) || !FillLane(i, receiver, ndc, &last, tile)) continue;
      tile->active[block] |= 1u << lane;
      const float low = tile->up[i] + std::min(tile->up_x[i], 0.0f) + std::min(tile->up_y[i], 0.0f);
      if (!(low > 0)) tile->cut[block] |= 1u << lane;
    }
  }
  return FinishLanes(tile);
}

TileFiller::PlaneInLight TileFiller::ToLight(const glm::vec4& plane) const {
  PlaneInLight in_light;
  in_light.plane = plane;
  in_light.normal = light_from_world_ * glm::dvec3(plane);
  in_light.normal_in_shaft = space_.NormalFromLight(in_light.normal);
  in_light.middle = -(double(plane.w) + glm::dot(in_light.normal, eye_ls_));
  in_light.up = glm::dvec2(in_light.normal) * edges_;
  return in_light;
}

bool TileFiller::FillLane(int lane, size_t receiver, const glm::dvec2& ndc, PlaneInLight* last, Tile* tile) const {
  if (std::memcmp(&last->plane, &receivers_.planes[receiver], sizeof(glm::vec4)) != 0) {
    *last = ToLight(receivers_.planes[receiver]);
  }
  const PlaneInLight& plane = *last;
  if (!(plane.middle + (std::abs(plane.up.x) + std::abs(plane.up.y)) / 2 > 0)) return false;
  glm::dvec3 from_eye;
  if (receivers_.ArePoints()) {
    from_eye = light_from_world_ * glm::dvec3(receivers_.points[receiver]);
  } else {
    const bool is_orthographic = receivers_.camera.is_orthographic;
    const glm::dvec3 across = ray_from_ndc_[0] * ndc.x + ray_from_ndc_[1] * ndc.y;
    const glm::dvec3 origin = is_orthographic ? across : glm::dvec3(0);
    const glm::dvec3 ray = is_orthographic ? ray_from_ndc_[2] : across + ray_from_ndc_[2];
    from_eye = origin + ray * ((double(plane.plane.w) - glm::dot(plane.normal, origin)) / glm::dot(plane.normal, ray));
  }
  const glm::dvec3 position = from_eye + eye_ls_;
  if (!(position.z > 0)) return false;

  const glm::vec3 in_shaft(space_.FromLight(position));
  tile->x[lane] = in_shaft.x;
  tile->y[lane] = in_shaft.y;
  tile->z[lane] = in_shaft.z;
  tile->normal_x[lane] = float(plane.normal_in_shaft.x);
  tile->normal_y[lane] = float(plane.normal_in_shaft.y);
  tile->normal_z[lane] = float(plane.normal_in_shaft.z);
  // Of (0.5, 0.5, 0), the light's middle.
  tile->offset[lane] = float((plane.normal_in_shaft.x + plane.normal_in_shaft.y) / 2 - plane.middle);
  tile->up_x[lane] = float(plane.up.x);
  tile->up_y[lane] = float(plane.up.y);
  tile->up[lane] = float(plane.middle - (plane.up.x + plane.up.y) / 2);
  const auto size = float(Size(position));
  tile->error_m[lane] = float(kFourUlps * (double(size) + glm::length(from_eye)));
  tile->size_m = std::max(tile->size_m, size);
  tile->is_loose = tile->is_loose || plane.normal == glm::dvec3(0);
  const uint64_t hash = Hash(seed_, uint32_t(receiver));
  tile->shift_x[lane] = Fraction(hash);
  tile->shift_y[lane] = Fraction(hash >> 32);
  tile->index[lane] = uint32_t(receiver);
  return true;
}

}  // namespace halfshade
