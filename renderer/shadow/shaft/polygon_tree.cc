#include "renderer/shadow/shaft/polygon_tree.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace halfshade {
namespace {

constexpr uint32_t kLeafItems = 8;

template <typename Item>
uint64_t Bytes(const std::vector<Item>& items) {
  return items.size() * sizeof(Item);
}

std::vector<Box3f> BoxesOf(const std::vector<Polygon>& polygons) {
  std::vector<Box3f> boxes(polygons.size());
  for (size_t i = 0; i < polygons.size(); ++i) {
    const Polygon& polygon = polygons[i];
    for (int k = 0; k < polygon.corners; ++k) boxes[i].Add({polygon.x[k], polygon.y[k], polygon.z[k]});
  }
  return boxes;
}

void AddShared(const CpuOccluders& occluders, PolygonTree* tree) {
  std::vector<ShapeInstance> instances;
  std::vector<Box3f> boxes;
  for (const SharedMesh& mesh : occluders.shared) {
    const auto shape = uint32_t(tree->shapes.size());
    tree->shapes.push_back(MakeMeshShape(mesh, occluders.levels.get()));
    for (const SharedMesh::Place& place : mesh.places) {
      instances.push_back(MakeShapeInstance(tree->shapes[shape], shape, place, tree->space));
      // Its corners' place grows with theirs, axis by axis.
      Box3f& box = boxes.emplace_back();
      box.Add(glm::vec3(tree->space.FromLight(place.box_ls.min)));
      box.Add(glm::vec3(tree->space.FromLight(place.box_ls.max)));
    }
  }
  if (instances.empty()) return;
  tree->instance_root = uint32_t(tree->nodes.size());
  for (const uint32_t i : AddTree(boxes, 0, kLeafItems, &tree->nodes)) tree->instances.push_back(instances[i]);
}

}  // namespace

uint64_t PolygonTree::SizeBytes() const {
  uint64_t bytes = Bytes(roots) + Bytes(nodes) + Bytes(polygons) + Bytes(masked) + Bytes(instances);
  for (const MeshShape& shape : shapes) bytes += shape.SizeBytes();
  return bytes;
}

PolygonTree BuildPolygonTree(ShaftPolygons polygons) {
  PolygonTree tree;
  tree.space = polygons.space;
  size_t count = polygons.polygons.size();
  for (const PolygonLevel& level : polygons.levels) count += level.polygons.size();
  tree.polygons.reserve(count);
  tree.nodes.reserve(count / 16 + 16 * (polygons.levels.size() + 1));
  const glm::vec3 metres(1.0 / polygons.space.scale);
  const auto add = [&](const std::vector<Polygon>& part, float error_m, float next_error_m) {
    if (part.empty()) return;
    const std::vector<Box3f> boxes = BoxesOf(part);
    if (error_m > 0 && !tree.roots.empty()) {
      // Of the level before it this is the next.
      float& reach_m = tree.roots.back().next_reach;
      for (const Box3f& box : boxes) reach_m = std::max(reach_m, glm::length(box.Extent() * metres));
    }
    tree.roots.push_back({.node = uint32_t(tree.nodes.size()), .error = error_m, .next_error = next_error_m});
    for (const uint32_t i : AddTree(boxes, uint32_t(tree.polygons.size()), kLeafItems, &tree.nodes)) {
      tree.polygons.push_back(part[i]);
    }
  };
  add(polygons.polygons, 0, std::numeric_limits<float>::infinity());
  for (const PolygonLevel& level : polygons.levels) add(level.polygons, level.error_m, level.next_error_m);
  tree.masked = std::move(polygons.masked);
  return tree;
}

PolygonTree BuildPolygonTree(const CpuOccluders& occluders, const AreaLight& light) {
  PolygonTree tree = BuildPolygonTree(BuildShaftPolygons(occluders, light));
  AddShared(occluders, &tree);
  return tree;
}

}  // namespace halfshade
