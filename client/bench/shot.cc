#include "client/bench/shot.h"

#include <absl/strings/str_cat.h>

#include <cstring>

#include "renderer/status.h"

namespace halfshade::bench {

v1::RenderRequest VisibilityRequest(const Case& bench_case, const v1::Method& method, v1::CacheMode cache) {
  v1::RenderRequest request = bench_case.request;
  *request.mutable_method() = method;
  request.set_cache(cache);
  request.clear_outputs();
  v1::Output* output = request.add_outputs();
  output->set_kind(v1::OUTPUT_KIND_VISIBILITY);
  output->set_encoding(v1::ENCODING_RAW_F32);
  return request;
}

v1::RenderRequest VisibilityRequest(const Case& bench_case, const Setting& setting, v1::CacheMode cache) {
  v1::RenderRequest request = VisibilityRequest(bench_case, setting.options, cache);
  if (setting.max_error > 0) request.mutable_budget()->set_max_error(setting.max_error);
  return request;
}

absl::StatusOr<Shot> Shoot(Client& client, const v1::RenderRequest& request) {
  ASSIGN_OR_RETURN(v1::RenderResponse response, client.Render(request, nullptr));
  Shot shot;
  ASSIGN_OR_RETURN(shot.visibility, FirstChannel(response.images(0)));
  shot.report = std::move(*response.mutable_report());
  return shot;
}

absl::StatusOr<Image> RawImage(const v1::OutputImage& raw) {
  Image image(int(raw.width()), int(raw.height()), int(raw.channels()));
  if (image.size() == 0 || raw.data().size() != image.size() * sizeof(float)) {
    return absl::InternalError(absl::StrCat("an image of ", raw.data().size(), " bytes for ", raw.width(), "x",
                                            raw.height(), "x", raw.channels()));
  }
  std::memcpy(image.data(), raw.data().data(), raw.data().size());
  return image;
}

absl::StatusOr<Image> FirstChannel(const v1::OutputImage& raw) {
  ASSIGN_OR_RETURN(const Image all, RawImage(raw));
  Image first(all.width(), all.height(), 1);
  for (size_t i = 0; i < first.size(); ++i) first.data()[i] = all.data()[i * all.channels()];
  return first;
}

}  // namespace halfshade::bench
