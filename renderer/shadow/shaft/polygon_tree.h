// All that hides one light, as trees that shafts are asked of: polygons, and meshes by the instances that stand in
// shaft space. Immutable once built. No GL.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/shadow/shaft/box_tree.h"
#include "renderer/shadow/shaft/mesh_shape.h"
#include "renderer/shadow/shaft/polygons.h"

namespace halfshade {

// Sixteen polygons of a list, as arrays.
struct alignas(64) Polygons16 {
  Boxes16 boxes;
  float normal[3][16], offset[16], margin[16];
  uint32_t closed = 0;  // bit per polygon
};

struct PolygonTree {
  std::vector<TreeNode> nodes;
  std::vector<Polygon> polygons;
  std::vector<MaskedTriangle> masked;
  ShaftSpace space;
  std::vector<ShapeInstance> instances;
  uint32_t polygon_root = 0, instance_root = 0;  // where there are any
  uint64_t SizeBytes() const;
};

// `shapes`: [mesh], of those that the occluders' places name; they are not copied.
PolygonTree BuildPolygonTree(const CpuOccluders& occluders, const std::vector<MeshShape>& shapes,
                             const AreaLight& light);

}  // namespace halfshade
