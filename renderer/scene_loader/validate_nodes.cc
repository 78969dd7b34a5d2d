#include <cmath>

#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// Any double that a product of two still leaves finite.
constexpr double kHuge = 1e100;

absl::Status CheckCamera(const Place& camera, Gltf* gltf) {
  ASSIGN_OR_RETURN(const std::string type, camera.Text("type"));
  if (type != "perspective" && type != "orthographic") {
    return camera.FaultAt("type", Quoted(type) + "; must be perspective or orthographic");
  }
  ASSIGN_OR_RETURN(const Place lens, camera.Object(type));
  ASSIGN_OR_RETURN(const double near_m, lens.Number("znear", 0, kHuge));
  if (type == "orthographic") {
    ASSIGN_OR_RETURN(const double far_m, lens.Number("zfar", 0, kHuge));
    if (far_m <= near_m) return lens.FaultAt("zfar", lens.json()["zfar"].dump() + "; must be over znear");
    for (const char* key : {"xmag", "ymag"}) {
      ASSIGN_OR_RETURN(const double magnification, lens.Number(key, -kHuge, kHuge));
      if (magnification == 0) return lens.FaultAt(key, "must not be 0");
    }
    return absl::OkStatus();
  }
  if (near_m == 0) return lens.FaultAt("znear", "must be positive");
  RETURN_IF_ERROR(lens.CheckNumber("zfar", 0, kHuge));
  if (lens.Has("zfar") && lens.json()["zfar"].get<double>() <= near_m) {
    return lens.FaultAt("zfar", lens.json()["zfar"].dump() + "; must be over znear");
  }
  ASSIGN_OR_RETURN(const double fovy, lens.Number("yfov", 0, kHuge));
  if (fovy == 0) return lens.FaultAt("yfov", "must be positive");
  if (fovy >= M_PI) gltf->warnings.Add(lens.pointer() + "/yfov", "180 degrees or more; drawn with a little less");
  return absl::OkStatus();
}

absl::Status CheckTransform(const Place& node, Gltf* gltf) {
  RETURN_IF_ERROR(node.CheckNumbers("matrix", 16, -kHuge, kHuge));
  RETURN_IF_ERROR(node.CheckNumbers("translation", 3, -kHuge, kHuge));
  RETURN_IF_ERROR(node.CheckNumbers("scale", 3, -kHuge, kHuge));
  constexpr double kUnit = 1 + 1e-3;  // written with few digits
  RETURN_IF_ERROR(node.CheckNumbers("rotation", 4, -kUnit, kUnit));
  if (node.Has("matrix") && (node.Has("translation") || node.Has("rotation") || node.Has("scale"))) {
    return node.FaultAt("matrix", "stands beside translation, rotation or scale");
  }
  if (node.Has("rotation")) {
    double squares = 0;
    for (const Json& element : node.json()["rotation"]) squares += element.get<double>() * element.get<double>();
    if (std::abs(squares - 1) > 1e-2) {
      gltf->warnings.Add(node.pointer() + "/rotation",
                         squares > 0 ? "no unit quaternion; made one" : "a quaternion of zeros; not rotated");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckNode(const Place& node, Gltf* gltf) {
  RETURN_IF_ERROR(gltf->CheckIndexList(node, "children", "nodes"));
  RETURN_IF_ERROR(gltf->CheckOptionalIndex(node, "mesh", "meshes"));
  RETURN_IF_ERROR(gltf->CheckOptionalIndex(node, "camera", "cameras"));
  RETURN_IF_ERROR(gltf->CheckOptionalIndex(node, "skin", "skins"));
  if (node.Has("skin") && !node.Has("mesh"))
    gltf->warnings.Add(node.pointer() + "/skin", "without a mesh nothing is bent");
  RETURN_IF_ERROR(CheckWeights(node));
  RETURN_IF_ERROR(CheckNodeExtensions(*gltf, node, &gltf->warnings));
  return CheckTransform(node, gltf);
}

struct Forest {
  std::vector<int64_t> parent;        // -1 for roots
  std::vector<size_t> enter, finish;  // a walk, parents first: b hangs below a if enter[a] <= enter[b] < finish[a]
};

Forest Walk(const Gltf& gltf, std::vector<int64_t> parent) {
  Forest forest{std::move(parent), {}, {}};
  const size_t count = forest.parent.size();
  forest.enter.resize(count);
  forest.finish.resize(count);
  size_t clock = 0;
  struct Visit {
    size_t node, next_child;
  };
  std::vector<Visit> stack;
  for (size_t root = 0; root < count; ++root) {
    if (forest.parent[root] >= 0) continue;
    stack.push_back({root, 0});
    while (!stack.empty()) {
      Visit& visit = stack.back();
      if (visit.next_child == 0) forest.enter[visit.node] = clock++;
      const Json& node = gltf.json["nodes"][visit.node];
      const auto children = node.find("children");
      if (children != node.end() && visit.next_child < children->size()) {
        stack.push_back({(*children)[visit.next_child++].get<size_t>(), 0});
      } else {
        forest.finish[visit.node] = clock;
        stack.pop_back();
      }
    }
  }
  return forest;
}

// No node has two parents, and none is its own ancestor.
absl::StatusOr<Forest> CheckForest(const Gltf& gltf) {
  const size_t count = gltf.Count("nodes");
  std::vector<int64_t> parent(count, -1);
  for (size_t i = 0; i < count; ++i) {
    const Place node = gltf.At("nodes", i);
    if (!node.Has("children")) continue;
    const Place children = node.Member("children");
    for (size_t k = 0; k < children.size(); ++k) {
      int64_t& mine = parent[children.Element(k).json().get<size_t>()];
      if (mine >= 0) {
        return children.Element(k).Fault("a second parent: the node is a child of /nodes/" + std::to_string(mine) +
                                         " too");
      }
      mine = int64_t(i);
    }
  }
  enum : uint8_t { kUnknown, kOnThisWalk, kEndsAtARoot };
  std::vector<uint8_t> state(count, kUnknown);
  for (size_t i = 0; i < count; ++i) {
    int64_t at = int64_t(i);
    for (; at >= 0 && state[size_t(at)] == kUnknown; at = parent[size_t(at)]) state[size_t(at)] = kOnThisWalk;
    if (at >= 0 && state[size_t(at)] == kOnThisWalk) {
      return gltf.At("nodes", size_t(at)).Fault("a cycle: the node is its own ancestor");
    }
    for (at = int64_t(i); at >= 0 && state[size_t(at)] == kOnThisWalk; at = parent[size_t(at)]) {
      state[size_t(at)] = kEndsAtARoot;
    }
  }
  return Walk(gltf, std::move(parent));
}

absl::Status CheckScene(const Gltf& gltf, const Place& scene, const Forest& forest) {
  RETURN_IF_ERROR(gltf.CheckIndexList(scene, "nodes", "nodes"));
  if (!scene.Has("nodes")) return absl::OkStatus();
  const Place nodes = scene.Member("nodes");
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Json& root = nodes.Element(i).json();
    if (forest.parent[root.get<size_t>()] >= 0) return nodes.Element(i).Fault(root.dump() + " is not a root node");
  }
  return absl::OkStatus();
}

absl::Status CheckSkin(const Gltf& gltf, const Place& skin, const Forest& forest) {
  RETURN_IF_ERROR(skin.Array("joints").status());
  RETURN_IF_ERROR(gltf.CheckIndexList(skin, "joints", "nodes"));
  if (skin.json()["joints"].empty()) return skin.FaultAt("joints", "must not be empty");
  RETURN_IF_ERROR(gltf.CheckOptionalIndex(skin, "skeleton", "nodes"));
  const Json& joints = skin.json()["joints"];
  if (skin.Has("skeleton")) {
    const size_t top = skin.json()["skeleton"].get<size_t>();
    for (const Json& joint : joints) {
      const size_t enter = forest.enter[joint.get<size_t>()];
      if (enter < forest.enter[top] || enter >= forest.finish[top]) {
        return skin.FaultAt("skeleton", std::to_string(top) + " is no ancestor of joint " + joint.dump());
      }
    }
  }
  if (!skin.Has("inverseBindMatrices")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place matrices, gltf.Follow(skin, "inverseBindMatrices", "accessors"));
  if (matrices.json()["type"] != "MAT4" || matrices.json()["componentType"] != 5126) {
    return skin.FaultAt("inverseBindMatrices", matrices.pointer() + " must be MAT4 of floats");
  }
  if (matrices.json()["count"] < joints.size()) {
    return skin.FaultAt("inverseBindMatrices", matrices.pointer() + " has " + matrices.json()["count"].dump() +
                                                   " elements for " + std::to_string(joints.size()) + " joints");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateNodes(Gltf* gltf) {
  RETURN_IF_ERROR(CheckLights(*gltf, &gltf->warnings));
  for (size_t i = 0; i < gltf->Count("cameras"); ++i) RETURN_IF_ERROR(CheckCamera(gltf->At("cameras", i), gltf));
  for (size_t i = 0; i < gltf->Count("nodes"); ++i) RETURN_IF_ERROR(CheckNode(gltf->At("nodes", i), gltf));
  ASSIGN_OR_RETURN(const Forest forest, CheckForest(*gltf));
  for (size_t i = 0; i < gltf->Count("scenes"); ++i) {
    RETURN_IF_ERROR(CheckScene(*gltf, gltf->At("scenes", i), forest));
  }
  RETURN_IF_ERROR(gltf->CheckOptionalIndex(Place(gltf->json, ""), "scene", "scenes"));
  if (gltf->Count("scenes") == 0 && gltf->Count("nodes") > 0) {
    gltf->warnings.Add("/scenes", "there is no scene; every root node is shown");
  }
  for (size_t i = 0; i < gltf->Count("skins"); ++i) RETURN_IF_ERROR(CheckSkin(*gltf, gltf->At("skins", i), forest));
  for (size_t i = 0; i < gltf->Count("animations"); ++i) {
    RETURN_IF_ERROR(CheckAnimation(*gltf, gltf->At("animations", i), &gltf->warnings));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
