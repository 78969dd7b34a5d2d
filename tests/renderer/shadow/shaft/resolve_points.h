// What a tree of occluders hides from receivers, tile by tile as the method does.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/light/cpu_receivers.h"
#include "renderer/shadow/shaft/resolve_tile.h"

namespace halfshade {

struct Resolved {
  std::vector<float> hidden;  // fraction, of each receiver
  double disagreement = 0;    // mean
  uint64_t drawn = 0;
};

inline Resolved ResolveTree(const PolygonTree& tree, const std::vector<RayMask>& masks, const AreaLight& light,
                            const CpuReceivers& receivers, int rows, uint32_t seed = 0) {
  const TileFiller filler(receivers, light, tree.space, seed);
  Resolved resolved;
  resolved.hidden.resize(receivers.size(), 0);
  Tile tile;
  std::vector<Tile> apart;
  TileScratch scratch;
  TileResult result;
  const auto resolve = [&](const Tile& part) {
    ResolveTile(tree, masks, part, rows, &scratch, &result);
    resolved.drawn += result.drawn;
    for (int i = 0; i < Tile::kMost; ++i) {
      if ((part.active[i / Tile::kLanes] >> (i % Tile::kLanes) & 1) == 0) continue;
      resolved.hidden[part.index[i]] = result.hidden[i];
      resolved.disagreement += result.disagreement[i] / double(receivers.size());
    }
  };
  for (int index = 0; index < filler.count(); ++index) {
    if (!filler.Fill(index, &tile)) continue;
    SplitTile(&tile, &apart);
    resolve(tile);
    std::for_each(apart.begin(), apart.end(), resolve);
  }
  return resolved;
}

// `count` a side over the square of edge `size`, on the ground.
inline std::vector<glm::vec3> GroundPoints(int count, float size) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < count * count; ++i) {
    points.emplace_back((float(i % count) / float(count - 1) - 0.5f) * size, 0,
                        (float(i / count) / float(count - 1) - 0.5f) * size);
  }
  return points;
}

inline CpuReceivers OnGround(const std::vector<glm::vec3>& points) {
  return MakePointReceivers(points, std::vector<glm::vec3>(points.size(), {0, 1, 0}));
}

}  // namespace halfshade
