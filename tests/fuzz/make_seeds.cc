// Writes what the fuzzers start from into FOLDER/<fuzzer>/: one good input at least of each kind. No file is committed
// that can be made.
#include <filesystem>
#include <fstream>

#include "client/glb_writer.h"
#include "halfshade/v1/render.pb.h"
#include "renderer/scene/flat_form.h"
#include "server/digest.h"
#include "server/scene_name.h"
#include "tests/renderer/scene/every_array_scene.h"
#include "tests/renderer/scene_loader/png.h"
#include "tests/support/mesh_parts.h"

namespace {

namespace fs = std::filesystem;
using namespace halfshade;

fs::path folder;

void Write(const char* fuzzer, const char* name, const std::string& bytes) {
  fs::create_directories(folder / fuzzer);
  std::ofstream(folder / fuzzer / name, std::ios::binary) << bytes;
}

void SetVec3(double x, double y, double z, v1::Vec3* out) {
  out->set_x(x);
  out->set_y(y);
  out->set_z(z);
}

v1::RenderRequest MakeRequest() {
  v1::RenderRequest request;
  request.set_scene("scenes/" + std::string(64, 'a'));
  request.set_width(64);
  request.set_height(32);
  v1::AreaLight* light = request.add_lights();
  SetVec3(0, 4, 0, light->mutable_center());
  SetVec3(1, 0, 0, light->mutable_edge_u());
  SetVec3(0, 0, 1, light->mutable_edge_v());
  return request;
}

constexpr char kJson[] =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"skin":0,"weights":[0.5],)"
    R"("translation":[0,1,0]},{"children":[2],"rotation":[0,0,0,1]},{"name":"joint","camera":0}],"cameras":[{"type":)"
    R"("perspective","perspective":{"yfov":1,"znear":0.1}}],"meshes":[{"primitives":[{"attributes":{"POSITION":1,)"
    R"("NORMAL":1,"TEXCOORD_0":2,"WEIGHTS_0":3,"JOINTS_0":4},"indices":0,"material":0,"targets":[{"POSITION":1}]}]}],)"
    R"("materials":[{"alphaMode":"MASK","alphaCutoff":0.5,"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.7]}}],)"
    R"("skins":[{"joints":[2],"inverseBindMatrices":5}],"animations":[{"channels":[{"sampler":0,"target":{"node":2,)"
    R"("path":"translation"}}],"samplers":[{"input":6,"output":1,"interpolation":"LINEAR"}]}],"accessors":[)"
    R"({"bufferView":0,"componentType":5125,"count":3,"type":"SCALAR"},{"bufferView":1,"componentType":5126,"count":8,)"
    R"("type":"VEC3","min":[0,0,0],"max":[1,1,1],"sparse":{"count":1,"indices":{"bufferView":0,"componentType":5125},)"
    R"("values":{"bufferView":1}}},{"bufferView":1,"componentType":5126,"count":8,"type":"VEC2"},{"bufferView":1,)"
    R"("componentType":5126,"count":8,"type":"VEC4"},{"componentType":5121,"count":8,"type":"VEC4"},{"bufferView":1,)"
    R"("componentType":5126,"count":1,"type":"MAT4"},{"bufferView":2,"componentType":5126,"count":2,"type":"SCALAR"}],)"
    R"("bufferViews":[{"buffer":0,"byteLength":64},{"buffer":0,"byteOffset":64,"byteLength":1024},{"buffer":0,)"
    R"("byteOffset":80,"byteLength":8}],"buffers":[{"byteLength":16384}]})";

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  folder = argv[1];
  Write("gltf_json_fuzz", "everything", kJson);
  Write("gltf_json_fuzz", "nothing", R"({"asset":{"version":"2.0"}})");
  GlbMesh mesh;
  AddBox(mesh, {0, 0, 0}, {1, 1, 1});
  Write("gltf_fuzz", "box", WriteGlb({mesh}));
  Write("gltf_fuzz", "nothing", R"({"asset":{"version":"2.0"}})");
  Write("image_fuzz", "png", MakePng(5, 3));
  // What crashed stb_image 2.27: a Huffman table of 4080 codes.
  Write("image_fuzz", "jpeg_table", std::string("\xff\xd8\xff\xc4\x10\x03\x00", 7) + std::string(4096, '\xff'));
  Write("flat_form_fuzz", "everything", FlatSceneBytes(MakeEveryArrayScene()));
  v1::RenderRequest request = MakeRequest();
  Write("request_fuzz", "automatic", request.SerializeAsString());
  request.mutable_method()->mutable_multi_map()->set_k(16);
  Write("request_fuzz", "multi_map", request.SerializeAsString());
  Write(
      "text_fuzz", "view",
      R"({"camera":{"eye":[0,1,4],"target":[0,0,0],"up":[0,1,0],"fovy_deg":40},"light":{"center":[0,4,0],"u":[1,0,0],)"
      R"("v":[0,0,1],"normal":[0,-1,0],"width":1,"height":1},"ground":{"y":0,"size":10,"add":true}})");
  Write("text_fuzz", "batch",
        R"({"id":"a-B_9","scene":"s/x.glb","width":64,"lights":[{"center":{"y":4},"edgeU":{"x":1},"edgeV":{"z":1}}],)"
        R"("outputs":[{"kind":"OUTPUT_KIND_FRAME"},{"kind":"OUTPUT_KIND_VISIBILITY","encoding":"ENCODING_EXR_HALF"}]})"
        "\n\n"
        R"({"id":"a-B_9","scene":"y.glb"})"
        "\n"
        R"({"id":"b","scene":"scenes/)" +
            std::string(64, 'a') + R"(","method":{"multiMap":{"k":16}},"seed":"7"})");
  Write("text_fuzz", "manifest", SceneManifest(Sha256Hex("root"), {{"a.bin", Sha256Hex("a")}}));
  return 0;
}
