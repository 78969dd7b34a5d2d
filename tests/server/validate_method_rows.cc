// Every option of every method, on both sides of its bounds.
#include <cmath>
#include <limits>

#include "tests/server/validate_rows.h"

namespace halfshade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::vector<ValidateRow> MethodRows() {
  using Code = absl::StatusCode;
  using Request = v1::RenderRequest;
  const Code ok = Code::kOk, bad = Code::kInvalidArgument;
  return {
      {"MethodHard", [](Request& r) { r.mutable_method()->mutable_hard(); }, ok, ""},
      {"HardMapSizeLow", [](Request& r) { r.mutable_method()->mutable_hard()->set_map_size(15); }, bad,
       "method.hard.map_size: 15; must be 16 to 8192"},
      {"HardMapSizeHigh", [](Request& r) { r.mutable_method()->mutable_hard()->set_map_size(8192); }, ok, ""},
      {"KZero", [](Request& r) { r.mutable_method()->mutable_multi_map()->set_k(0); }, bad,
       "method.multi_map.k: 0; must be 1 to 4096"},
      {"KOne", [](Request& r) { r.mutable_method()->mutable_multi_map()->set_k(1); }, ok, ""},
      {"KHigh", [](Request& r) { r.mutable_method()->mutable_multi_map()->set_k(4097); }, bad,
       "method.multi_map.k: 4097; must be 1 to 4096"},
      {"SsmMapSizeLow", [](Request& r) { r.mutable_method()->mutable_ssm()->set_occluder_map_size(15); }, bad,
       "method.ssm.occluder_map_size: 15; must be 16 to 1024"},
      {"SsmMapSizeHigh", [](Request& r) { r.mutable_method()->mutable_ssm()->set_occluder_map_size(1025); }, bad,
       "method.ssm.occluder_map_size: 1025; must be 16 to 1024"},
      {"SsmPassesZero", [](Request& r) { r.mutable_method()->mutable_ssm()->set_passes(0); }, bad,
       "method.ssm.passes: 0; must be 1 to 2"},
      {"SsmPassesHigh", [](Request& r) { r.mutable_method()->mutable_ssm()->set_passes(3); }, bad,
       "method.ssm.passes: 3; must be 1 to 2"},
      {"SsmSubLightsZero", [](Request& r) { r.mutable_method()->mutable_ssm()->set_sub_lights(0); }, bad,
       "method.ssm.sub_lights: 0; must be 1 to 8"},
      {"SsmSubLightsHigh", [](Request& r) { r.mutable_method()->mutable_ssm()->set_sub_lights(9); }, bad,
       "method.ssm.sub_lights: 9; must be 1 to 8"},
      {"SsmBinsZero", [](Request& r) { r.mutable_method()->mutable_ssm()->set_bins(0); }, bad,
       "method.ssm.bins: 0; must be 1 to 16"},
      {"SsmBinsHigh", [](Request& r) { r.mutable_method()->mutable_ssm()->set_bins(17); }, bad,
       "method.ssm.bins: 17; must be 1 to 16"},
      {"SsmResolveUnknown", [](Request& r) { r.mutable_method()->mutable_ssm()->set_resolve(v1::SsmResolve(9)); }, bad,
       "method.ssm.resolve: 9; no such resolve"},
      {"SsmAccumulationUnknown",
       [](Request& r) { r.mutable_method()->mutable_ssm()->set_accumulation(v1::SsmAccumulation(9)); }, bad,
       "method.ssm.accumulation: 9; no such accumulation"},
      {"SsmBlendUnknown", [](Request& r) { r.mutable_method()->mutable_ssm()->set_blend(v1::SsmBlend(9)); }, bad,
       "method.ssm.blend: 9; no such blend"},
      {"SsmBlendWithoutScatter", [](Request& r) { r.mutable_method()->mutable_ssm()->set_blend(v1::SSM_BLEND_FP16); },
       bad, "method.ssm.blend: SSM_BLEND_FP16; needs accumulation SCATTER"},
      {"SsmScatterToPixels",
       [](Request& r) {
         r.mutable_method()->mutable_ssm()->set_accumulation(v1::SSM_ACCUMULATION_SCATTER);
         r.mutable_method()->mutable_ssm()->set_resolve(v1::SSM_RESOLVE_PIXELS);
       },
       bad, "method.ssm.resolve: SSM_RESOLVE_PIXELS; must be MAP"},
      {"SsmScatterWithBins",
       [](Request& r) {
         r.mutable_method()->mutable_ssm()->set_accumulation(v1::SSM_ACCUMULATION_SCATTER);
         r.mutable_method()->mutable_ssm()->set_bins(4);
       },
       bad, "method.ssm.bins: 4; needs accumulation BINNED"},
      {"SsmScatter",
       [](Request& r) {
         v1::SsmOptions* ssm = r.mutable_method()->mutable_ssm();
         ssm->set_accumulation(v1::SSM_ACCUMULATION_SCATTER);
         ssm->set_resolve(v1::SSM_RESOLVE_MAP);
         ssm->set_blend(v1::SSM_BLEND_FP16_BATCHED);
         ssm->set_passes(2);
         ssm->set_sub_lights(8);
         ssm->set_coverage(true);
       },
       ok, ""},
      {"SsmMap", [](Request& r) { r.mutable_method()->mutable_ssm()->set_resolve(v1::SSM_RESOLVE_MAP); }, ok, ""},
      {"SsmAtItsLowerBounds",
       [](Request& r) {
         v1::SsmOptions* ssm = r.mutable_method()->mutable_ssm();
         ssm->set_occluder_map_size(16);
         ssm->set_passes(1);
         ssm->set_sub_lights(1);
         ssm->set_bins(1);
       },
       ok, ""},
      {"SsmAtItsUpperBounds",
       [](Request& r) {
         v1::SsmOptions* ssm = r.mutable_method()->mutable_ssm();
         ssm->set_occluder_map_size(1024);
         ssm->set_passes(2);
         ssm->set_sub_lights(8);
         ssm->set_bins(16);
       },
       ok, ""},
      {"PcssMapSizeLow", [](Request& r) { r.mutable_method()->mutable_pcss()->set_map_size(15); }, bad,
       "method.pcss.map_size: 15; must be 16 to 8192"},
      {"PcssTapsOne",
       [](Request& r) {
         r.mutable_method()->mutable_pcss()->set_blocker_taps(1);
         r.mutable_method()->mutable_pcss()->set_filter_taps(1);
       },
       ok, ""},
      {"PcssTapsMost",
       [](Request& r) {
         r.mutable_method()->mutable_pcss()->set_blocker_taps(63);
         r.mutable_method()->mutable_pcss()->set_filter_taps(127);
       },
       ok, ""},
      {"PcssBlockerTapsHigh", [](Request& r) { r.mutable_method()->mutable_pcss()->set_blocker_taps(65); }, bad,
       "method.pcss.blocker_taps: 65; must be 1 to 63"},
      {"PcssBlockerTapsEven", [](Request& r) { r.mutable_method()->mutable_pcss()->set_blocker_taps(8); }, bad,
       "method.pcss.blocker_taps: 8; must be odd"},
      {"PcssFilterTapsZero", [](Request& r) { r.mutable_method()->mutable_pcss()->set_filter_taps(0); }, bad,
       "method.pcss.filter_taps: 0; must be 1 to 127"},
      {"PcssFilterTapsHigh", [](Request& r) { r.mutable_method()->mutable_pcss()->set_filter_taps(129); }, bad,
       "method.pcss.filter_taps: 129; must be 1 to 127"},
      {"PcssWeightsUnknown", [](Request& r) { r.mutable_method()->mutable_pcss()->set_weights(v1::FilterWeights(9)); },
       bad, "method.pcss.weights: 9; no such weights"},
      {"PdsmKLow", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_k(3); }, bad,
       "method.pdsm.k: 3; must be 4 to 256"},
      {"PdsmKLeast", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_k(4); }, ok, ""},
      {"PdsmKMost", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_k(256); }, ok, ""},
      {"PdsmKHigh", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_k(257); }, bad,
       "method.pdsm.k: 257; must be 4 to 256"},
      {"PdsmMapSizeLow", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_map_size(15); }, bad,
       "method.pdsm.map_size: 15; must be 16 to 8192"},
      {"PdsmSizeMost", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_pdsm_size(4096); }, ok, ""},
      {"PdsmSizeHigh", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_pdsm_size(4097); }, bad,
       "method.pdsm.pdsm_size: 4097; must be 16 to 4096"},
      {"PdsmEpsLeast", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_eps(1.0f / 128); }, ok, ""},
      {"PdsmEpsBelowHalfAStep", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_eps(0.00775f); }, bad,
       "method.pdsm.eps: 0.007"},
      {"PdsmEpsHigh", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_eps(0.5f); }, bad,
       "method.pdsm.eps: 0.5; must be"},
      {"PdsmEpsNan", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_eps(float(kNan)); }, bad,
       "method.pdsm.eps: nan"},
      {"PdsmConstructionUnknown",
       [](Request& r) { r.mutable_method()->mutable_pdsm()->set_construction(v1::PdsmConstruction(9)); }, bad,
       "method.pdsm.construction: 9; no such construction"},
      {"PdsmLayoutUnknown", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_layout(v1::PdsmLayout(9)); }, bad,
       "method.pdsm.layout: 9; no such layout"},
      {"PdsmFilterUnknown", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_filter(v1::PdsmFilter(9)); }, bad,
       "method.pdsm.filter: 9; no such filter"},
      {"PdsmVolumeOfEvents",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_layout(v1::PDSM_LAYOUT_VOLUME);
         r.mutable_method()->mutable_pdsm()->set_construction(v1::PDSM_CONSTRUCTION_SCATTER);
       },
       bad, "method.pdsm.layout: PDSM_LAYOUT_VOLUME; PDSM_CONSTRUCTION_SCATTER makes INDEXED"},
      {"PdsmIndexedSlices",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_layout(v1::PDSM_LAYOUT_INDEXED);
         r.mutable_method()->mutable_pdsm()->set_construction(v1::PDSM_CONSTRUCTION_SLICES);
       },
       bad, "method.pdsm.layout: PDSM_LAYOUT_INDEXED; PDSM_CONSTRUCTION_SLICES makes VOLUME"},
      {"PdsmTraversal",
       [](Request& r) { r.mutable_method()->mutable_pdsm()->set_construction(v1::PDSM_CONSTRUCTION_TRAVERSAL); }, ok,
       ""},
      {"PdsmSurfaceOnly", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_surface_only(true); }, ok, ""},
      {"PdsmSurfaceOnlyVolume",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_surface_only(true);
         r.mutable_method()->mutable_pdsm()->set_layout(v1::PDSM_LAYOUT_VOLUME);
       },
       bad, "method.pdsm.surface_only: true; a VOLUME holds slices"},
      {"PdsmSoftEvents", [](Request& r) { r.mutable_method()->mutable_pdsm()->set_soft_events(true); }, ok, ""},
      {"PdsmSoftEventsOfNoPowerOfTwo",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_k(48);
       },
       bad, "method.pdsm.k: 48; with soft_events it must be a power of two"},
      {"PdsmSoftEventsTraversal",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_construction(v1::PDSM_CONSTRUCTION_TRAVERSAL);
       },
       bad, "method.pdsm.soft_events: true; TRAVERSAL has none"},
      {"PdsmSoftEventsVolume",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_layout(v1::PDSM_LAYOUT_VOLUME);
       },
       bad, "method.pdsm.soft_events: true; a VOLUME has no events"},
      {"PdsmSoftEventsOfSurfaces",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_surface_only(true);
       },
       bad, "method.pdsm.surface_only: true; not with soft_events"},
      {"PdsmSoftEpsLeast",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_eps(0.001f);
       },
       ok, ""},
      {"PdsmSoftEpsBelow",
       [](Request& r) {
         r.mutable_method()->mutable_pdsm()->set_soft_events(true);
         r.mutable_method()->mutable_pdsm()->set_eps(0.00099f);
       },
       bad, "method.pdsm.eps: 0.0009899999713525176; must be 0.001 to below 0.5"},
      {"SssmLeast",
       [](Request& r) {
         v1::SssmOptions* sssm = r.mutable_method()->mutable_sssm();
         sssm->set_map_size(16);
         sssm->set_blocker_taps(1);
         sssm->set_filter_taps(1);
         sssm->set_alpha(0);
         sssm->set_beta(0);
         sssm->set_sub_lights(1);
       },
       ok, ""},
      {"SssmMost",
       [](Request& r) {
         v1::SssmOptions* sssm = r.mutable_method()->mutable_sssm();
         sssm->set_map_size(8192);
         sssm->set_blocker_taps(63);
         sssm->set_filter_taps(127);
         sssm->set_alpha(1e6);
         sssm->set_beta(1e6);
         sssm->set_thresholds(v1::SSSM_THRESHOLDS_ABSOLUTE);
         sssm->set_sub_lights(8);
       },
       ok, ""},
      {"SssmMapSizeHigh", [](Request& r) { r.mutable_method()->mutable_sssm()->set_map_size(8193); }, bad,
       "method.sssm.map_size: 8193; must be 16 to 8192"},
      {"SssmBlockerTapsEven", [](Request& r) { r.mutable_method()->mutable_sssm()->set_blocker_taps(28); }, bad,
       "method.sssm.blocker_taps: 28; must be odd"},
      {"SssmFilterTapsHigh", [](Request& r) { r.mutable_method()->mutable_sssm()->set_filter_taps(129); }, bad,
       "method.sssm.filter_taps: 129; must be 1 to 127"},
      {"SssmWeightsUnknown", [](Request& r) { r.mutable_method()->mutable_sssm()->set_weights(v1::FilterWeights(3)); },
       bad, "method.sssm.weights: 3; no such weights"},
      {"SssmAlphaNegative", [](Request& r) { r.mutable_method()->mutable_sssm()->set_alpha(-0.5f); }, bad,
       "method.sssm.alpha: -0.5; must be 0 to 1e+06"},
      {"SssmBetaHigh", [](Request& r) { r.mutable_method()->mutable_sssm()->set_beta(2e6f); }, bad,
       "method.sssm.beta: 2e+06; must be 0 to 1e+06"},
      {"SssmAlphaNan", [](Request& r) { r.mutable_method()->mutable_sssm()->set_alpha(std::nanf("")); }, bad,
       "method.sssm.alpha: nan; must be finite"},
      {"SssmThresholdsUnknown",
       [](Request& r) { r.mutable_method()->mutable_sssm()->set_thresholds(v1::SssmThresholds(7)); }, bad,
       "method.sssm.thresholds: 7; no such thresholds"},
      {"SssmSubLightsZero", [](Request& r) { r.mutable_method()->mutable_sssm()->set_sub_lights(0); }, bad,
       "method.sssm.sub_lights: 0; must be 1 to 8"},
      {"SssmSubLightsHigh", [](Request& r) { r.mutable_method()->mutable_sssm()->set_sub_lights(9); }, bad,
       "method.sssm.sub_lights: 9; must be 1 to 8"},
      {"PcssGaussian", [](Request& r) { r.mutable_method()->mutable_pcss()->set_weights(v1::FILTER_WEIGHTS_GAUSSIAN); },
       ok, ""},
      {"ShaftRowsLeast", [](Request& r) { r.mutable_method()->mutable_shaft()->set_rows(8); }, ok, ""},
      {"ShaftRowsMost", [](Request& r) { r.mutable_method()->mutable_shaft()->set_rows(64); }, ok, ""},
      {"ShaftRowsLow", [](Request& r) { r.mutable_method()->mutable_shaft()->set_rows(4); }, bad,
       "method.shaft.rows: 4; must be 8, 16, 32 or 64"},
      {"ShaftRowsBetween", [](Request& r) { r.mutable_method()->mutable_shaft()->set_rows(24); }, bad,
       "method.shaft.rows: 24; must be 8, 16, 32 or 64"},
      {"ShaftRowsHigh", [](Request& r) { r.mutable_method()->mutable_shaft()->set_rows(128); }, bad,
       "method.shaft.rows: 128; must be 8, 16, 32 or 64"},
      {"ShaftSparse", [](Request& r) { r.mutable_method()->mutable_shaft()->set_sparse(true); }, ok, ""},
      {"RaysZero", [](Request& r) { r.mutable_method()->mutable_ray()->set_rays(0); }, bad,
       "method.ray.rays: 0; must be 1 to 65536"},
      {"RaysOne", [](Request& r) { r.mutable_method()->mutable_ray()->set_rays(1); }, ok, ""},
      {"RaysMost", [](Request& r) { r.mutable_method()->mutable_ray()->set_rays(65536); }, ok, ""},
      {"RaysHigh", [](Request& r) { r.mutable_method()->mutable_ray()->set_rays(65537); }, bad,
       "method.ray.rays: 65537; must be 1 to 65536"},
      {"FilteredAndAdaptive",
       [](Request& r) {
         r.mutable_method()->mutable_ray()->set_filtered(true);
         r.mutable_method()->mutable_ray()->set_adaptive(true);
       },
       bad, "method.ray.filtered: true, and adaptive too; only one of them"},
      {"Filtered", [](Request& r) { r.mutable_method()->mutable_ray()->set_filtered(true); }, ok, ""},
      {"StopErrorZero", [](Request& r) { r.mutable_method()->mutable_ray()->set_stop_error(0); }, bad,
       "method.ray.stop_error: 0; must be over 0 and below 1"},
      {"StopErrorLow", [](Request& r) { r.mutable_method()->mutable_ray()->set_stop_error(1e-6f); }, ok, ""},
      {"StopErrorOne", [](Request& r) { r.mutable_method()->mutable_ray()->set_stop_error(1); }, bad,
       "method.ray.stop_error: 1; must be over 0 and below 1"},
      {"StopErrorNan",
       [](Request& r) { r.mutable_method()->mutable_ray()->set_stop_error(std::numeric_limits<float>::quiet_NaN()); },
       bad, "method.ray.stop_error: nan; must be finite"},
      {"MultiMapMapSize", [](Request& r) { r.mutable_method()->mutable_multi_map()->set_map_size(9000); }, bad,
       "method.multi_map.map_size: 9000"},
      {"MethodShaft", [](Request& r) { r.mutable_method()->mutable_shaft(); }, ok, ""},
      {"MethodAuto", [](Request& r) { r.mutable_method()->mutable_auto_(); }, ok, ""},
  };
}

}  // namespace halfshade
