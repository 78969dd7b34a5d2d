// One output of a request, drawn by the test renderer.
#pragma once

#include "tests/support/render_fixture.h"

namespace halfshade {

// The test fails and the image is empty on an error.
inline Image RenderImage(const FlatScene& scene, RenderRequest request, OutputKind kind,
                         RenderReport* report = nullptr) {
  request.outputs = {kind};
  auto result = TestRenderer().Render("test", scene, request, [] { return absl::OkStatus(); });
  TestRenderer().ForgetScene("test");
  EXPECT_OK(result);
  if (!result.ok()) return Image();
  if (report != nullptr) *report = result->report;
  return std::move(result->images[0].image);
}

inline bool AreEqual(const Image& a, const Image& b) {
  return a.size() == b.size() && std::equal(a.data(), a.data() + a.size(), b.data());
}

}  // namespace halfshade
