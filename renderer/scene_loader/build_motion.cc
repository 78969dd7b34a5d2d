#include "renderer/scene_loader/build_motion.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <optional>
#include <utility>

#include "renderer/scene_loader/tinygltf.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// As far as a request may move a node.
constexpr float kMaxAnimatedValue = 1e15f;

class AnimationBuilder {
 public:
  AnimationBuilder(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf, FlatScene* scene)
      : data_(data), limits_(limits), gltf_(*gltf), scene_(*scene) {}

  absl::Status Build() {
    for (size_t i = 0; i < gltf_.animations.size(); ++i) {
      const Place place(gltf_.animations[i], "/animations/" + std::to_string(i));
      Animation animation;
      animation.name = place.json().value("name", "");
      animation.first_channel = uint32_t(scene_.channels.size());
      const Place channels = place.Member("channels");
      for (size_t c = 0; c < channels.size(); ++c) RETURN_IF_ERROR(AddChannel(place, channels.Element(c), &animation));
      animation.channel_count = uint32_t(scene_.channels.size()) - animation.first_channel;
      scene_.animations.push_back(std::move(animation));
    }
    AddRests();
    return absl::OkStatus();
  }

 private:
  void Skip(const Place& channel, const std::string& why) {
    gltf_.warnings.Add(channel.pointer(), why + "; the channel is left out");
  }

  absl::Status AddChannel(const Place& animation, const Place& place, Animation* result) {
    const Place target = place.Member("target");
    const std::string path = target.json()["path"];
    if (!target.Has("node") || !SetPath(path)) return absl::OkStatus();
    channel_.node = target.json()["node"].get<uint32_t>();
    const Node& node = scene_.nodes[channel_.node];
    const bool is_weights = channel_.path == AnimatedPath::kWeights;
    channel_.width = is_weights ? node.weight_count : channel_.path == AnimatedPath::kRotation ? 4 : 3;
    if (channel_.width == 0) {
      Skip(place, "its node has no morph targets");
      return absl::OkStatus();
    }
    if (!is_weights && !data_.model->nodes[channel_.node].matrix.empty()) {
      Skip(place, "its node has a matrix");
      return absl::OkStatus();
    }
    const Place sampler = animation.Member("samplers").Element(place.json()["sampler"].get<size_t>());
    const std::string interpolation = sampler.json().value("interpolation", "LINEAR");
    channel_.interpolation = interpolation == "STEP"     ? Interpolation::kStep
                             : interpolation == "LINEAR" ? Interpolation::kLinear
                                                         : Interpolation::kCubic;
    const int input = sampler.json()["input"].get<int>(), output = sampler.json()["output"].get<int>();
    ASSIGN_OR_RETURN(const std::optional<Run> times, Copy(input, place, &scene_.animation_times));
    ASSIGN_OR_RETURN(const std::optional<Run> values, Copy(output, place, &scene_.animation_values));
    if (!times || !values) {
      Skip(place, "a value of its sampler is not finite, or over 1e15");
      return absl::OkStatus();
    }
    const float* first = scene_.animation_times.data() + times->first;
    if (!std::is_sorted(first, first + times->count)) {
      Skip(place, "its times do not increase");
      return absl::OkStatus();
    }
    const uint64_t wanted =
        uint64_t(times->count) * channel_.width * (channel_.interpolation == Interpolation::kCubic ? 3 : 1);
    if (values->count < wanted) {
      Skip(place, std::to_string(values->count) + " values where " + std::to_string(wanted) + " are needed");
      return absl::OkStatus();
    }
    channel_.first_time = times->first;
    channel_.key_count = times->count;
    channel_.first_value = values->first;
    result->duration_s = std::max<double>(result->duration_s, first[times->count - 1]);
    scene_.channels.push_back(channel_);
    return absl::OkStatus();
  }

  bool SetPath(const std::string& path) {
    constexpr std::pair<const char*, AnimatedPath> kPaths[] = {{"translation", AnimatedPath::kTranslation},
                                                               {"rotation", AnimatedPath::kRotation},
                                                               {"scale", AnimatedPath::kScale},
                                                               {"weights", AnimatedPath::kWeights}};
    for (const auto& [name, value] : kPaths) {
      channel_.path = value;
      if (path == name) return true;
    }
    return false;
  }

  // All floats of an accessor, once: samplers share them.
  struct Run {
    uint32_t first = 0, count = 0;
  };
  absl::StatusOr<std::optional<Run>> Copy(int accessor, const Place& place, std::vector<float>* to) {
    auto& runs = to == &scene_.animation_times ? times_ : values_;
    const auto [run, is_new] = runs.try_emplace(accessor);
    if (!is_new) return run->second;
    const AccessorReader reader(data_, accessor);
    const uint64_t count = uint64_t(reader.count()) * uint64_t(reader.components());
    if ((to->size() + count) * sizeof(float) > limits_.max_scene_bytes) {
      return place.Fault("the animations take over " + std::to_string(limits_.max_scene_bytes) + " bytes, the limit");
    }
    run->second = Run{uint32_t(to->size()), uint32_t(count)};
    for (size_t i = 0; i < reader.count(); ++i) {
      for (int c = 0; c < reader.components(); ++c) {
        const float value = reader.Float(i, c);
        if (!(std::abs(value) <= kMaxAnimatedValue)) {
          to->resize(run->second->first);
          run->second.reset();
          return run->second;
        }
        to->push_back(value);
      }
    }
    return run->second;
  }

  void AddRests() {
    std::map<uint32_t, Rest> rests;
    for (const AnimationChannel& channel : scene_.channels) {
      Rest& rest = rests[channel.node];
      const tinygltf::Node& node = data_.model->nodes[channel.node];
      rest.node = channel.node;
      if (node.translation.size() == 3) rest.translation = glm::make_vec3(node.translation.data());
      if (node.scale.size() == 3) rest.scale = glm::make_vec3(node.scale.data());
      if (node.rotation.size() != 4) continue;
      const glm::dquat rotation(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
      if (glm::length(rotation) > 0) rest.rotation = glm::normalize(rotation);
    }
    for (const auto& [node, rest] : rests) scene_.rests.push_back(rest);
  }

  const GltfData& data_;
  const SceneLoadLimits& limits_;
  Gltf& gltf_;
  FlatScene& scene_;
  AnimationChannel channel_;
  std::map<int, std::optional<Run>> times_, values_;
};

}  // namespace

void BuildSkins(const GltfData& data, FlatScene* scene) {
  for (const tinygltf::Skin& source : data.model->skins) {
    Skin skin;
    skin.first_joint = uint32_t(scene->skin_joints.size());
    skin.joint_count = uint32_t(source.joints.size());
    std::optional<AccessorReader> matrices;
    if (source.inverseBindMatrices >= 0) matrices.emplace(data, source.inverseBindMatrices);
    for (size_t j = 0; j < source.joints.size(); ++j) {
      scene->skin_joints.push_back(uint32_t(source.joints[j]));
      glm::mat4 joint_from_mesh(1);
      for (int i = 0; matrices && i < 16; ++i) joint_from_mesh[i / 4][i % 4] = matrices->Float(j, i);
      scene->joint_from_mesh.push_back(joint_from_mesh);
    }
    scene->skins.push_back(skin);
  }
}

absl::Status BuildPlaces(const GltfData& data, const Place& extensions, Node* node, FlatScene* scene) {
  if (!extensions.Has("EXT_mesh_gpu_instancing") || node->skin >= 0) return absl::OkStatus();
  const Place attributes = extensions.Member("EXT_mesh_gpu_instancing").Member("attributes");
  std::optional<AccessorReader> translations, rotations, scales;
  const auto find = [&](const char* name, std::optional<AccessorReader>* reader) {
    if (attributes.Has(name)) reader->emplace(data, attributes.Member(name).json().get<int>());
  };
  find("TRANSLATION", &translations);
  find("ROTATION", &rotations);
  find("SCALE", &scales);
  node->first_place = uint32_t(scene->places.size());
  for (const auto* reader : {&translations, &rotations, &scales}) {
    if (*reader) node->place_count = uint32_t((*reader)->count());
  }
  for (uint32_t i = 0; i < node->place_count; ++i) {
    InstancePlace place;
    if (translations) place.translation = translations->Vector<glm::vec3>(i);
    if (scales) place.scale = scales->Vector<glm::vec3>(i);
    if (rotations) {
      const glm::vec4 q = rotations->Vector<glm::vec4>(i);
      const glm::quat rotation(q.w, q.x, q.y, q.z);
      if (glm::length(rotation) > 0) place.rotation = glm::normalize(rotation);
    }
    const float sum =
        glm::dot(place.translation, glm::vec3(1)) + glm::dot(place.scale, glm::vec3(1)) + place.rotation.w;
    if (!std::isfinite(sum)) return attributes.Fault("instance " + std::to_string(i) + " is not finite");
    scene->places.push_back(place);
  }
  return absl::OkStatus();
}

absl::Status BuildAnimations(const GltfData& data, const SceneLoadLimits& limits, Gltf* gltf, FlatScene* scene) {
  return AnimationBuilder(data, limits, gltf, scene).Build();
}

}  // namespace halfshade
