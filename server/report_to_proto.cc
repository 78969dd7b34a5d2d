#include "server/report_to_proto.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace halfshade {
namespace {

// In the order of renderer's OutputKind.
constexpr v1::OutputKind kKinds[] = {
    v1::OUTPUT_KIND_FRAME,    v1::OUTPUT_KIND_VISIBILITY,      v1::OUTPUT_KIND_DEPTH,
    v1::OUTPUT_KIND_NORMAL,   v1::OUTPUT_KIND_ALBEDO,          v1::OUTPUT_KIND_OBJECT_ID,
    v1::OUTPUT_KIND_POSITION, v1::OUTPUT_KIND_SOFT_SHADOW_MAP, v1::OUTPUT_KIND_PENUMBRA_WIDTH};
static_assert(kKinds[int(OutputKind::kPenumbraWidth)] == v1::OUTPUT_KIND_PENUMBRA_WIDTH);
static_assert(int(Encoding::kPng) == v1::ENCODING_PNG && int(Encoding::kRawF16) == v1::ENCODING_RAW_F16);

// Options arrive by proto field name: written through reflection into the method's own message.
void SetOptions(const RenderReport& report, v1::Method* method) {
  const auto* oneof_field = v1::Method::descriptor()->FindFieldByName(report.method);
  if (oneof_field == nullptr) return;
  google::protobuf::Message* options = method->GetReflection()->MutableMessage(method, oneof_field);
  for (const auto& [name, value] : report.options) {
    const auto* field = options->GetDescriptor()->FindFieldByName(name);
    if (field == nullptr || value == kChosen) continue;  // stays open
    using Field = google::protobuf::FieldDescriptor;
    const auto* reflection = options->GetReflection();
    switch (field->cpp_type()) {
      case Field::CPPTYPE_UINT32:
        reflection->SetUInt32(options, field, uint32_t(std::strtoul(value.c_str(), nullptr, 10)));
        break;
      case Field::CPPTYPE_FLOAT:
        reflection->SetFloat(options, field, std::strtof(value.c_str(), nullptr));
        break;
      case Field::CPPTYPE_BOOL:
        reflection->SetBool(options, field, value == "true");
        break;
      case Field::CPPTYPE_ENUM: {
        // "MEAN" of FILTER_WEIGHTS_MEAN: the names end with it.
        for (int i = 0; i < field->enum_type()->value_count(); ++i) {
          const auto* named = field->enum_type()->value(i);
          if (named->name().ends_with("_" + value)) reflection->SetEnum(options, field, named);
        }
        break;
      }
      default:
        break;
    }
  }
}

}  // namespace

v1::RenderReport ToProto(const RenderReport& report) {
  v1::RenderReport proto;
  proto.set_method(report.method);
  SetOptions(report, proto.mutable_options());
  proto.set_reason(report.reason);
  v1::ErrorReport* error = proto.mutable_error();
  if (report.error.predicted) error->set_predicted(*report.error.predicted);
  if (report.error.measured) error->set_measured(*report.error.measured);
  if (report.error.ci95) error->set_ci95(*report.error.ci95);
  if (report.error.noise) error->set_noise(*report.error.noise);
  if (report.error.bound) error->set_bound(*report.error.bound);
  proto.mutable_share()->set_umbra(report.share_umbra);
  proto.mutable_share()->set_penumbra(report.share_penumbra);
  proto.mutable_share()->set_lit(report.share_lit);
  proto.set_max_sum(report.max_sum);
  v1::Timing* timing = proto.mutable_timing();
  timing->set_upload_ms(report.upload_ms);
  timing->set_light_ms(report.light_ms);
  timing->set_resolve_ms(report.resolve_ms);
  timing->set_shade_ms(report.shade_ms);
  timing->set_readback_ms(report.readback_ms);
  for (const PassReport& pass : report.passes) {
    v1::Pass* out = proto.add_passes();
    out->set_name(pass.name);
    out->set_ms(pass.ms);
    out->set_skipped(pass.is_skipped);
    out->set_reason(pass.reason);
    out->set_count(pass.count);
  }
  for (const CacheReport& cache : report.caches) {
    v1::Cache* out = proto.add_caches();
    out->set_name(cache.name);
    out->set_hits(cache.hits);
    out->set_misses(cache.misses);
    out->set_bytes(cache.bytes);
  }
  return proto;
}

v1::OutputKind ToProto(OutputKind kind) { return kKinds[int(kind)]; }
v1::Encoding ToProto(Encoding encoding) { return v1::Encoding(int(encoding)); }

std::optional<OutputKind> FromProto(v1::OutputKind kind) {
  if (kind == v1::OUTPUT_KIND_UNSPECIFIED) return OutputKind::kFrame;
  const auto* found = std::find(std::begin(kKinds), std::end(kKinds), kind);
  if (found == std::end(kKinds)) return std::nullopt;
  return OutputKind(found - std::begin(kKinds));
}

std::optional<Encoding> FromProto(v1::Encoding encoding) {
  if (encoding == v1::ENCODING_UNSPECIFIED) return Encoding::kPng;
  if (!v1::Encoding_IsValid(encoding)) return std::nullopt;
  return Encoding(int(encoding));
}

std::string ShortName(v1::OutputKind kind) { return v1::OutputKind_Name(kind).substr(std::strlen("OUTPUT_KIND_")); }
std::string ShortName(v1::Encoding encoding) { return v1::Encoding_Name(encoding).substr(std::strlen("ENCODING_")); }

}  // namespace halfshade
