#include <absl/strings/str_cat.h>

#include <cmath>
#include <unordered_map>

#include "renderer/status.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

// Of the last row of a transform, which is then made exactly 0 0 0 1.
constexpr double kAffineTolerance = 1e-6;
constexpr size_t kQuotedCharacters = 80;

std::string OverrideField(int i) { return "node_overrides[" + std::to_string(i) + "]"; }

absl::Status CheckTransform(const std::string& field, const v1::NodeOverride& change) {
  if (change.transform_size() == 0) return absl::OkStatus();
  if (change.transform_size() != 16) {
    return FieldError(field, std::to_string(change.transform_size()) + " floats; must be none or 16, column-major");
  }
  for (int i = 0; i < 16; ++i) {
    const std::string element = field + "[" + std::to_string(i) + "]";
    const double value = change.transform(i);
    RETURN_IF_ERROR(CheckFinite(element, value));
    RETURN_IF_ERROR(CheckRange(element, value, -kLargestLengthM, kLargestLengthM));
    const double affine = i == 15 ? 1 : 0;
    if (i % 4 == 3 && std::abs(value - affine) > kAffineTolerance) {
      return FieldError(
          element, NumberText(value) + "; must be " + NumberText(affine) + " within 1e-6: the last row is 0 0 0 1");
    }
  }
  return absl::OkStatus();
}

glm::dmat4 Affine(const v1::NodeOverride& change) {
  glm::dmat4 matrix(1);
  for (int i = 0; i < 16; ++i) {
    if (i % 4 != 3) matrix[i / 4][i % 4] = change.transform(i);
  }
  return matrix;
}

}  // namespace

absl::Status CheckNodeOverrideFields(const v1::RenderRequest& request) {
  for (int i = 0; i < request.node_overrides_size(); ++i) {
    const v1::NodeOverride& change = request.node_overrides(i);
    if (change.node_case() == v1::NodeOverride::NODE_NOT_SET) {
      return FieldError(OverrideField(i), "no node; must have a name or an index");
    }
    if (change.has_name() && change.name().empty()) return FieldError(OverrideField(i) + ".name", "must not be empty");
    RETURN_IF_ERROR(CheckTransform(OverrideField(i) + ".transform", change));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<NodeOverride>> ResolveNodeOverrides(const v1::RenderRequest& request,
                                                               const FlatScene& scene) {
  std::vector<NodeOverride> overrides;
  if (request.node_overrides().empty()) return overrides;
  std::unordered_map<std::string, uint32_t> first_of_name;
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) first_of_name.try_emplace(scene.nodes[node].name, node);
  std::unordered_map<uint32_t, int> override_of_node;
  for (int i = 0; i < request.node_overrides_size(); ++i) {
    const v1::NodeOverride& change = request.node_overrides(i);
    NodeOverride result;
    if (change.has_name()) {
      const auto found = first_of_name.find(change.name());
      if (found == first_of_name.end()) {
        return FieldError(OverrideField(i) + ".name",
                          absl::StrCat("\"", change.name().substr(0, kQuotedCharacters), "\"; no node has this name"));
      }
      result.node = found->second;
    } else {
      if (change.index() >= scene.nodes.size()) {
        return FieldError(OverrideField(i) + ".index", std::to_string(change.index()) + "; the scene has " +
                                                           std::to_string(scene.nodes.size()) + " nodes");
      }
      result.node = change.index();
    }
    if (const auto [other, is_first] = override_of_node.try_emplace(result.node, i); !is_first) {
      return FieldError(OverrideField(i), "node " + std::to_string(result.node) + " is changed by " +
                                              OverrideField(other->second) + " already");
    }
    if (change.transform_size() > 0) result.local = Affine(change);
    result.is_visible = !change.has_visible() || change.visible();
    result.casts = !change.has_casts() || change.casts();
    result.receives = !change.has_receives() || change.receives();
    overrides.push_back(result);
  }
  return overrides;
}

}  // namespace halfshade
