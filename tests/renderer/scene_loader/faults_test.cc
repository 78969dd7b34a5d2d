// Every broken glTF is refused with the JSON pointer of its fault.
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/renderer/scene_loader/gltf_builder.h"
#include "tests/support/status_matchers.h"

namespace halfshade {
namespace {

using testing::HasSubstr;

struct Fault {
  std::string name;
  std::function<void(GltfBuilder&)> plant;
  std::string message;  // how the error starts
};

std::vector<Fault> Faults() {
  return {
      {"AssetMissing", [](auto& g) { g.json.erase("asset"); }, "/asset: missing"},
      {"Version1", [](auto& g) { g.json["asset"]["version"] = "1.0"; }, "/asset/version: \"1.0\"; only 2.0"},
      {"VersionNumber", [](auto& g) { g.json["asset"]["version"] = 2.0; }, "/asset/version: must be a string"},
      {"MinVersion", [](auto& g) { g.json["asset"]["minVersion"] = "2.1"; }, "/asset/minVersion: \"2.1\""},
      {"RequiredExtension", [](auto& g) { g.json["extensionsRequired"] = {"EXT_texture_webp"}; },
       "/extensionsRequired/0: \"EXT_texture_webp\" is not supported"},
      {"MeshesNoArray", [](auto& g) { g.json["meshes"] = 3; }, "/meshes: must be an array"},
      {"NodeNoObject", [](auto& g) { g.json["nodes"][0] = 3; }, "/nodes/0: must be an object"},
      {"NameNoText", [](auto& g) { g.json["nodes"][0]["name"] = 3; }, "/nodes/0/name: must be a string"},

      {"BufferLength0",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 0}}};
       },
       "/buffers/0/byteLength: 0; must be"},
      {"BufferTooShort",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 40}, {"uri", "a%20b.bin"}}};
       },
       "/buffers/0/byteLength: 40; there are 39 bytes"},
      {"BufferWithoutBytes",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 39}}};
       },
       "/buffers/0: has no uri"},
      {"BadDataUri",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 39}, {"uri", "data:;base64,A*"}}};
       },
       "/buffers/0/uri: a malformed data URI"},
      {"AbsentUri",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 39}, {"uri", "b.bin"}}};
       },
       "/buffers/0/uri: \"b.bin\" is not among the files"},
      {"BadEscape",
       [](auto& g) {
         g.json["buffers"] = {{{"byteLength", 39}, {"uri", "a%2"}}};
       },
       "/buffers/0/uri: \"a%2\": a malformed percent"},

      {"ViewOfNoBuffer", [](auto& g) { g.json["bufferViews"][0]["buffer"] = 1; },
       "/bufferViews/0/buffer: 1; the file has 1 buffers"},
      {"ViewPastBuffer", [](auto& g) { g.json["bufferViews"][1]["byteLength"] = 4; },
       "/bufferViews/1/byteLength: 4 from byteOffset 36; /buffers/0 has 39"},
      {"ViewOffsetWraps", [](auto& g) { g.json["bufferViews"][1]["byteOffset"] = 18446744073709551612ull; },
       "/bufferViews/1/byteOffset: 18446744073709551612; must be 0 to 39"},
      {"ViewOffsetNegative", [](auto& g) { g.json["bufferViews"][1]["byteOffset"] = -4; },
       "/bufferViews/1/byteOffset: -4; must be"},
      {"ViewStride", [](auto& g) { g.json["bufferViews"][0]["byteStride"] = 14; }, "/bufferViews/0/byteStride: 14"},

      {"AccessorPastView", [](auto& g) { g.json["accessors"][0]["count"] = 4; },
       "/accessors/0/count: 4 elements pass the end of /bufferViews/0 of 36 bytes"},
      {"AccessorStridePastView", [](auto& g) { g.json["bufferViews"][0]["byteStride"] = 16; },
       "/accessors/0/count: 3 elements pass the end of /bufferViews/0"},
      {"AccessorCountHuge", [](auto& g) { g.json["accessors"][0]["count"] = 4294967297ull; }, "/accessors/0/count: "},
      {"AccessorCountFraction", [](auto& g) { g.json["accessors"][0]["count"] = 2.5; },
       "/accessors/0/count: must be an integer"},
      {"AccessorUnaligned", [](auto& g) { g.json["accessors"][0]["byteOffset"] = 2; },
       "/accessors/0/byteOffset: not aligned"},
      {"AccessorOverlaps", [](auto& g) { g.json["bufferViews"][0]["byteStride"] = 8; },
       "/accessors/0: its elements of 12 bytes overlap at the stride of /bufferViews/0, 8"},
      {"ComponentType", [](auto& g) { g.json["accessors"][0]["componentType"] = 5124; },
       "/accessors/0/componentType: 5124; no such type"},
      {"AccessorType", [](auto& g) { g.json["accessors"][0]["type"] = "VEC5"; },
       "/accessors/0/type: \"VEC5\"; no such"},
      {"StatedMinTooShort",
       [](auto& g) {
         g.json["accessors"][0]["min"] = {0, 0};
       },
       "/accessors/0/min: must be 3"},
      {"ZerosBeyondTheLimit",
       [](auto& g) {
         g.json["accessors"].push_back({{"componentType", 5126}, {"count", 2000000000}, {"type", "VEC3"}});
       },
       "/accessors/2: the accessors up to here hold 24000000039 bytes, zeros; at most 536870912"},

      {"NoSuchAccessor", [](auto& g) { g.primitive()["attributes"]["POSITION"] = 7; },
       "/meshes/0/primitives/0/attributes/POSITION: 7; the file has 2 accessors"},
      {"PositionOfBytes", [](auto& g) { g.primitive()["attributes"]["POSITION"] = 1; },
       "/meshes/0/primitives/0/attributes/POSITION: /accessors/1 is SCALAR; must be VEC3"},
      {"CountsDiffer",
       [](auto& g) { g.primitive()["attributes"]["TEXCOORD_0"] = g.Accessor(std::vector<float>(8), "VEC2", 5126); },
       "/meshes/0/primitives/0/attributes/TEXCOORD_0: /accessors/2 has a count of 4; POSITION has 3"},
      {"TexcoordOfIntegers",
       [](auto& g) { g.primitive()["attributes"]["TEXCOORD_0"] = g.Accessor(std::vector<uint16_t>(6), "VEC2", 5123); },
       "/meshes/0/primitives/0/attributes/TEXCOORD_0: /accessors/2 has componentType 5123; must be float or a normal"},
      {"NormalOfBytes",
       [](auto& g) { g.primitive()["attributes"]["NORMAL"] = g.Accessor(std::vector<uint8_t>(9), "VEC3", 5121, true); },
       "/meshes/0/primitives/0/attributes/NORMAL: /accessors/2 has componentType 5121; must be float"},
      {"AttributeNameEscaped", [](auto& g) { g.primitive()["attributes"]["_a/b~\n"] = 9; },
       "/meshes/0/primitives/0/attributes/_a~1b~0?: 9; the file has 2"},
      {"IndicesOfFloats", [](auto& g) { g.primitive()["indices"] = g.Accessor(std::vector<float>(3), "SCALAR", 5126); },
       "/meshes/0/primitives/0/indices: /accessors/2 must be SCALAR of unsigned"},
      {"IndexPastVertices",
       [](auto& g) {
         g.primitive()["indices"] = g.template Accessor<uint16_t>({0, 1, 3}, "SCALAR", 5123);
       },
       "/meshes/0/primitives/0/indices: element 2 is 3 (/accessors/2); there are 3 vertices"},
      {"Mode7", [](auto& g) { g.primitive()["mode"] = 7; }, "/meshes/0/primitives/0/mode: 7; must be 0 to 6"},
      {"NoPrimitives", [](auto& g) { g.json["meshes"][0]["primitives"] = nlohmann::json::array(); },
       "/meshes/0/primitives: must not be empty"},
      {"NoSuchMaterial", [](auto& g) { g.primitive()["material"] = 0; },
       "/meshes/0/primitives/0/material: 0; the file has 0 materials"},
      {"NoSuchTarget",
       [](auto& g) {
         g.primitive()["targets"] = {{{"POSITION", 8}}};
       },
       "/meshes/0/primitives/0/targets/0/POSITION: 8; the file has 2"},
      {"PositionNan",
       [](auto& g) {
         const float nan = std::numeric_limits<float>::quiet_NaN();
         std::memcpy(g.bytes.data() + 12, &nan, 4);
       },
       "/meshes/0/primitives/0/attributes/POSITION: element 1 is not finite (/accessors/0)"},
      {"PositionHuge",
       [](auto& g) {
         const float huge = 2e18f;
         std::memcpy(g.bytes.data() + 12, &huge, 4);
       },
       "/meshes/0/primitives/0/attributes/POSITION: element 1 is over 1e18 m away (/accessors/0)"},
      {"UnusedInfinity",
       [](auto& g) {
         g.template Accessor<float>({1, std::numeric_limits<float>::infinity()}, "VEC2", 5126);
       },
       "/accessors/2: element 0 is not finite"},

      {"BaseColor",
       [](auto& g) {
         g.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 2}}}}}};
       },
       "/materials/0/pbrMetallicRoughness/baseColorFactor/3: 2; must be 0.0 to 1.0"},
      {"NoSuchTexture",
       [](auto& g) {
         g.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}}};
       },
       "/materials/0/pbrMetallicRoughness/baseColorTexture/index: 1; the file has 0 textures"},
      {"NoSuchNormalTexture",
       [](auto& g) {
         g.json["materials"] = {{{"normalTexture", {{"index", 0}}}}};
       },
       "/materials/0/normalTexture/index: 0; the file has 0 textures"},
      {"OcclusionStrength",
       [](auto& g) {
         g.json["textures"] = {{{"name", "no source"}}};
         g.json["materials"] = {{{"occlusionTexture", {{"index", 0}, {"strength", 1.5}}}}};
       },
       "/materials/0/occlusionTexture/strength: 1.5; must be 0.0 to 1.0"},
      {"NormalScale",
       [](auto& g) {
         g.json["textures"] = {{{"name", "no source"}}};
         g.json["materials"] = {{{"normalTexture", {{"index", 0}, {"scale", 2e6}}}}};
       },
       "/materials/0/normalTexture/scale: 2000000.0; must be -1000000.0 to 1000000.0"},
      {"ColourOfTwo",
       [](auto& g) {
         g.primitive()["attributes"]["COLOR_0"] = g.template Accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2", 5126);
       },
       "/meshes/0/primitives/0/attributes/COLOR_0: /accessors/2 is VEC2; must be VEC3"},
      {"TangentOfThree",
       [](auto& g) {
         g.primitive()["attributes"]["TANGENT"] = g.template Accessor<float>({1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 5126);
       },
       "/meshes/0/primitives/0/attributes/TANGENT: /accessors/2 is VEC3; must be VEC4"},
      {"AlphaMode",
       [](auto& g) {
         g.json["materials"] = {{{"alphaMode", "GLASS"}}};
       },
       "/materials/0/alphaMode: \"GLASS\"; must be"},
      {"NoSuchImage",
       [](auto& g) {
         g.json["textures"] = {{{"source", 0}}};
       },
       "/textures/0/source: 0; the file has 0"},
      {"NoSuchSampler",
       [](auto& g) {
         g.json["textures"] = {{{"sampler", 2}}};
       },
       "/textures/0/sampler: 2; the file has"},
      {"SamplerWrap",
       [](auto& g) {
         g.json["samplers"] = {{{"wrapS", 1}}};
       },
       "/samplers/0/wrapS: 1; no such mode"},
      {"ImageOfNothing",
       [](auto& g) {
         g.json["images"] = {{{"name", "x"}}};
       },
       "/images/0: must have a uri or"},
      {"ImageView",
       [](auto& g) {
         g.json["images"] = {{{"bufferView", 5}}};
       },
       "/images/0/bufferView: 5; the file has"},

      {"NoSuchMesh", [](auto& g) { g.json["nodes"][0]["mesh"] = 1; }, "/nodes/0/mesh: 1; the file has 1 meshes"},
      {"NoSuchCamera", [](auto& g) { g.json["nodes"][0]["camera"] = 0; }, "/nodes/0/camera: 0; the file has 0"},
      {"NoSuchNode", [](auto& g) { g.json["scenes"][0]["nodes"] = {3}; }, "/scenes/0/nodes/0: 3; the file has 1"},
      {"RootTwice",
       [](auto& g) {
         g.json["scenes"][0]["nodes"] = {0, 0};
       },
       "/scenes/0/nodes/1: 0 stands here twice"},
      {"NoRoot",
       [](auto& g) {
         g.json["nodes"].push_back({{"children", {0}}});
       },
       "/scenes/0/nodes/0: 0 is not a root node"},
      {"Cycle", [](auto& g) { g.json["nodes"][0]["children"] = {0}; }, "/nodes/0: a cycle"},
      {"LongCycle",
       [](auto& g) {
         for (int i = 1; i < 4; ++i) g.json["nodes"].push_back({{"children", {1 + i % 3}}});
       },
       "/nodes/1: a cycle"},
      {"TwoParents",
       [](auto& g) {
         for (int i = 0; i < 2; ++i) g.json["nodes"].push_back({{"children", {3}}});
         g.json["nodes"].push_back({{"name", "child"}});
       },
       "/nodes/2/children/0: a second parent: the node is a child of /nodes/1 too"},
      {"SceneIndex", [](auto& g) { g.json["scene"] = 1; }, "/scene: 1; the file has 1 scenes"},
      {"TranslationText",
       [](auto& g) {
         g.json["nodes"][0]["translation"] = {0, 0, "5"};
       },
       "/nodes/0/translation/2: must be a number"},
      {"RotationOfThree",
       [](auto& g) {
         g.json["nodes"][0]["rotation"] = {0, 0, 1};
       },
       "/nodes/0/rotation: must be 4"},
      {"MatrixAndTranslation",
       [](auto& g) {
         g.json["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
         g.json["nodes"][0]["translation"] = {0, 0, 5};
       },
       "/nodes/0/matrix: stands beside"},
      {"FarAway",
       [](auto& g) {
         g.json["nodes"][0]["scale"] = {2e18, 1, 1};
       },
       "/nodes/0: its mesh reaches over 1e18"},
      {"ChainOverflows",
       [](auto& g) {
         g.json["nodes"] = nlohmann::json::array();
         for (int i = 0; i < 5; ++i) g.json["nodes"].push_back({{"scale", {1e90, 1, 1}}, {"children", {i + 1}}});
         g.json["nodes"].push_back({{"mesh", 0}});
       },
       "/nodes/3: its world matrix is not finite"},
      {"CameraFovy",
       [](auto& g) {
         g.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0}, {"znear", 1}}}}};
       },
       "/cameras/0/perspective/yfov: must be positive"},
      {"CameraFar",
       [](auto& g) {
         g.json["cameras"] = {
             {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 2}, {"zfar", 1}}}}};
       },
       "/cameras/0/orthographic/zfar: 1; must be over znear"},

      {"NoSuchJoint",
       [](auto& g) {
         g.json["skins"] = {{{"joints", {4}}}};
       },
       "/skins/0/joints/0: 4; the file has 1"},
      {"SkeletonBeside",
       [](auto& g) {
         g.json["nodes"].push_back({{"name", "other"}});
         g.json["skins"] = {{{"joints", {0}}, {"skeleton", 1}}};
       },
       "/skins/0/skeleton: 1 is no ancestor of joint 0"},
      {"InverseBindMatrices",
       [](auto& g) {
         g.json["skins"] = {{{"joints", {0}}, {"inverseBindMatrices", 0}}};
       },
       "/skins/0/inverseBindMatrices: /accessors/0 must be MAT4"},
      {"JointPastSkin",
       [](auto& g) {
         g.json["skins"] = {{{"joints", {0}}}};
         g.json["nodes"][0]["skin"] = 0;
         g.primitive()["attributes"]["JOINTS_0"] = g.Accessor(std::vector<uint8_t>(12, 1), "VEC4", 5121);
       },
       "/meshes/0/primitives/0/attributes/JOINTS_0 (/accessors/2): joint 1; the skin has 1"},
      {"AnimationSampler",
       [](auto& g) {
         g.json["animations"] = {
             {{"samplers", nlohmann::json::array()}, {"channels", {{{"sampler", 0}, {"target", {{"node", 0}}}}}}}};
       },
       "/animations/0/channels/0/sampler: 0; the animation has 0"},
      {"AnimationTimesType",
       [](auto& g) {
         g.json["animations"] = {{{"samplers", {{{"input", 0}, {"output", 0}}}},
                                  {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
       },
       "/animations/0/samplers/0/input: /accessors/0 must be SCALAR of floats"},
      {"AnimationInterpolation",
       [](auto& g) {
         const size_t times = g.Accessor(std::vector<float>{0}, "SCALAR", 5126);
         g.json["animations"] = {{{"samplers", {{{"input", times}, {"output", 0}, {"interpolation", "BEZIER"}}}},
                                  {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
       },
       "/animations/0/samplers/0/interpolation: \"BEZIER\"; must be STEP"},
      {"JointsEmpty",
       [](auto& g) {
         g.json["skins"] = {{{"joints", nlohmann::json::array()}}};
       },
       "/skins/0/joints: must not be empty"},
      {"TargetType",
       [](auto& g) {
         g.primitive()["targets"] = {{{"NORMAL", g.Accessor(std::vector<float>(6), "VEC2", 5126)}}};
       },
       "/meshes/0/primitives/0/targets/0/NORMAL: /accessors/2 is VEC2; must be VEC3"},
      {"QuantizedWithoutItsExtension",
       [](auto& g) {
         g.primitive()["attributes"]["NORMAL"] = g.Accessor(std::vector<int8_t>(12, 1), "VEC3", 5120, true);
         g.json["accessors"][2]["count"] = 3;
       },
       "/meshes/0/primitives/0/attributes/NORMAL: /accessors/2 has componentType 5120"},
      {"InstancesOfDifferentCounts",
       [](auto& g) {
         const size_t two = g.Accessor(std::vector<float>(6), "VEC3", 5126);
         g.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 0},
                                                                                      {"SCALE", two}};
       },
       "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/TRANSLATION: /accessors/0 has a count of 3"},
      {"LightPastTheLights",
       [](auto& g) {
         g.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
         g.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1;
       },
       "/nodes/0/extensions/KHR_lights_punctual/light: 1; /extensions/KHR_lights_punctual/lights has 1"},
      {"TransformNotANumber",
       [](auto& g) {
         g.json["textures"] = {nlohmann::json::object()};
         g.json["materials"] = {{{"emissiveTexture", {{"index", 0}}}}};
         g.json["materials"][0]["emissiveTexture"]["extensions"]["KHR_texture_transform"]["rotation"] = "a";
       },
       "/materials/0/emissiveTexture/extensions/KHR_texture_transform/rotation: must be a number"},
      {"EmissiveStrengthBelow",
       [](auto& g) {
         g.json["materials"] = {nlohmann::json::object()};
         g.json["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = -1;
       },
       "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength: -1; must be 0"},
      {"MeshoptMode",
       [](auto& g) {
         g.json["extensionsUsed"] = {"EXT_meshopt_compression"};
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 8}, {"byteStride", 12}, {"count", 3}, {"mode", "POINTS"}};
       },
       "/bufferViews/0/extensions/EXT_meshopt_compression/mode: \"POINTS\"; must be"},
      {"MeshoptCount",
       [](auto& g) {
         g.json["extensionsUsed"] = {"EXT_meshopt_compression"};
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 8}, {"byteStride", 12}, {"count", 4}, {"mode", "ATTRIBUTES"}};
       },
       "/bufferViews/0/extensions/EXT_meshopt_compression/count: 4 elements of 12 bytes; the view has 36"},
      {"MeshoptBytes",
       [](auto& g) {
         g.json["extensionsUsed"] = {"EXT_meshopt_compression"};
         g.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
             {"buffer", 0}, {"byteLength", 8}, {"byteStride", 12}, {"count", 3}, {"mode", "ATTRIBUTES"}};
       },
       "/bufferViews/0/extensions/EXT_meshopt_compression: its bytes do not decode as ATTRIBUTES"},
      {"DracoBytes",
       [](auto& g) {
         g.json["extensionsUsed"] = {"KHR_draco_mesh_compression"};
         g.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                      {"attributes", {{"POSITION", 0}}}};
       },
       "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression: does not decode"},
  };
}

class FaultTest : public testing::TestWithParam<Fault> {};
INSTANTIATE_TEST_SUITE_P(Gltf, FaultTest, testing::ValuesIn(Faults()),
                         [](const auto& test) { return test.param.name; });

TEST_P(FaultTest, IsRefusedWithItsPointer) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  ASSERT_OK(gltf.Load()) << "before the fault is planted";
  GetParam().plant(gltf);
  const auto scene = gltf.Load();
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << scene.status();
  EXPECT_TRUE(std::string(scene.status().message()).starts_with(GetParam().message)) << scene.status();
}

class SparseFaultTest : public testing::TestWithParam<Fault> {};
INSTANTIATE_TEST_SUITE_P(
    Gltf, SparseFaultTest,
    testing::ValuesIn(std::vector<Fault>{
        {"CountOverAccessor", [](auto& g) { g.json["accessors"][0]["sparse"]["count"] = 4; },
         "/accessors/0/sparse/count: 4; must be 1 to 3"},
        {"ValuesPastView", [](auto& g) { g.json["accessors"][0]["sparse"]["values"]["byteOffset"] = 4; },
         "/accessors/0/sparse/count: 1 elements pass the end of /bufferViews/3"},
        {"OffsetHuge",
         [](auto& g) { g.json["accessors"][0]["sparse"]["values"]["byteOffset"] = 18446744073709551612ull; },
         "/accessors/0/sparse/values/byteOffset: "},
        {"IndexType", [](auto& g) { g.json["accessors"][0]["sparse"]["indices"]["componentType"] = 5122; },
         "/accessors/0/sparse/indices/componentType: must be an unsigned"},
        {"IndexView", [](auto& g) { g.json["accessors"][0]["sparse"]["indices"]["bufferView"] = 9; },
         "/accessors/0/sparse/indices/bufferView: 9; the file has"},
        {"IndexPastCount", [](auto& g) { g.bytes[40] = 3; },
         "/accessors/0/sparse/indices: element 0 is 3; the accessor has 3"}}),
    [](const auto& test) { return test.param.name; });

TEST_P(SparseFaultTest, IsRefusedWithItsPointer) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  const size_t indices = gltf.View<uint8_t>({1});
  const size_t values = gltf.View<float>({2, 0, 0});
  gltf.json["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", values}}}};
  ASSERT_OK(gltf.Load()) << "before the fault is planted";
  GetParam().plant(gltf);
  EXPECT_EQ(gltf.Load().status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(std::string(gltf.Load().status().message()).starts_with(GetParam().message)) << gltf.Load().status();
}

TEST(UriTest, NothingOutsideTheFileMapIsEverOpened) {
  for (const char* uri : {"/etc/passwd", "../../etc/passwd", "file:///etc/passwd", "http://127.0.0.1/x", ".", "..", "",
                          "a b.bin/../../../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "a%20b.bin%00"}) {
    GltfBuilder gltf = GltfBuilder::Triangle();
    gltf.json["buffers"] = {{{"byteLength", 1}, {"uri", uri}}};
    gltf.json["bufferViews"].clear();
    gltf.json["accessors"].clear();
    gltf.json.erase("meshes");
    gltf.json["nodes"] = {{{"name", "empty"}}};
    EXPECT_THAT(gltf.Load(), StatusIs(absl::StatusCode::kInvalidArgument,
                                      HasSubstr("is not among the files uploaded with the scene")))
        << uri;
    gltf.json.erase("buffers");
    gltf.json.erase("bufferViews");
    gltf.json.erase("accessors");
    gltf.json["images"] = {{{"uri", uri}}};
    EXPECT_THAT(gltf.Load(), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/images/0/uri: "))) << uri;
  }
}

TEST(JsonTest, WhatDoesNotParseSaysWhere) {
  for (const char* text : {"", "{", "null", "[]", "\"x\"", "{\"asset\":{\"version\":\"2.0\"}} x", "\xef\xbb\xbf{}",
                           "{\"asset\":\"\xff\"}", "{\"a\":1e999}", "nonsense"}) {
    EXPECT_THAT(LoadGltf(text, {}, {}), StatusIs(absl::StatusCode::kInvalidArgument, testing::StartsWith("JSON: ")))
        << text;
  }
}

TEST(LimitsTest, JsonDepthHoldsOnBothSides) {
  SceneLoadLimits limits;
  limits.max_json_depth = 6;
  EXPECT_OK(GltfBuilder::Triangle().Load(limits));
  limits.max_json_depth = 4;
  EXPECT_THAT(GltfBuilder::Triangle().Load(limits),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("nested deeper than 4")));
  EXPECT_EQ(LoadGltf(std::string(1 << 20, '['), {}, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(LimitsTest, JsonBytesTrianglesAndSceneBytesHoldOnBothSides) {
  const GltfBuilder gltf = GltfBuilder::Triangle();
  SceneLoadLimits limits;
  limits.max_json_bytes = gltf.Text().size();
  EXPECT_OK(gltf.Load(limits));
  limits.max_json_bytes -= 1;
  EXPECT_THAT(gltf.Load(limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("JSON: ")));
  limits = {};
  limits.max_triangles = 1;
  EXPECT_OK(gltf.Load(limits));
  limits.max_triangles = 0;
  EXPECT_THAT(gltf.Load(limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("over 0 triangles")));
  limits = {};
  limits.max_scene_bytes = gltf.Text().size() + gltf.bytes.size() - 1;
  EXPECT_THAT(gltf.Load(limits), StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("bytes with all files")));
}

TEST(LimitsTest, InstancesOfInstancesAreBounded) {
  GltfBuilder gltf = GltfBuilder::Triangle();
  for (int i = 1; i < 11; ++i) gltf.json["nodes"].push_back({{"mesh", 0}});
  SceneLoadLimits limits;
  limits.max_triangles = 2;
  EXPECT_THAT(gltf.Load(limits), StatusIs(absl::StatusCode::kInvalidArgument,
                                          HasSubstr("the instances have over 10 triangles, the limit")));
  limits.max_triangles = 3;
  EXPECT_OK(gltf.Load(limits));
}

TEST(LimitsTest, ElementsThatCostMoreThanTheirJsonAreBounded) {
  std::string text = R"({"asset":{"version":"2.0"},"nodes":[{})";
  for (int i = 0; i < 1 << 20; ++i) text += ",{}";
  EXPECT_THAT(LoadGltf(text + "]}", {}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("/nodes: the file has over 1048576 elements")));
  for (int i = 0; i < 3 << 20; ++i) text += ",{}";
  EXPECT_THAT(LoadGltf(text + "]}", {}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, HasSubstr("JSON: over 4194304 objects and arrays")));
}

}  // namespace
}  // namespace halfshade
