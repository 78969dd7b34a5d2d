#include "renderer/renderer.h"
#include "renderer/shadow/hard/hard.h"
#include "renderer/shadow/multi_map/multi_map.h"
#include "renderer/shadow/pcss/pcss.h"
#include "renderer/shadow/pdsm/pdsm.h"
#include "renderer/shadow/ray/ray.h"
#include "renderer/shadow/shadow_method.h"
#include "renderer/shadow/shaft/shaft.h"
#include "renderer/shadow/ssm/ssm.h"

namespace halfshade {

const std::vector<RegisteredMethod>& MethodRegistry() {
  static const HardMethod hard;
  static const MultiMapMethod multi_map;
  static const RayMethod ray;
  static const PcssMethod pcss;
  static const SsmMethod ssm;
  static const PdsmMethod pdsm;
  static const ShaftMethod shaft;
  static const std::vector<RegisteredMethod> methods = {
      {"hard", &hard}, {"multi_map", &multi_map}, {"ray", &ray},    {"pcss", &pcss},
      {"ssm", &ssm},   {"pdsm", &pdsm},           {"shaft", &shaft}};
  return methods;
}

const RegisteredMethod& FindMethod(const MethodOptions& options) { return MethodRegistry()[options.index()]; }

std::vector<std::string> RegisteredMethods() {
  std::vector<std::string> names;
  for (const RegisteredMethod& registered : MethodRegistry()) names.push_back(registered.name);
  return names;
}

}  // namespace halfshade
