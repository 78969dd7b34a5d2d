#include "renderer/scene_loader/validate_gltf.h"

#include <cmath>
#include <limits>
#include <set>

#include "renderer/status.h"

namespace halfshade {
namespace {

using Json = nlohmann::json;

constexpr const char* kTopLevelArrays[] = {"accessors", "animations", "buffers",  "bufferViews", "cameras",
                                           "images",    "materials",  "meshes",   "nodes",       "samplers",
                                           "scenes",    "skins",      "textures", "extensionsUsed", "extensionsRequired"};

absl::Status Fault(const std::string& pointer, const std::string& fault) {
  return absl::InvalidArgumentError(pointer + ": " + fault);
}

// Untrusted text in a message: short, and on one line.
std::string Quoted(const std::string& text) { return Json(text.substr(0, 80)).dump(-1, ' ', true, Json::error_handler_t::replace); }

class Validator {
 public:
  Validator(const GltfContainer& container, const FileMap& files, const SceneLoadLimits& limits)
      : container_(container), files_(files), limits_(limits) {}

  absl::StatusOr<ValidGltf> Run() {
    json_ = Json::parse(container_.json, nullptr, /*allow_exceptions=*/false);
    if (json_.is_discarded()) return absl::InvalidArgumentError("JSON: not well-formed");
    if (!json_.is_object()) return Fault("/", "must be an object");
    if (!container_.warning.empty()) Warn(container_.warning);
    RETURN_IF_ERROR(CheckAsset());
    RETURN_IF_ERROR(CheckTopLevel());
    RETURN_IF_ERROR(CheckExtensions());
    RETURN_IF_ERROR(CheckBuffers());
    RETURN_IF_ERROR(Each("bufferViews", [this](const Json& v, const std::string& p) { return CheckBufferView(v, p); }));
    RETURN_IF_ERROR(Each("accessors", [this](const Json& v, const std::string& p) { return CheckAccessor(v, p); }));
    RETURN_IF_ERROR(CheckImages());
    RETURN_IF_ERROR(Each("samplers", [this](const Json& v, const std::string& p) { return CheckSampler(v, p); }));
    RETURN_IF_ERROR(Each("textures", [this](const Json& v, const std::string& p) { return CheckTexture(v, p); }));
    RETURN_IF_ERROR(Each("materials", [this](const Json& v, const std::string& p) { return CheckMaterial(v, p); }));
    RETURN_IF_ERROR(Each("meshes", [this](const Json& v, const std::string& p) { return CheckMesh(v, p); }));
    RETURN_IF_ERROR(Each("cameras", [this](const Json& v, const std::string& p) { return CheckCamera(v, p); }));
    RETURN_IF_ERROR(Each("nodes", [this](const Json& v, const std::string& p) { return CheckNode(v, p); }));
    RETURN_IF_ERROR(CheckForest());
    RETURN_IF_ERROR(Each("scenes", [this](const Json& v, const std::string& p) { return CheckScene(v, p); }));
    RETURN_IF_ERROR(Each("skins", [this](const Json& v, const std::string& p) { return CheckSkin(v, p); }));
    RETURN_IF_ERROR(Each("animations", [this](const Json& v, const std::string& p) { return CheckAnimation(v, p); }));
    if (json_.contains("scene")) RETURN_IF_ERROR(CheckIndex(json_, "", "scene", "scenes", true));
    return ValidGltf{std::move(json_), std::move(buffers_), std::move(images_), std::move(warnings_)};
  }

 private:
  void Warn(const std::string& warning) { warnings_.push_back(warning); }

  size_t Count(const char* array) const { return json_.contains(array) ? json_[array].size() : 0; }

  template <typename Check>
  absl::Status Each(const char* array, Check check) {
    for (size_t i = 0; i < Count(array); ++i) {
      RETURN_IF_ERROR(check(json_[array][i], std::string("/") + array + "/" + std::to_string(i)));
    }
    return absl::OkStatus();
  }

  // A whole number in [low, high].
  absl::StatusOr<int64_t> Integer(const Json& object, const std::string& pointer, const char* key, int64_t low,
                                  int64_t high) {
    const std::string at = pointer + "/" + key;
    const auto found = object.find(key);
    if (found == object.end()) return Fault(at, "missing");
    if (!found->is_number_integer()) return Fault(at, "must be an integer");
    if (found->is_number_unsigned() && found->get<uint64_t>() > uint64_t(std::numeric_limits<int64_t>::max())) {
      return Fault(at, found->dump() + "; must be " + std::to_string(low) + " to " + std::to_string(high));
    }
    const int64_t value = found->get<int64_t>();
    if (value < low || value > high) {
      return Fault(at, std::to_string(value) + "; must be " + std::to_string(low) + " to " + std::to_string(high));
    }
    return value;
  }

  absl::StatusOr<int64_t> IntegerOr(const Json& object, const std::string& pointer, const char* key, int64_t low,
                                    int64_t high, int64_t absent) {
    if (!object.contains(key)) return absent;
    return Integer(object, pointer, key, low, high);
  }

  absl::Status CheckIndex(const Json& object, const std::string& pointer, const char* key, const char* array,
                          bool is_required) {
    if (!object.contains(key)) return is_required ? Fault(pointer + "/" + key, "missing") : absl::OkStatus();
    const std::string at = pointer + "/" + key;
    const Json& value = object[key];
    if (!value.is_number_integer() || value < 0) return Fault(at, "must be an index");
    if (value >= Count(array)) {
      return Fault(at, value.dump() + "; the file has " + std::to_string(Count(array)) + " " + array);
    }
    return absl::OkStatus();
  }

  absl::Status CheckIndexList(const Json& object, const std::string& pointer, const char* key, const char* array) {
    if (!object.contains(key)) return absl::OkStatus();
    const Json& list = object[key];
    if (!list.is_array()) return Fault(pointer + "/" + key, "must be an array");
    std::set<uint64_t> seen;
    for (size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer + "/" + key + "/" + std::to_string(i);
      if (!list[i].is_number_integer() || list[i] < 0) return Fault(at, "must be an index");
      if (list[i] >= Count(array)) {
        return Fault(at, list[i].dump() + "; the file has " + std::to_string(Count(array)) + " " + array);
      }
      if (!seen.insert(list[i].get<uint64_t>()).second) return Fault(at, list[i].dump() + " stands here twice");
    }
    return absl::OkStatus();
  }

  absl::Status CheckNumbers(const Json& object, const std::string& pointer, const char* key, size_t count, double low,
                            double high) {
    if (!object.contains(key)) return absl::OkStatus();
    const std::string at = pointer + "/" + key;
    const Json& list = object[key];
    if (!list.is_array() || list.size() != count) return Fault(at, "must be " + std::to_string(count) + " numbers");
    for (size_t i = 0; i < count; ++i) {
      const std::string element = at + "/" + std::to_string(i);
      if (!list[i].is_number()) return Fault(element, "must be a number");
      const double value = list[i].get<double>();
      if (!std::isfinite(value) || value < low || value > high) return Fault(element, list[i].dump() + " is out of range");
    }
    return absl::OkStatus();
  }

  absl::StatusOr<double> Number(const Json& object, const std::string& pointer, const char* key) {
    const std::string at = pointer + "/" + key;
    if (!object.contains(key)) return Fault(at, "missing");
    if (!object[key].is_number() || !std::isfinite(object[key].get<double>())) return Fault(at, "must be a finite number");
    return object[key].get<double>();
  }

  absl::Status CheckAsset() {
    if (!json_.contains("asset")) return Fault("/asset", "missing");
    const Json& asset = json_["asset"];
    if (!asset.is_object()) return Fault("/asset", "must be an object");
    for (const char* key : {"version", "minVersion"}) {
      const std::string at = std::string("/asset/") + key;
      if (!asset.contains(key)) {
        if (key == std::string("version")) return Fault(at, "missing");
        continue;
      }
      if (!asset[key].is_string()) return Fault(at, "must be a string");
      const std::string version = asset[key].get<std::string>();
      if (!version.starts_with("2.") || version.size() < 3) return Fault(at, Quoted(version) + "; only 2.0 is supported");
      if (key == std::string("minVersion") && version != "2.0") return Fault(at, Quoted(version) + "; only 2.0 is supported");
    }
    return absl::OkStatus();
  }

  absl::Status CheckTopLevel() {
    for (const char* name : kTopLevelArrays) {
      if (!json_.contains(name)) continue;
      const std::string at = std::string("/") + name;
      if (!json_[name].is_array()) return Fault(at, "must be an array");
      const bool holds_text = std::string(name).starts_with("extensions");
      for (size_t i = 0; i < json_[name].size(); ++i) {
        const Json& element = json_[name][i];
        if (holds_text ? !element.is_string() : !element.is_object()) {
          return Fault(at + "/" + std::to_string(i), holds_text ? "must be a string" : "must be an object");
        }
        if (!holds_text && element.contains("name") && !element["name"].is_string()) {
          return Fault(at + "/" + std::to_string(i) + "/name", "must be a string");
        }
      }
    }
    return absl::OkStatus();
  }

  // Nothing beyond core glTF is implemented: what a scene cannot do without is refused by name.
  absl::Status CheckExtensions() {
    if (!json_.contains("extensionsRequired")) return absl::OkStatus();
    const Json& required = json_["extensionsRequired"];
    if (required.empty()) return absl::OkStatus();
    return Fault("/extensionsRequired/0", Quoted(required[0].get<std::string>()) + " is not supported");
  }

  absl::StatusOr<std::string> Resolve(const Json& uri_json, const std::string& at) {
    if (!uri_json.is_string()) return Fault(at, "must be a string");
    const std::string uri = uri_json.get<std::string>();
    std::string bytes;
    if (uri.starts_with("data:")) {
      if (!DecodeDataUri(uri, &bytes)) return Fault(at, "a malformed data URI");
      return bytes;
    }
    std::string path;
    if (!PercentDecode(uri, &path)) return Fault(at, Quoted(uri) + ": a malformed percent escape");
    const auto file = files_.find(path);
    if (file == files_.end()) return Fault(at, Quoted(uri) + " is not among the files uploaded with the scene");
    return *file->second;
  }

  absl::Status CheckBuffers() {
    uint64_t total = 0;
    for (size_t i = 0; i < Count("buffers"); ++i) {
      const Json& buffer = json_["buffers"][i];
      const std::string pointer = "/buffers/" + std::to_string(i);
      ASSIGN_OR_RETURN(const int64_t length, Integer(buffer, pointer, "byteLength", 1, int64_t(1) << 40));
      std::string bytes;
      if (buffer.contains("uri")) {
        ASSIGN_OR_RETURN(bytes, Resolve(buffer["uri"], pointer + "/uri"));
      } else if (i == 0 && container_.bin != nullptr) {
        bytes.assign(container_.bin, container_.bin_size);
      } else {
        return Fault(pointer, "has no uri, and the file has no BIN chunk for it");
      }
      if (bytes.size() < uint64_t(length)) {
        return Fault(pointer + "/byteLength",
                     std::to_string(length) + "; there are " + std::to_string(bytes.size()) + " bytes");
      }
      total += bytes.size();
      if (total > limits_.max_scene_bytes) {
        return Fault(pointer, "the scene's buffers pass the limit of " + std::to_string(limits_.max_scene_bytes) + " bytes");
      }
      buffers_.push_back(std::move(bytes));
    }
    return absl::OkStatus();
  }

  absl::Status CheckBufferView(const Json& view, const std::string& pointer) {
    RETURN_IF_ERROR(CheckIndex(view, pointer, "buffer", "buffers", true));
    const int64_t buffer_length = json_["buffers"][view["buffer"].get<size_t>()]["byteLength"].get<int64_t>();
    ASSIGN_OR_RETURN(const int64_t length, Integer(view, pointer, "byteLength", 1, buffer_length));
    ASSIGN_OR_RETURN(const int64_t offset, IntegerOr(view, pointer, "byteOffset", 0, buffer_length, 0));
    if (offset > buffer_length - length) {
      return Fault(pointer + "/byteLength", std::to_string(length) + " from byteOffset " + std::to_string(offset) +
                                                "; the buffer has " + std::to_string(buffer_length));
    }
    ASSIGN_OR_RETURN(const int64_t stride, IntegerOr(view, pointer, "byteStride", 4, 252, 4));
    if (stride % 4 != 0) return Fault(pointer + "/byteStride", std::to_string(stride) + "; must be a multiple of 4");
    return absl::OkStatus();
  }

  absl::Status CheckAccessor(const Json& accessor, const std::string& pointer) {
    ASSIGN_OR_RETURN(const int64_t component, Integer(accessor, pointer, "componentType", 5120, 5126));
    if (ComponentBytes(component) == 0) return Fault(pointer + "/componentType", std::to_string(component) + "; no such type");
    if (!accessor.contains("type") || !accessor["type"].is_string()) return Fault(pointer + "/type", "missing, or no string");
    const std::string type = accessor["type"].get<std::string>();
    if (TypeComponents(type) == 0) return Fault(pointer + "/type", Quoted(type) + "; no such type");
    ASSIGN_OR_RETURN(const int64_t count, Integer(accessor, pointer, "count", 1, int64_t(1) << 32));
    if (accessor.contains("normalized") && !accessor["normalized"].is_boolean()) {
      return Fault(pointer + "/normalized", "must be true or false");
    }
    if (accessor.contains("sparse")) return Fault(pointer + "/sparse", "sparse accessors are not supported");
    RETURN_IF_ERROR(CheckIndex(accessor, pointer, "bufferView", "bufferViews", false));
    if (!accessor.contains("bufferView")) return Fault(pointer + "/bufferView", "missing; accessors of zeros are not supported");
    const Json& view = json_["bufferViews"][accessor["bufferView"].get<size_t>()];
    const int64_t element = int64_t(ComponentBytes(component)) * TypeComponents(type);
    const int64_t stride = view.contains("byteStride") ? view["byteStride"].get<int64_t>() : element;
    const int64_t view_length = view["byteLength"].get<int64_t>();
    ASSIGN_OR_RETURN(const int64_t offset, IntegerOr(accessor, pointer, "byteOffset", 0, view_length, 0));
    if (stride < element) return Fault(pointer, "its elements of " + std::to_string(element) + " bytes overlap at a stride of " + std::to_string(stride));
    const int64_t start = offset + (view.contains("byteOffset") ? view["byteOffset"].get<int64_t>() : 0);
    if (start % ComponentBytes(component) != 0) return Fault(pointer + "/byteOffset", "not aligned to its component");
    if (count - 1 > (view_length - offset - element) / stride || view_length - offset < element) {
      return Fault(pointer + "/count", std::to_string(count) + " elements pass the end of the buffer view of " +
                                           std::to_string(view_length) + " bytes");
    }
    return absl::OkStatus();
  }

  absl::Status CheckImages() {
    for (size_t i = 0; i < Count("images"); ++i) {
      const Json& image = json_["images"][i];
      const std::string pointer = "/images/" + std::to_string(i);
      if (image.contains("uri") == image.contains("bufferView")) {
        return Fault(pointer, "must have a uri or a bufferView, and not both");
      }
      if (image.contains("uri")) {
        ASSIGN_OR_RETURN(std::string bytes, Resolve(image["uri"], pointer + "/uri"));
        images_.push_back(std::move(bytes));
        continue;
      }
      RETURN_IF_ERROR(CheckIndex(image, pointer, "bufferView", "bufferViews", true));
      const Json& view = json_["bufferViews"][image["bufferView"].get<size_t>()];
      const size_t offset = view.contains("byteOffset") ? view["byteOffset"].get<size_t>() : 0;
      images_.push_back(buffers_[view["buffer"].get<size_t>()].substr(offset, view["byteLength"].get<size_t>()));
    }
    return absl::OkStatus();
  }

  absl::Status CheckSampler(const Json& sampler, const std::string& pointer) {
    for (const char* key : {"wrapS", "wrapT"}) {
      ASSIGN_OR_RETURN(const int64_t wrap, IntegerOr(sampler, pointer, key, 0, 65535, 10497));
      if (wrap != 10497 && wrap != 33071 && wrap != 33648) return Fault(pointer + "/" + key, std::to_string(wrap) + "; no such mode");
    }
    for (const char* key : {"magFilter", "minFilter"}) {
      ASSIGN_OR_RETURN(const int64_t filter, IntegerOr(sampler, pointer, key, 0, 65535, 9729));
      const bool is_mip = key == std::string("minFilter") && filter >= 9984 && filter <= 9987;
      if (filter != 9728 && filter != 9729 && !is_mip) return Fault(pointer + "/" + key, std::to_string(filter) + "; no such filter");
    }
    return absl::OkStatus();
  }

  absl::Status CheckTexture(const Json& texture, const std::string& pointer) {
    RETURN_IF_ERROR(CheckIndex(texture, pointer, "source", "images", false));
    return CheckIndex(texture, pointer, "sampler", "samplers", false);
  }

  absl::Status CheckTextureInfo(const Json& object, const std::string& pointer, const char* key) {
    if (!object.contains(key)) return absl::OkStatus();
    const std::string at = pointer + "/" + key;
    if (!object[key].is_object()) return Fault(at, "must be an object");
    RETURN_IF_ERROR(CheckIndex(object[key], at, "index", "textures", true));
    ASSIGN_OR_RETURN(const int64_t set, IntegerOr(object[key], at, "texCoord", 0, 1 << 20, 0));
    if (set != 0) Warn(at + "/texCoord: only TEXCOORD_0 is used");
    return absl::OkStatus();
  }

  absl::Status CheckMaterial(const Json& material, const std::string& pointer) {
    if (material.contains("pbrMetallicRoughness")) {
      const Json& pbr = material["pbrMetallicRoughness"];
      const std::string at = pointer + "/pbrMetallicRoughness";
      if (!pbr.is_object()) return Fault(at, "must be an object");
      RETURN_IF_ERROR(CheckNumbers(pbr, at, "baseColorFactor", 4, 0, 1));
      RETURN_IF_ERROR(CheckTextureInfo(pbr, at, "baseColorTexture"));
      RETURN_IF_ERROR(CheckTextureInfo(pbr, at, "metallicRoughnessTexture"));
      for (const char* key : {"metallicFactor", "roughnessFactor"}) {
        if (!pbr.contains(key)) continue;
        ASSIGN_OR_RETURN(const double factor, Number(pbr, at, key));
        if (factor < 0 || factor > 1) return Fault(at + "/" + key, pbr[key].dump() + "; must be 0 to 1");
      }
    }
    for (const char* key : {"normalTexture", "occlusionTexture", "emissiveTexture"}) {
      RETURN_IF_ERROR(CheckTextureInfo(material, pointer, key));
    }
    RETURN_IF_ERROR(CheckNumbers(material, pointer, "emissiveFactor", 3, 0, 1));
    if (material.contains("doubleSided") && !material["doubleSided"].is_boolean()) {
      return Fault(pointer + "/doubleSided", "must be true or false");
    }
    if (material.contains("alphaCutoff")) {
      ASSIGN_OR_RETURN(const double cutoff, Number(material, pointer, "alphaCutoff"));
      if (cutoff < 0) return Fault(pointer + "/alphaCutoff", material["alphaCutoff"].dump() + "; must not be negative");
    }
    if (material.contains("alphaMode")) {
      const Json& mode = material["alphaMode"];
      if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND") return Fault(pointer + "/alphaMode", "must be OPAQUE, MASK or BLEND");
      if (mode != "OPAQUE") Warn(pointer + "/alphaMode: " + mode.get<std::string>() + " is drawn, and occludes, as OPAQUE");
    }
    return absl::OkStatus();
  }

  // The accessor of an attribute: its type, its component, its count (0: any).
  absl::Status CheckAttribute(const Json& attributes, const std::string& pointer, const char* name, const char* type,
                              bool allows_normalized, int64_t* count) {
    RETURN_IF_ERROR(CheckIndex(attributes, pointer, name, "accessors", true));
    const std::string at = pointer + "/" + name;
    const Json& accessor = json_["accessors"][attributes[name].get<size_t>()];
    if (accessor["type"] != type) return Fault(at, "its accessor is " + accessor["type"].get<std::string>() + "; must be " + type);
    const int64_t component = accessor["componentType"].get<int64_t>();
    const bool is_normalized = accessor.value("normalized", false);
    const bool is_unsigned = component == 5121 || component == 5123;
    if (component != 5126 && !(allows_normalized && is_normalized && is_unsigned)) {
      return Fault(at, std::string("its accessor's componentType is ") + std::to_string(component) +
                           (allows_normalized ? "; must be float or a normalized unsigned byte or short" : "; must be float"));
    }
    const int64_t own_count = accessor["count"].get<int64_t>();
    if (*count != 0 && own_count != *count) {
      return Fault(at, std::to_string(own_count) + " elements; POSITION has " + std::to_string(*count));
    }
    *count = own_count;
    return absl::OkStatus();
  }

  absl::Status CheckPrimitive(const Json& primitive, const std::string& pointer) {
    if (!primitive.is_object()) return Fault(pointer, "must be an object");
    if (!primitive.contains("attributes") || !primitive["attributes"].is_object()) {
      return Fault(pointer + "/attributes", "missing, or no object");
    }
    const Json& attributes = primitive["attributes"];
    const std::string at = pointer + "/attributes";
    for (const auto& [name, value] : attributes.items()) {
      RETURN_IF_ERROR(CheckIndex(attributes, at, name.c_str(), "accessors", true));
    }
    RETURN_IF_ERROR(CheckIndex(primitive, pointer, "material", "materials", false));
    ASSIGN_OR_RETURN(const int64_t mode, IntegerOr(primitive, pointer, "mode", 0, 6, 4));
    if (mode < 4) Warn(pointer + "/mode: points and lines are not drawn");
    if (!attributes.contains("POSITION")) {
      Warn(at + ": without POSITION nothing is drawn");
      return absl::OkStatus();
    }
    int64_t count = 0;
    RETURN_IF_ERROR(CheckAttribute(attributes, at, "POSITION", "VEC3", false, &count));
    if (attributes.contains("NORMAL")) RETURN_IF_ERROR(CheckAttribute(attributes, at, "NORMAL", "VEC3", false, &count));
    if (attributes.contains("TEXCOORD_0")) {
      RETURN_IF_ERROR(CheckAttribute(attributes, at, "TEXCOORD_0", "VEC2", true, &count));
    }
    if (primitive.contains("targets")) Warn(pointer + "/targets: morph targets are not applied");
    if (!primitive.contains("indices")) return absl::OkStatus();
    RETURN_IF_ERROR(CheckIndex(primitive, pointer, "indices", "accessors", true));
    const Json& indices = json_["accessors"][primitive["indices"].get<size_t>()];
    const int64_t component = indices["componentType"].get<int64_t>();
    if (indices["type"] != "SCALAR" || (component != 5121 && component != 5123 && component != 5125)) {
      return Fault(pointer + "/indices", "its accessor must be SCALAR of unsigned integers");
    }
    return absl::OkStatus();
  }

  absl::Status CheckMesh(const Json& mesh, const std::string& pointer) {
    if (!mesh.contains("primitives") || !mesh["primitives"].is_array() || mesh["primitives"].empty()) {
      return Fault(pointer + "/primitives", "missing, empty, or no array");
    }
    for (size_t i = 0; i < mesh["primitives"].size(); ++i) {
      RETURN_IF_ERROR(CheckPrimitive(mesh["primitives"][i], pointer + "/primitives/" + std::to_string(i)));
    }
    return absl::OkStatus();
  }

  absl::Status CheckCamera(const Json& camera, const std::string& pointer) {
    const bool is_perspective = camera.value("type", Json()) == "perspective";
    if (!is_perspective && camera.value("type", Json()) != "orthographic") {
      return Fault(pointer + "/type", "must be perspective or orthographic");
    }
    const char* kind = is_perspective ? "perspective" : "orthographic";
    const std::string at = pointer + "/" + kind;
    if (!camera.contains(kind) || !camera[kind].is_object()) return Fault(at, "missing, or no object");
    const Json& lens = camera[kind];
    ASSIGN_OR_RETURN(const double near_m, Number(lens, at, "znear"));
    if (near_m < 0 || (is_perspective && near_m == 0)) return Fault(at + "/znear", lens["znear"].dump() + "; must be positive");
    if (lens.contains("zfar") || !is_perspective) {
      ASSIGN_OR_RETURN(const double far_m, Number(lens, at, "zfar"));
      if (far_m <= near_m) return Fault(at + "/zfar", lens["zfar"].dump() + "; must be over znear");
    }
    if (is_perspective) {
      ASSIGN_OR_RETURN(const double fovy, Number(lens, at, "yfov"));
      if (!(fovy > 0)) return Fault(at + "/yfov", lens["yfov"].dump() + "; must be positive");
      if (fovy >= M_PI) Warn(at + "/yfov: over 180 degrees; such a camera cannot be rendered");
    } else {
      for (const char* key : {"xmag", "ymag"}) {
        ASSIGN_OR_RETURN(const double magnification, Number(lens, at, key));
        if (magnification == 0) return Fault(at + "/" + key, "must not be 0");
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckNode(const Json& node, const std::string& pointer) {
    RETURN_IF_ERROR(CheckIndexList(node, pointer, "children", "nodes"));
    RETURN_IF_ERROR(CheckIndex(node, pointer, "mesh", "meshes", false));
    RETURN_IF_ERROR(CheckIndex(node, pointer, "camera", "cameras", false));
    RETURN_IF_ERROR(CheckIndex(node, pointer, "skin", "skins", false));
    if (node.contains("skin")) Warn(pointer + "/skin: skins are not applied");
    // Beyond 1e30 the square of a coordinate leaves float.
    RETURN_IF_ERROR(CheckNumbers(node, pointer, "matrix", 16, -1e30, 1e30));
    RETURN_IF_ERROR(CheckNumbers(node, pointer, "translation", 3, -1e30, 1e30));
    RETURN_IF_ERROR(CheckNumbers(node, pointer, "scale", 3, -1e30, 1e30));
    RETURN_IF_ERROR(CheckNumbers(node, pointer, "rotation", 4, -1 - 1e-3, 1 + 1e-3));
    if (node.contains("matrix") && (node.contains("translation") || node.contains("rotation") || node.contains("scale"))) {
      return Fault(pointer + "/matrix", "stands beside translation, rotation or scale");
    }
    return absl::OkStatus();
  }

  // Every node has one parent at most and no node is its own ancestor.
  absl::Status CheckForest() {
    const size_t count = Count("nodes");
    std::vector<int64_t> parent(count, -1);
    for (size_t i = 0; i < count; ++i) {
      const Json& node = json_["nodes"][i];
      if (!node.contains("children")) continue;
      for (size_t k = 0; k < node["children"].size(); ++k) {
        int64_t& mine = parent[node["children"][k].get<size_t>()];
        const std::string at = "/nodes/" + std::to_string(i) + "/children/" + std::to_string(k);
        if (mine >= 0) return Fault(at, "the node is a child of /nodes/" + std::to_string(mine) + " too");
        mine = int64_t(i);
      }
    }
    std::vector<uint8_t> state(count, 0);  // 1: on this walk, 2: known to end at a root
    for (size_t i = 0; i < count; ++i) {
      std::vector<size_t> walk;
      int64_t at = int64_t(i);
      while (at >= 0 && state[size_t(at)] == 0) {
        state[size_t(at)] = 1;
        walk.push_back(size_t(at));
        at = parent[size_t(at)];
      }
      if (at >= 0 && state[size_t(at)] == 1) return Fault("/nodes/" + std::to_string(at), "is its own ancestor");
      for (const size_t node : walk) state[node] = 2;
    }
    has_parent_.assign(count, false);
    for (size_t i = 0; i < count; ++i) has_parent_[i] = parent[i] >= 0;
    return absl::OkStatus();
  }

  absl::Status CheckScene(const Json& scene, const std::string& pointer) {
    RETURN_IF_ERROR(CheckIndexList(scene, pointer, "nodes", "nodes"));
    if (!scene.contains("nodes")) return absl::OkStatus();
    for (size_t i = 0; i < scene["nodes"].size(); ++i) {
      if (has_parent_[scene["nodes"][i].get<size_t>()]) {
        return Fault(pointer + "/nodes/" + std::to_string(i), scene["nodes"][i].dump() + " is not a root node");
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckSkin(const Json& skin, const std::string& pointer) {
    if (!skin.contains("joints")) return Fault(pointer + "/joints", "missing");
    RETURN_IF_ERROR(CheckIndexList(skin, pointer, "joints", "nodes"));
    RETURN_IF_ERROR(CheckIndex(skin, pointer, "skeleton", "nodes", false));
    return CheckIndex(skin, pointer, "inverseBindMatrices", "accessors", false);
  }

  absl::Status CheckAnimation(const Json& animation, const std::string& pointer) {
    for (const char* key : {"samplers", "channels"}) {
      if (!animation.contains(key) || !animation[key].is_array()) return Fault(pointer + "/" + key, "missing, or no array");
    }
    for (size_t i = 0; i < animation["samplers"].size(); ++i) {
      const std::string at = pointer + "/samplers/" + std::to_string(i);
      if (!animation["samplers"][i].is_object()) return Fault(at, "must be an object");
      RETURN_IF_ERROR(CheckIndex(animation["samplers"][i], at, "input", "accessors", true));
      RETURN_IF_ERROR(CheckIndex(animation["samplers"][i], at, "output", "accessors", true));
    }
    for (size_t i = 0; i < animation["channels"].size(); ++i) {
      const Json& channel = animation["channels"][i];
      const std::string at = pointer + "/channels/" + std::to_string(i);
      if (!channel.is_object()) return Fault(at, "must be an object");
      ASSIGN_OR_RETURN(const int64_t sampler, Integer(channel, at, "sampler", 0, 1 << 30));
      if (uint64_t(sampler) >= animation["samplers"].size()) {
        return Fault(at + "/sampler", std::to_string(sampler) + "; the animation has " +
                                          std::to_string(animation["samplers"].size()));
      }
      if (!channel.contains("target") || !channel["target"].is_object()) return Fault(at + "/target", "missing, or no object");
      RETURN_IF_ERROR(CheckIndex(channel["target"], at + "/target", "node", "nodes", false));
    }
    return absl::OkStatus();
  }

  const GltfContainer& container_;
  const FileMap& files_;
  const SceneLoadLimits& limits_;
  Json json_;
  std::vector<std::string> buffers_, images_, warnings_;
  std::vector<bool> has_parent_;
};

}  // namespace

int ComponentBytes(int64_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

int TypeComponents(const std::string& type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  if (type == "MAT3") return 9;
  if (type == "MAT4") return 16;
  return 0;
}

absl::StatusOr<ValidGltf> ValidateGltf(const GltfContainer& container, const FileMap& files,
                                       const SceneLoadLimits& limits) {
  return Validator(container, files, limits).Run();
}

}  // namespace halfshade
