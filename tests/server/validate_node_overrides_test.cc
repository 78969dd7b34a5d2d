// RenderRequest.node_overrides: what is refused, on both sides of each bound, and what is made of the rest.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>

#include "server/validate.h"
#include "tests/server/validate_request.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using Code = absl::StatusCode;

// Three nodes: "body", an unnamed camera's, "body" again.
FlatScene NamedScene() {
  FlatScene scene = Scene();
  scene.nodes[0].name = "body";
  scene.nodes.push_back(scene.nodes[0]);
  return scene;
}

v1::NodeOverride& Add(v1::RenderRequest& request) { return *request.add_node_overrides(); }

// The identity, but for one element.
void SetTransform(v1::NodeOverride& change, int element = 0, float value = 1) {
  for (int i = 0; i < 16; ++i) change.add_transform(i % 5 == 0 ? 1.0f : 0.0f);
  change.set_transform(element, value);
}

struct Row {
  std::string name;
  std::function<void(v1::NodeOverride&)> change;
  std::string message;  // empty: accepted
};

std::vector<Row> Rows() {
  using Override = v1::NodeOverride;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  return {
      {"ByIndex", [](Override& o) { o.set_index(2); }, ""},
      {"IndexOver", [](Override& o) { o.set_index(3); }, "node_overrides[0].index: 3; the scene has 3 nodes"},
      {"ByName", [](Override& o) { o.set_name("body"); }, ""},
      {"NameUnknown", [](Override& o) { o.set_name("Body"); },
       "node_overrides[0].name: \"Body\"; no node has this name"},
      {"NameEmpty", [](Override& o) { o.set_name(""); }, "node_overrides[0].name: must not be empty"},
      {"NoNode", [](Override& o) { o.set_casts(false); }, "node_overrides[0]: no node; must have a name or an index"},
      {"Transform", [](Override& o) { o.set_index(0), SetTransform(o, 12, 5); }, ""},
      {"TransformOfFifteen", [](Override& o) { o.set_index(0), SetTransform(o), o.mutable_transform()->RemoveLast(); },
       "node_overrides[0].transform: 15 floats; must be none or 16, column-major"},
      {"TransformOfSeventeen", [](Override& o) { o.set_index(0), SetTransform(o), o.add_transform(0); },
       "node_overrides[0].transform: 17 floats"},
      {"TransformNan", [=](Override& o) { o.set_index(0), SetTransform(o, 4, nan); },
       "node_overrides[0].transform[4]: nan; must be finite"},
      {"TransformInfinite", [=](Override& o) { o.set_index(0), SetTransform(o, 15, -infinity); },
       "node_overrides[0].transform[15]: -inf; must be finite"},
      {"TransformAtLimit", [](Override& o) { o.set_index(0), SetTransform(o, 12, 0.99e15f); }, ""},
      {"TransformOverLimit", [](Override& o) { o.set_index(0), SetTransform(o, 12, -1.01e15f); },
       "node_overrides[0].transform[12]: -1010000013033472; must be -1e+15 to 1e+15"},
      {"LastRowWithinTolerance", [](Override& o) { o.set_index(0), SetTransform(o, 7, 0.9e-6f); }, ""},
      {"LastRowBeyondTolerance", [](Override& o) { o.set_index(0), SetTransform(o, 7, 1.1e-6f); },
       "node_overrides[0].transform[7]: 1.0"},
      {"LastOneBeyondTolerance", [](Override& o) { o.set_index(0), SetTransform(o, 15, 0.99f); },
       "node_overrides[0].transform[15]: 0.99"},
      {"FlattenedIsAllowedAsInGltf", [](Override& o) { o.set_index(0), SetTransform(o, 0, 0); }, ""},
  };
}

class NodeOverrideTest : public testing::TestWithParam<Row> {};
INSTANTIATE_TEST_SUITE_P(Fields, NodeOverrideTest, testing::ValuesIn(Rows()),
                         [](const auto& row) { return row.param.name; });

TEST_P(NodeOverrideTest, AnswersWithFieldAndBound) {
  v1::RenderRequest request = Good();
  request.set_width(320);
  GetParam().change(Add(request));
  const auto result = ValidateRender(request, NamedScene(), Limits());
  if (GetParam().message.empty()) {
    EXPECT_OK(result);
  } else {
    EXPECT_THAT(result, StatusIs(Code::kInvalidArgument, testing::StartsWith(GetParam().message)));
  }
}

TEST(NodeOverrideTest, TheLastRowsMessageSaysWhatItMustBe) {
  v1::RenderRequest request = Good();
  Add(request).set_index(0);
  SetTransform(*request.mutable_node_overrides(0), 15, 0.5f);
  EXPECT_THAT(CheckRenderFields(request, Limits()),
              StatusIs(Code::kInvalidArgument,
                       "node_overrides[0].transform[15]: 0.5; must be 1 within 1e-6: the last row is 0 0 0 1"))
      << "known without the scene, before anything is queued";
}

TEST(NodeOverrideTest, ANodeIsChangedOnceWhateverItIsCalled) {
  v1::RenderRequest request = Good();
  Add(request).set_index(1);
  Add(request).set_name("body");
  Add(request).set_index(2);
  EXPECT_OK(ValidateRender(request, NamedScene(), Limits())) << "a name is its first node";
  Add(request).set_index(0);
  EXPECT_THAT(ValidateRender(request, NamedScene(), Limits()),
              StatusIs(Code::kInvalidArgument, "node_overrides[3]: node 0 is changed by node_overrides[1] already"));
}

TEST(NodeOverrideTest, WhatIsNotSaidStaysAndTheLastRowIsMadeExact) {
  v1::RenderRequest request = Good();
  Add(request).set_index(2);
  Add(request).set_name("body");
  SetTransform(*request.mutable_node_overrides(1), 3, 1e-7f);
  request.mutable_node_overrides(1)->set_transform(12, 7);
  request.mutable_node_overrides(1)->set_visible(false);
  request.mutable_node_overrides(1)->set_receives(false);
  const auto result = ValidateRender(request, NamedScene(), Limits());
  ASSERT_OK(result);
  const auto& overrides = result->request.node_overrides;
  ASSERT_EQ(overrides.size(), 2u);
  EXPECT_EQ(overrides[0].node, 2u);
  EXPECT_TRUE(overrides[0].is_visible && overrides[0].casts && overrides[0].receives && !overrides[0].local);
  EXPECT_EQ(overrides[1].node, 0u);
  EXPECT_TRUE(!overrides[1].is_visible && overrides[1].casts && !overrides[1].receives);
  glm::dmat4 moved(1);
  moved[3].x = 7;
  EXPECT_EQ(overrides[1].local, moved);
}

TEST(NodeOverrideTest, ACameraOfTheSceneMovesWithItsNode) {
  v1::RenderRequest request = Good();
  request.mutable_camera()->set_index(0);
  EXPECT_EQ(ValidateRender(request, NamedScene(), Limits())->request.camera.eye_ws, glm::dvec3(0, 0, 4));
  Add(request).set_index(1);
  SetTransform(*request.mutable_node_overrides(0), 12, 9);
  EXPECT_EQ(ValidateRender(request, NamedScene(), Limits())->request.camera.eye_ws, glm::dvec3(9, 0, 0));
}

TEST(NodeOverrideTest, EveryPartOfAChangeIsPartOfTheContentKey) {
  v1::RenderRequest request = Good();
  const auto key = [&] { return ContentKey(kScene, *ValidateRender(request, NamedScene(), Limits()), "1", "gl"); };
  std::set<std::string> keys = {key()};
  v1::NodeOverride& change = Add(request);
  change.set_index(0);
  keys.insert(key());
  change.set_visible(false);
  keys.insert(key());
  change.set_casts(false);
  keys.insert(key());
  change.set_receives(false);
  keys.insert(key());
  SetTransform(change);
  keys.insert(key());
  change.set_transform(13, 1);
  keys.insert(key());
  EXPECT_EQ(keys.size(), 7u);
}

}  // namespace
}  // namespace halfshade
