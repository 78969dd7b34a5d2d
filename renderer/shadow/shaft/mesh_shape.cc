#include "renderer/shadow/shaft/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace halfshade {
namespace {

constexpr float kSixteenUlps = 16 * 1.1920929e-7f;

// No less than what the matrix makes of any length of 1, and 7 % more at most: the largest eigenvalue of its square,
// from the trace of its eighth power.
double MostStretch(const glm::dmat3& axes) {
  const double unit = std::max({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
  if (!(unit > 0)) return 0;
  glm::dmat3 power = glm::transpose(axes / unit) * (axes / unit);
  for (int i = 0; i < 3; ++i) power = power * power;
  return unit * std::pow(power[0][0] + power[1][1] + power[2][2], 1.0 / 16);
}

void Put(const Face& face, uint32_t lane, Faces16* faces) {
  for (int k = 0; k < 4; ++k) {
    for (int axis = 0; axis < 3; ++axis) faces->corners[k][axis][lane] = face.corners[k][axis];
  }
  faces->closed |= uint32_t(face.closed != 0) << lane;
  faces->turned |= uint32_t(face.closed == 2) << lane;
  faces->quads |= uint32_t(face.count == 4) << lane;
}

void AddRoot(const std::vector<Face>& faces, float error, float next_error, MeshShape* shape) {
  if (faces.empty()) return;
  std::vector<Box3f> boxes(faces.size());
  float longest = 0;  // across a face
  for (size_t i = 0; i < faces.size(); ++i) {
    for (int k = 0; k < faces[i].count; ++k) {
      boxes[i].Add(faces[i].corners[k]);
      for (int j = 0; j < k; ++j) longest = std::max(longest, glm::distance(faces[i].corners[k], faces[i].corners[j]));
    }
    shape->reach = glm::max(shape->reach, glm::max(glm::abs(boxes[i].min), glm::abs(boxes[i].max)));
  }
  // The diagonal of a box around it, whichever way it is turned.
  if (!shape->roots.empty()) shape->roots.back().next_reach = std::sqrt(3.0f) * longest;
  shape->roots.push_back({.node = uint32_t(shape->nodes.size()), .error = error, .next_error = next_error});
  const size_t first_node = shape->nodes.size();
  const std::vector<uint32_t> order = AddTree(boxes, 0, 16, &shape->nodes);
  for (size_t n = first_node; n < shape->nodes.size(); ++n) {
    TreeNode& node = shape->nodes[n];
    for (int i = 0; i < TreeNode::kWidth; ++i) {
      if (node.count[i] == 0) continue;
      Faces16& leaf = shape->faces.emplace_back();
      for (uint32_t lane = 0; lane < 16; ++lane) {
        // Those that fill up are not used.
        Put(faces[order[node.first[i] + (lane < node.count[i] ? lane : 0)]], lane, &leaf);
      }
      leaf.used = (1u << node.count[i]) - 1;
      node.first[i] = uint32_t(16 * (shape->faces.size() - 1));
    }
  }
}

}  // namespace

Face Faces16::At(uint32_t lane) const {
  Face face;
  for (int k = 0; k < 4; ++k) face.corners[k] = {corners[k][0][lane], corners[k][1][lane], corners[k][2][lane]};
  face.count = (quads >> lane & 1) != 0 ? 4 : 3;
  face.closed = uint8_t((closed >> lane & 1) + (turned >> lane & 1));
  return face;
}

MeshShape MakeMeshShape(const SharedMesh& mesh, const MeshLevels* levels) {
  MeshShape shape;
  FaceFinder finder(mesh.positions, mesh.indices, -std::numeric_limits<float>::infinity());
  const auto count = uint32_t(mesh.indices.size() / 3);
  const std::vector<MeshLevels::Level> none;
  const std::vector<MeshLevels::Level>& all = levels == nullptr ? none : levels->meshes[mesh.mesh];
  const auto error_of = [&](size_t level) {
    return level < all.size() ? all[level].error : std::numeric_limits<float>::infinity();
  };
  AddRoot(finder.Find(0, count, count), 0, error_of(0), &shape);
  for (size_t i = 0; i < all.size(); ++i) {
    AddRoot(finder.FindOfLevel(all[i].indices, 0), error_of(i), error_of(i + 1), &shape);
  }
  shape.faces.shrink_to_fit();
  shape.nodes.shrink_to_fit();
  return shape;
}

ShapeInstance MakeShapeInstance(const MeshShape& shape, uint32_t shape_index, const SharedMesh::Place& place,
                                const ShaftSpace& space) {
  ShapeInstance instance;
  instance.light_from_mesh = place.light_from_mesh;
  const glm::dmat3 axes(place.light_from_mesh);
  const glm::dvec3 origin_ls(place.light_from_mesh[3]), origin = space.FromLight(origin_ls);
  for (int row = 0; row < 3; ++row) {
    // All that is added up on the way from a corner to its place.
    double largest = std::abs(origin_ls[row] * space.scale[row]) + std::abs(origin[row]);
    for (int column = 0; column < 3; ++column) {
      instance.axes[column][row] = float(axes[column][row] * space.scale[row]);
      largest += std::abs(axes[column][row] * space.scale[row]) * shape.reach[column];
    }
    instance.origin[row] = float(origin[row]);
    instance.slack[row] = float(kSixteenUlps * largest);
  }
  instance.scale = float(place.scale);
  instance.stretch = float(MostStretch(axes));
  instance.shape = shape_index;
  instance.is_mirrored = glm::determinant(axes) < 0;
  return instance;
}

bool MakePolygon(const ShapeInstance& instance, const Face& face, const ShaftSpace& space, Polygon* polygon) {
  Face placed = face;
  for (int k = 0; k < face.count; ++k) placed.corners[k] = PointInLight(instance.light_from_mesh, face.corners[k]);
  if (instance.is_mirrored && face.closed != 0) placed.closed = uint8_t(3 - face.closed);
  return MakePolygon(placed, space, polygon);
}

}  // namespace halfshade
