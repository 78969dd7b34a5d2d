#include "renderer/shadow/shaft/mesh_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/light/parallel_for.h"
#include "renderer/status.h"

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

// Along any axis three corners that span d are apart by squares of 1.5 d^2 or more together: so the squares of a
// triangle's sides bound that of the box's diagonal, and those of both its halves a quad's.
float MostDiagonal(const Face& face) {
  const auto squares = [&](int a, int b, int c) {
    const glm::vec3 ab = face.corners[b] - face.corners[a], bc = face.corners[c] - face.corners[b],
                    ca = face.corners[a] - face.corners[c];
    return glm::dot(ab, ab) + glm::dot(bc, bc) + glm::dot(ca, ca);
  };
  float sum = squares(0, 1, 2);
  if (face.count == 4) sum += squares(0, 2, 3);
  return 1.0001f * std::sqrt(sum / 1.5f);
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
  float longest = 0;  // diagonal of a box around a face, whichever way it is turned
  for (size_t i = 0; i < faces.size(); ++i) {
    for (int k = 0; k < faces[i].count; ++k) boxes[i].Add(faces[i].corners[k]);
    longest = std::max(longest, MostDiagonal(faces[i]));
    shape->reach = glm::max(shape->reach, glm::max(glm::abs(boxes[i].min), glm::abs(boxes[i].max)));
  }
  if (!shape->roots.empty()) shape->roots.back().next_reach = longest;
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

MeshShape MakeMeshShape(const FlatScene& scene, const Mesh& mesh, const std::vector<MeshLevel>& levels) {
  MeshShape shape;
  const auto position = scene.positions.begin() + mesh.first_vertex;
  const auto index = scene.indices.begin() + mesh.first_index;
  const std::vector<glm::vec3> positions(position, position + mesh.vertex_count);
  const std::vector<uint32_t> indices(index, index + mesh.index_count);
  FaceFinder finder(positions, indices, -std::numeric_limits<float>::infinity());
  const auto error_of = [&](size_t level) {
    return level < levels.size() ? levels[level].error : std::numeric_limits<float>::infinity();
  };
  // Leaves are more than half full; pages that are not needed are never touched.
  size_t triangles = mesh.TriangleCount();
  for (const MeshLevel& level : levels) triangles += level.indices.size() / 3;
  shape.faces.reserve(triangles / 8 + 1);
  AddRoot(finder.Find(0, mesh.TriangleCount(), mesh.TriangleCount()), 0, error_of(0), &shape);
  for (size_t i = 0; i < levels.size(); ++i) {
    AddRoot(finder.FindOfLevel(levels[i].indices, 0), error_of(i), error_of(i + 1), &shape);
  }
  return shape;
}

uint64_t MeshShapes::SizeBytes() const {
  uint64_t bytes = kept_meshes.size() * sizeof(uint32_t) + shapes.size() * sizeof(MeshShape);
  for (const MeshShape& shape : shapes) bytes += shape.SizeBytes();
  return bytes;
}

absl::StatusOr<MeshShapes> BuildMeshShapes(const FlatScene& scene, const std::function<absl::Status()>& stop) {
  MeshShapes built;
  built.kept_meshes = FindKeptMeshes(scene);
  built.shapes.resize(scene.meshes.size());
  std::vector<uint32_t> firsts;
  for (uint32_t i = 0; i < scene.meshes.size(); ++i) {
    if (built.kept_meshes[i] == i) firsts.push_back(i);
  }
  const auto build = [&](int i) {
    const Mesh& mesh = scene.meshes[firsts[size_t(i)]];
    built.shapes[firsts[size_t(i)]] = MakeMeshShape(scene, mesh, BuildMeshLevels(scene, mesh));
  };
  RETURN_IF_ERROR(ParallelFor(int(firsts.size()), 1, build, stop));
  return built;
}

ShapeInstance MakeShapeInstance(const MeshShape& shape, const KeptPlace& place, float z_near, const ShaftSpace& space) {
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
  instance.shape = &shape;
  instance.z_near = z_near;
  instance.is_cut = place.box_ls.min.z < z_near;
  instance.is_mirrored = glm::determinant(axes) < 0;
  return instance;
}

PolygonParts MakePolygons(const ShapeInstance& instance, const Face& face, const ShaftSpace& space) {
  Face placed = face;
  for (int k = 0; k < face.count; ++k) placed.corners[k] = PointInLight(instance.light_from_mesh, face.corners[k]);
  if (instance.is_cut) {
    placed.closed = 0;
    return MakePolygons(placed, instance.z_near, space);
  }
  if (instance.is_mirrored && face.closed != 0) placed.closed = uint8_t(3 - face.closed);
  PolygonParts parts;
  parts.count = int(MakePolygon(placed, space, &parts.polygons[0]));
  return parts;
}

}  // namespace halfshade
