#include "server/report_to_proto.h"

#include <cstdlib>

namespace halfshade {
namespace {

// Options arrive by proto field name: written through reflection into the method's own message.
void SetOptions(const RenderReport& report, v1::Method* method) {
  const auto* oneof_field = v1::Method::descriptor()->FindFieldByName(report.method);
  if (oneof_field == nullptr) return;
  google::protobuf::Message* options = method->GetReflection()->MutableMessage(method, oneof_field);
  for (const auto& [name, value] : report.options) {
    const auto* field = options->GetDescriptor()->FindFieldByName(name);
    if (field == nullptr) continue;
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

}  // namespace halfshade
