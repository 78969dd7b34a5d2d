#include "renderer/scene/animate.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>

namespace halfshade {
namespace {

// The values of a channel at a time: `width` of them.
class Sampler {
 public:
  Sampler(const FlatScene& scene, const AnimationChannel& channel, double time_s) : scene_(scene), channel_(channel) {
    const float* first = scene.animation_times.data() + channel.first_time;
    const float* last = first + channel.key_count;
    after_ = uint32_t(std::upper_bound(first, last, time_s) - first);
    if (after_ == 0 || after_ == channel.key_count) {
      before_ = after_ == 0 ? 0 : after_ - 1;
      after_ = before_;
      return;
    }
    before_ = after_ - 1;
    step_s_ = double(first[after_]) - first[before_];
    t_ = (time_s - first[before_]) / step_s_;
  }

  double At(uint32_t component) const {
    const double a = Value(before_, component), b = Value(after_, component);
    switch (channel_.interpolation) {
      case Interpolation::kStep:
        return a;
      case Interpolation::kLinear:
        return a + (b - a) * t_;
      case Interpolation::kCubic:
        break;
    }
    const double t = t_, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * a + step_s_ * (t3 - 2 * t2 + t) * Raw(3 * before_ + 2, component) +
           (3 * t2 - 2 * t3) * b + step_s_ * (t3 - t2) * Raw(3 * after_, component);
  }

  glm::dvec3 Vector() const { return {At(0), At(1), At(2)}; }

  // Unit; none where the keys are zeros.
  glm::dquat Rotation() const {
    if (channel_.interpolation == Interpolation::kLinear) {
      const glm::dquat a = Unit(Key(before_)), b = Unit(Key(after_));
      return Unit(glm::slerp(a, b, t_));  // takes the shorter arc
    }
    return Unit({At(3), At(0), At(1), At(2)});
  }

 private:
  static glm::dquat Unit(const glm::dquat& q) {
    const double length = glm::length(q);
    return length > 0 ? q / length : glm::dquat(1, 0, 0, 0);
  }
  double Raw(uint32_t row, uint32_t component) const {
    return scene_.animation_values[channel_.first_value + size_t(row) * channel_.width + component];
  }
  double Value(uint32_t key, uint32_t component) const {
    return Raw(channel_.interpolation == Interpolation::kCubic ? 3 * key + 1 : key, component);
  }
  glm::dquat Key(uint32_t key) const { return {Value(key, 3), Value(key, 0), Value(key, 1), Value(key, 2)}; }

  const FlatScene& scene_;
  const AnimationChannel& channel_;
  uint32_t before_ = 0, after_ = 0;
  double t_ = 0, step_s_ = 0;
};

}  // namespace

Motion Animate(const FlatScene& scene, const Moment& moment) {
  Motion motion;
  motion.morph_weights = scene.morph_weights;
  std::map<uint32_t, Rest> moved;
  const Animation& animation = scene.animations[moment.animation];
  for (uint32_t c = animation.first_channel; c < animation.first_channel + animation.channel_count; ++c) {
    const AnimationChannel& channel = scene.channels[c];
    const Sampler sampler(scene, channel, moment.time_s);
    if (channel.path == AnimatedPath::kWeights) {
      float* const weights = motion.morph_weights.data() + scene.nodes[channel.node].first_weight;
      for (uint32_t i = 0; i < channel.width; ++i) weights[i] = float(sampler.At(i));
      continue;
    }
    const auto [entry, is_new] = moved.try_emplace(channel.node);
    if (is_new) {
      entry->second = *std::lower_bound(scene.rests.begin(), scene.rests.end(), channel.node,
                                        [](const Rest& rest, uint32_t node) { return rest.node < node; });
    }
    if (channel.path == AnimatedPath::kTranslation) entry->second.translation = sampler.Vector();
    if (channel.path == AnimatedPath::kRotation) entry->second.rotation = sampler.Rotation();
    if (channel.path == AnimatedPath::kScale) entry->second.scale = sampler.Vector();
  }
  for (const auto& [node, rest] : moved) {
    NodeOverride change;
    change.node = node;
    change.local =
        glm::scale(glm::translate(glm::dmat4(1), rest.translation) * glm::mat4_cast(rest.rotation), rest.scale);
    motion.overrides.push_back(change);
  }
  return motion;
}

std::vector<NodeOverride> Combine(const std::vector<NodeOverride>& animated, const std::vector<NodeOverride>& asked) {
  std::vector<NodeOverride> both = asked;
  std::map<uint32_t, size_t> place;
  for (size_t i = 0; i < both.size(); ++i) place[both[i].node] = i;
  for (const NodeOverride& change : animated) {
    const auto found = place.find(change.node);
    if (found == place.end()) {
      both.push_back(change);
    } else if (!both[found->second].local) {
      both[found->second].local = change.local;
    }
  }
  return both;
}

}  // namespace halfshade
