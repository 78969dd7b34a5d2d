#include "renderer/shadow/shaft/tile.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

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
  int first_active = -1;
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
      if (!receivers_.IsReceiving(receiver) || !FillLane(i, receiver, ndc, tile)) continue;
      tile->active[block] |= 1u << lane;
      if (first_active < 0) first_active = i;
      const float low = tile->up[i] + std::min(tile->up_x[i], 0.0f) + std::min(tile->up_y[i], 0.0f);
      if (!(low > 0)) tile->cut[block] |= 1u << lane;
    }
  }
  if (first_active < 0) return false;
  tile->shares_one_plane = true;
  for (int block = 0; block < Tile::kBlocks; ++block) {
    int model = first_active;
    for (int i = block * Tile::kLanes; i < (block + 1) * Tile::kLanes; ++i) {
      if (tile->active[block] >> (i % Tile::kLanes) & 1) {
        model = i;
        break;
      }
    }
    tile->shares_plane[block] = true;
    for (int i = block * Tile::kLanes; i < (block + 1) * Tile::kLanes; ++i) {
      if (!(tile->active[block] >> (i % Tile::kLanes) & 1)) CopyLane(model, i, tile);
      tile->shares_plane[block] = tile->shares_plane[block] && HaveOnePlane(*tile, i, model);
    }
    tile->shares_one_plane =
        tile->shares_one_plane && tile->shares_plane[block] && HaveOnePlane(*tile, model, first_active);
  }
  return true;
}

bool TileFiller::FillLane(int lane, size_t receiver, const glm::dvec2& ndc, Tile* tile) const {
  const glm::dvec4 plane(receivers_.planes[receiver]);
  const glm::dvec3 normal = light_from_world_ * glm::dvec3(plane);
  glm::dvec3 from_eye;
  if (receivers_.ArePoints()) {
    from_eye = light_from_world_ * glm::dvec3(receivers_.points[receiver]);
  } else {
    const bool is_orthographic = receivers_.camera.is_orthographic;
    const glm::dvec3 across = ray_from_ndc_[0] * ndc.x + ray_from_ndc_[1] * ndc.y;
    const glm::dvec3 origin = is_orthographic ? across : glm::dvec3(0);
    const glm::dvec3 ray = is_orthographic ? ray_from_ndc_[2] : across + ray_from_ndc_[2];
    from_eye = origin + ray * ((plane.w - glm::dot(normal, origin)) / glm::dot(normal, ray));
  }
  const glm::dvec3 position = from_eye + eye_ls_;
  if (!(position.z > 0)) return false;
  const double middle = -(plane.w + glm::dot(normal, eye_ls_));  // of the light, above the plane
  const double up_x = normal.x * edges_.x, up_y = normal.y * edges_.y;
  if (!(middle + (std::abs(up_x) + std::abs(up_y)) / 2 > 0)) return false;

  const glm::vec3 in_shaft(space_.FromLight(position));
  const glm::dvec3 normal_in_shaft = space_.NormalFromLight(normal);
  tile->x[lane] = in_shaft.x;
  tile->y[lane] = in_shaft.y;
  tile->z[lane] = in_shaft.z;
  tile->normal_x[lane] = float(normal_in_shaft.x);
  tile->normal_y[lane] = float(normal_in_shaft.y);
  tile->normal_z[lane] = float(normal_in_shaft.z);
  // Of (0.5, 0.5, 0), the light's middle.
  tile->offset[lane] = float((normal_in_shaft.x + normal_in_shaft.y) / 2 - middle);
  tile->up_x[lane] = float(up_x);
  tile->up_y[lane] = float(up_y);
  tile->up[lane] = float(middle - (up_x + up_y) / 2);
  const auto size = float(Size(position));
  tile->error_m[lane] = float(kFourUlps * (double(size) + glm::length(from_eye)));
  tile->size_m = std::max(tile->size_m, size);
  tile->is_loose = tile->is_loose || normal == glm::dvec3(0);
  const uint64_t hash = Hash(seed_, uint32_t(receiver));
  tile->shift_x[lane] = Fraction(hash);
  tile->shift_y[lane] = Fraction(hash >> 32);
  tile->index[lane] = uint32_t(receiver);
  return true;
}

}  // namespace halfshade
