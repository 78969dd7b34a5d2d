#include <algorithm>
#include <bit>

#include "renderer/status.h"
#include "server/validate_field.h"

namespace halfshade {
namespace {

constexpr int kMinMapSize = 16;
constexpr int kMaxMapSize = 8192;
constexpr int kMaxMaps = 4096;
constexpr int kMaxRays = 65536;
constexpr int kMaxBlockerTaps = 63;
constexpr int kMaxFilterTaps = 127;
constexpr float kMaxThreshold = 1e6f;
constexpr int kMaxOccluderMapSize = 1024;  // tables count to that many patches a side, of four texels each
constexpr int kMaxSubLights = 8;
constexpr int kMaxBins = 16;
constexpr int kMinPdsmSamples = 4;
constexpr int kMaxPdsmSamples = 256;
constexpr int kMaxPdsmSize = 4096;
constexpr float kLargestEps = 0.5f;
// Ramps are nearly straight already: a larger one saves a tenth of the memory, and shows.
constexpr float kSoftEps = 0.002f;
constexpr double kLeastSoftEps = 0.001;  // half a step of a display's 8 bits, and less than any other error here

// Of a window with a tap in its middle.
absl::Status CheckTaps(const std::string& field, uint32_t taps, int most, int* result) {
  RETURN_IF_ERROR(CheckRange(field, taps, 1, most));
  if (taps % 2 == 0) return FieldError(field, std::to_string(taps) + "; must be odd");
  *result = int(taps);
  return absl::OkStatus();
}

// What PCSS and SSSM share. `method`: the field.
template <typename Asked, typename Options>
absl::Status CheckWindows(const std::string& method, const Asked& asked, Options* options) {
  if (asked.has_map_size()) {
    RETURN_IF_ERROR(CheckRange(method + ".map_size", asked.map_size(), kMinMapSize, kMaxMapSize));
    options->map_size = int(asked.map_size());
  }
  if (asked.has_blocker_taps()) {
    RETURN_IF_ERROR(CheckTaps(method + ".blocker_taps", asked.blocker_taps(), kMaxBlockerTaps, &options->blocker_taps));
  }
  if (asked.has_filter_taps()) {
    RETURN_IF_ERROR(CheckTaps(method + ".filter_taps", asked.filter_taps(), kMaxFilterTaps, &options->filter_taps));
  }
  if (!v1::FilterWeights_IsValid(asked.weights())) {
    return FieldError(method + ".weights", std::to_string(asked.weights()) + "; no such weights");
  }
  if (asked.weights() == v1::FILTER_WEIGHTS_MEAN) options->weights = FilterWeights::kMean;
  if (asked.weights() == v1::FILTER_WEIGHTS_GAUSSIAN) options->weights = FilterWeights::kGaussian;
  if (asked.has_skip()) options->skips = asked.skip();
  return absl::OkStatus();
}

absl::Status CheckThreshold(const std::string& field, float threshold, float* result) {
  RETURN_IF_ERROR(CheckFinite(field, threshold));
  RETURN_IF_ERROR(CheckRange(field, threshold, 0, kMaxThreshold));
  *result = threshold;
  return absl::OkStatus();
}

absl::StatusOr<SssmOptions> CheckSssm(const v1::SssmOptions& asked) {
  SssmOptions options;
  RETURN_IF_ERROR(CheckWindows("method.sssm", asked, &options));
  if (asked.has_alpha()) RETURN_IF_ERROR(CheckThreshold("method.sssm.alpha", asked.alpha(), &options.alpha));
  if (asked.has_beta()) RETURN_IF_ERROR(CheckThreshold("method.sssm.beta", asked.beta(), &options.beta));
  if (!v1::SssmThresholds_IsValid(asked.thresholds())) {
    return FieldError("method.sssm.thresholds", std::to_string(asked.thresholds()) + "; no such thresholds");
  }
  if (asked.thresholds() == v1::SSSM_THRESHOLDS_ABSOLUTE) options.thresholds = SssmThresholds::kAbsolute;
  if (asked.has_sub_lights()) {
    RETURN_IF_ERROR(CheckRange("method.sssm.sub_lights", asked.sub_lights(), 1, kMaxSubLights));
    options.sub_lights = int(asked.sub_lights());
  }
  return options;
}

// Enums that are not there, and combinations that have no meaning.
absl::Status CheckSsmChoices(const v1::SsmOptions& asked) {
  if (!v1::SsmResolve_IsValid(asked.resolve())) {
    return FieldError("method.ssm.resolve", std::to_string(asked.resolve()) + "; no such resolve");
  }
  if (!v1::SsmAccumulation_IsValid(asked.accumulation())) {
    return FieldError("method.ssm.accumulation", std::to_string(asked.accumulation()) + "; no such accumulation");
  }
  if (!v1::SsmBlend_IsValid(asked.blend())) {
    return FieldError("method.ssm.blend", std::to_string(asked.blend()) + "; no such blend");
  }
  if (asked.accumulation() == v1::SSM_ACCUMULATION_SCATTER) {
    if (asked.resolve() == v1::SSM_RESOLVE_PIXELS) {
      return FieldError("method.ssm.resolve", "SSM_RESOLVE_PIXELS; must be MAP, which accumulation SCATTER draws");
    }
    if (asked.has_bins()) {
      return FieldError("method.ssm.bins", std::to_string(asked.bins()) + "; needs accumulation BINNED");
    }
  } else if (asked.blend() != v1::SSM_BLEND_UNSPECIFIED) {
    return FieldError("method.ssm.blend", v1::SsmBlend_Name(asked.blend()) + "; needs accumulation SCATTER");
  }
  return absl::OkStatus();
}

absl::StatusOr<SsmOptions> CheckSsm(const v1::SsmOptions& asked) {
  RETURN_IF_ERROR(CheckSsmChoices(asked));
  SsmOptions options;
  options.projects_map = asked.resolve() == v1::SSM_RESOLVE_MAP;
  if (asked.accumulation() == v1::SSM_ACCUMULATION_SCATTER) {  // as printed, unless told otherwise
    options.accumulation = SsmAccumulation::kScatter;
    options.projects_map = true;
    options.sub_lights = 1;
    options.measures_coverage = false;
  }
  if (asked.blend() == v1::SSM_BLEND_FP16) options.blend = SsmBlend::kFp16;
  if (asked.blend() == v1::SSM_BLEND_FP16_BATCHED) options.blend = SsmBlend::kFp16Batched;
  if (asked.occluder_map_size() != 0) {
    RETURN_IF_ERROR(
        CheckRange("method.ssm.occluder_map_size", asked.occluder_map_size(), kMinMapSize, kMaxOccluderMapSize));
    options.occluder_map_size = int(asked.occluder_map_size());
  }
  if (asked.has_passes()) {
    RETURN_IF_ERROR(CheckRange("method.ssm.passes", asked.passes(), 1, 2));
    options.passes = int(asked.passes());
  }
  if (asked.has_sub_lights()) {
    RETURN_IF_ERROR(CheckRange("method.ssm.sub_lights", asked.sub_lights(), 1, kMaxSubLights));
    options.sub_lights = int(asked.sub_lights());
  }
  if (asked.has_bins()) {
    RETURN_IF_ERROR(CheckRange("method.ssm.bins", asked.bins(), 1, kMaxBins));
    options.bins = int(asked.bins());
  }
  if (asked.has_coverage()) options.measures_coverage = asked.coverage();
  return options;
}

absl::StatusOr<PdsmOptions> CheckPdsm(const v1::PdsmOptions& asked) {
  PdsmOptions options;
  if (asked.has_k()) {
    RETURN_IF_ERROR(CheckRange("method.pdsm.k", asked.k(), kMinPdsmSamples, kMaxPdsmSamples));
    options.k = int(asked.k());
  }
  if (asked.has_map_size()) {
    RETURN_IF_ERROR(CheckRange("method.pdsm.map_size", asked.map_size(), kMinMapSize, kMaxMapSize));
    options.map_size = int(asked.map_size());
  }
  if (asked.has_pdsm_size()) {
    RETURN_IF_ERROR(CheckRange("method.pdsm.pdsm_size", asked.pdsm_size(), kMinMapSize, kMaxPdsmSize));
    options.pdsm_size = int(asked.pdsm_size());
  }
  options.has_soft_events = asked.soft_events();
  options.is_surface_only = asked.surface_only();
  // An event is 1/k: a bound below half of that keeps both ends of each, but for ramps.
  const double least_eps = options.has_soft_events ? kLeastSoftEps : double(0.5f / float(options.k));
  options.eps = options.has_soft_events ? kSoftEps : std::max(options.eps, float(least_eps));
  if (asked.has_eps()) {
    RETURN_IF_ERROR(CheckFinite("method.pdsm.eps", asked.eps()));
    if (!(asked.eps() >= least_eps && asked.eps() < kLargestEps)) {
      return FieldError("method.pdsm.eps", NumberText(asked.eps()) + "; must be " + NumberText(least_eps) +
                                               (options.has_soft_events ? "" : ", which is 1/(2k),") + " to below " +
                                               NumberText(kLargestEps));
    }
    options.eps = asked.eps();
  }
  if (!v1::PdsmConstruction_IsValid(asked.construction())) {
    return FieldError("method.pdsm.construction", std::to_string(asked.construction()) + "; no such construction");
  }
  if (!v1::PdsmLayout_IsValid(asked.layout())) {
    return FieldError("method.pdsm.layout", std::to_string(asked.layout()) + "; no such layout");
  }
  if (!v1::PdsmFilter_IsValid(asked.filter())) {
    return FieldError("method.pdsm.filter", std::to_string(asked.filter()) + "; no such filter");
  }
  // Slices make a volume and events make functions; one of both names the other.
  if (asked.construction() == v1::PDSM_CONSTRUCTION_UNSPECIFIED) {
    const bool is_of_events = options.has_soft_events || options.is_surface_only;
    options.layout =
        asked.layout() == v1::PDSM_LAYOUT_INDEXED || (is_of_events && asked.layout() == v1::PDSM_LAYOUT_UNSPECIFIED)
            ? PdsmLayout::kIndexed
            : PdsmLayout::kVolume;
    options.construction =
        options.layout == PdsmLayout::kIndexed ? PdsmConstruction::kScatter : PdsmConstruction::kSlices;
  } else {
    options.construction = PdsmConstruction(asked.construction() - v1::PDSM_CONSTRUCTION_TRAVERSAL);
    options.layout = options.construction == PdsmConstruction::kSlices ? PdsmLayout::kVolume : PdsmLayout::kIndexed;
    if (asked.layout() != v1::PDSM_LAYOUT_UNSPECIFIED &&
        PdsmLayout(asked.layout() - v1::PDSM_LAYOUT_INDEXED) != options.layout) {
      return FieldError("method.pdsm.layout", v1::PdsmLayout_Name(asked.layout()) + "; " +
                                                  v1::PdsmConstruction_Name(asked.construction()) + " makes " +
                                                  (options.layout == PdsmLayout::kVolume ? "VOLUME" : "INDEXED"));
    }
  }
  if (asked.filter() != v1::PDSM_FILTER_UNSPECIFIED) {
    options.filter = PdsmFilter(asked.filter() - v1::PDSM_FILTER_NEAREST);
  }
  if (options.has_soft_events && !std::has_single_bit(uint32_t(options.k))) {
    return FieldError("method.pdsm.k", std::to_string(options.k) + "; with soft_events it must be a power of two");
  }
  if (options.has_soft_events && options.construction != PdsmConstruction::kScatter) {
    return FieldError("method.pdsm.soft_events", std::string("true; ") + (options.layout == PdsmLayout::kVolume
                                                                              ? "a VOLUME has no events"
                                                                              : "TRAVERSAL has none: only SCATTER"));
  }
  if (options.is_surface_only && options.layout == PdsmLayout::kVolume) {
    return FieldError("method.pdsm.surface_only", "true; a VOLUME holds slices, not surfaces: only INDEXED");
  }
  if (options.is_surface_only && options.has_soft_events) {
    return FieldError("method.pdsm.surface_only", "true; not with soft_events");
  }
  return options;
}

absl::StatusOr<ShaftOptions> CheckShaft(const v1::ShaftOptions& asked) {
  ShaftOptions options;
  if (asked.has_rows()) {
    const uint32_t rows = asked.rows();
    if (rows != 8 && rows != 16 && rows != 32 && rows != 64) {
      return FieldError("method.shaft.rows", std::to_string(rows) + "; must be 8, 16, 32 or 64");
    }
    options.rows = int(rows);
  }
  options.is_sparse = asked.sparse();
  return options;
}

}  // namespace

absl::Status CheckMethod(const v1::Method& method, RenderRequest* result) {
  switch (method.method_case()) {
    case v1::Method::kHard: {
      HardOptions options;
      if (method.hard().has_map_size()) {
        RETURN_IF_ERROR(CheckRange("method.hard.map_size", method.hard().map_size(), kMinMapSize, kMaxMapSize));
        options.map_size = int(method.hard().map_size());
      }
      result->method = options;
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kMultiMap: {
      MultiMapOptions options;
      if (method.multi_map().has_k()) {
        RETURN_IF_ERROR(CheckRange("method.multi_map.k", method.multi_map().k(), 1, kMaxMaps));
        options.k = int(method.multi_map().k());
      }
      if (method.multi_map().has_map_size()) {
        RETURN_IF_ERROR(
            CheckRange("method.multi_map.map_size", method.multi_map().map_size(), kMinMapSize, kMaxMapSize));
        options.map_size = int(method.multi_map().map_size());
      }
      result->method = options;
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kRay: {
      RayOptions options;
      if (method.ray().has_rays()) {
        RETURN_IF_ERROR(CheckRange("method.ray.rays", method.ray().rays(), 1, kMaxRays));
        options.rays = int(method.ray().rays());
      }
      options.is_adaptive = method.ray().adaptive();
      if (method.ray().has_stop_error()) {
        const float stop_error = method.ray().stop_error();
        RETURN_IF_ERROR(CheckFinite("method.ray.stop_error", stop_error));
        if (!(stop_error > 0 && stop_error < 1)) {
          return FieldError("method.ray.stop_error", NumberText(stop_error) + "; must be over 0 and below 1");
        }
        options.stop_error = stop_error;
      }
      options.is_filtered = method.ray().filtered();
      if (options.is_filtered && options.is_adaptive) {
        return FieldError("method.ray.filtered", "true, and adaptive too; only one of them");
      }
      result->method = options;
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kPcss: {
      PcssOptions options;
      RETURN_IF_ERROR(CheckWindows("method.pcss", method.pcss(), &options));
      result->method = options;
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kSssm: {
      ASSIGN_OR_RETURN(result->method, CheckSssm(method.sssm()));
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kSsm: {
      ASSIGN_OR_RETURN(result->method, CheckSsm(method.ssm()));
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kPdsm: {
      ASSIGN_OR_RETURN(result->method, CheckPdsm(method.pdsm()));
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kShaft: {
      ASSIGN_OR_RETURN(result->method, CheckShaft(method.shaft()));
      result->method_reason = "asked for";
      return absl::OkStatus();
    }
    case v1::Method::kAuto:
    case v1::Method::METHOD_NOT_SET:
      result->is_auto = true;  // ValidateRender chooses, which knows the scene
      return absl::OkStatus();
    default: {
      const auto* field = v1::Method::descriptor()->FindFieldByNumber(method.method_case());
      return NotAvailable("method." + field->name(), "this method");
    }
  }
}

}  // namespace halfshade
