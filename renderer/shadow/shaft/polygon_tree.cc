#include "renderer/shadow/shaft/polygon_tree.h"

#include <algorithm>
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

}  // namespace

uint64_t PolygonTree::SizeBytes() const { return Bytes(nodes) + Bytes(polygons) + Bytes(masked) + Bytes(instances); }

PolygonTree BuildPolygonTree(const CpuOccluders& occluders, const std::vector<MeshShape>& shapes,
                             const AreaLight& light) {
  PolygonTree tree;
  ShaftPolygons polygons = BuildShaftPolygons(occluders, light);
  tree.space = polygons.space;
  tree.masked = std::move(polygons.masked);
  if (!polygons.polygons.empty()) {
    tree.polygons.reserve(polygons.polygons.size());
    tree.nodes.reserve(polygons.polygons.size() / 16 + 16);
    for (const uint32_t i : AddTree(BoxesOf(polygons.polygons), 0, kLeafItems, &tree.nodes)) {
      tree.polygons.push_back(polygons.polygons[i]);
    }
  }
  if (occluders.places.empty()) return tree;
  const auto z_near = float(occluders.triangles.hull.z_near());
  std::vector<Box3f> boxes;
  boxes.reserve(occluders.places.size());
  for (const KeptPlace& place : occluders.places) {
    // Its corners' place grows with theirs, axis by axis.
    Box3f& box = boxes.emplace_back();
    box.Add(glm::vec3(tree.space.FromLight(place.box_ls.min)));
    box.Add(glm::vec3(tree.space.FromLight(place.box_ls.max)));
  }
  tree.instance_root = uint32_t(tree.nodes.size());
  tree.instances.reserve(occluders.places.size());
  for (const uint32_t i : AddTree(boxes, 0, kLeafItems, &tree.nodes)) {
    const KeptPlace& place = occluders.places[i];
    tree.instances.push_back(MakeShapeInstance(shapes[place.mesh], place, z_near, tree.space));
  }
  return tree;
}

}  // namespace halfshade
