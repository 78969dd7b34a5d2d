// EXT_meshopt_compression and KHR_draco_mesh_compression: what is compressed becomes buffers of ours, and the JSON
// points to them, so that nobody after this knows of it.
#include <draco/compression/decode.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <map>

#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr int64_t kUnsignedInt = 5125;

// A view of a buffer of its own over `bytes`; its number.
size_t AddView(std::string bytes, Gltf* gltf) {
  const size_t buffer = gltf->buffers.size();
  gltf->decoded.push_back(std::move(bytes));
  gltf->buffers.push_back(gltf->decoded.back());
  const size_t size = gltf->buffers.back().size();
  gltf->json["buffers"].push_back({{"byteLength", size}});
  gltf->json["bufferViews"].push_back({{"buffer", buffer}, {"byteLength", size}});
  return gltf->json["bufferViews"].size() - 1;
}

// What is decoded is bounded in all, whatever the compressed bytes claim.
class Budget {
 public:
  explicit Budget(uint64_t max_bytes) : max_bytes_(max_bytes) {}
  absl::Status Take(const Place& place, uint64_t bytes) {
    bytes_ += bytes;  // each below 2^41
    if (bytes_ <= max_bytes_) return absl::OkStatus();
    return place.Fault("what is compressed up to here takes " + std::to_string(bytes_) + " bytes; at most " +
                       std::to_string(max_bytes_));
  }

 private:
  const uint64_t max_bytes_;
  uint64_t bytes_ = 0;
};

absl::Status DecodeMeshopt(const std::string& mode, size_t count, size_t stride, std::string_view from,
                           const Place& place, std::string* to) {
  const auto* source = reinterpret_cast<const unsigned char*>(from.data());
  const int error = mode == "ATTRIBUTES"  ? meshopt_decodeVertexBuffer(to->data(), count, stride, source, from.size())
                    : mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(to->data(), count, stride, source, from.size())
                                          : meshopt_decodeIndexSequence(to->data(), count, stride, source, from.size());
  return error == 0 ? absl::OkStatus() : place.Fault("its bytes do not decode as " + mode);
}

absl::Status DecompressView(size_t index, Budget* budget, Gltf* gltf) {
  const Place view = gltf->At("bufferViews", index);
  const Place place = view.Extension(kMeshopt);
  const Json& json = place.json();
  const size_t count = json["count"].get<size_t>(), stride = json["byteStride"].get<size_t>();
  const std::string mode = json["mode"].get<std::string>(), filter = json.value("filter", "NONE");
  const std::string_view buffer = gltf->buffers[json["buffer"].get<size_t>()];
  if (buffer.empty()) return place.FaultAt("buffer", "has no bytes of its own");
  const std::string_view from = buffer.substr(json.value("byteOffset", size_t(0)), json["byteLength"].get<size_t>());
  RETURN_IF_ERROR(budget->Take(place, uint64_t(count) * stride));
  std::string bytes(count * stride, '\0');
  RETURN_IF_ERROR(DecodeMeshopt(mode, count, stride, from, place, &bytes));
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), count, stride);
  const size_t buffer_index = gltf->buffers.size();
  gltf->decoded.push_back(std::move(bytes));
  gltf->buffers.push_back(gltf->decoded.back());
  gltf->json["buffers"].push_back({{"byteLength", count * stride}});
  Json& rewritten = gltf->json["bufferViews"][index];
  rewritten["buffer"] = buffer_index;
  rewritten["byteOffset"] = 0;
  return absl::OkStatus();
}

template <typename T>
absl::Status AppendAttribute(const draco::PointAttribute& attribute, size_t points, int components, const Place& place,
                             std::string* bytes) {
  std::vector<T> values(static_cast<size_t>(components));
  for (uint32_t p = 0; p < points; ++p) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(p));
    if (value.value() >= attribute.size() || !attribute.ConvertValue<T>(value, int8_t(components), values.data())) {
      return place.Fault("its values are not in its bytes");
    }
    bytes->append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    bytes->resize((bytes->size() + 3) / 4 * 4);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> AttributeBytes(const draco::PointAttribute& attribute, size_t points, int64_t component,
                                           int components, const Place& place) {
  std::string bytes;
  switch (component) {
    case 5120:
      RETURN_IF_ERROR(AppendAttribute<int8_t>(attribute, points, components, place, &bytes));
      break;
    case 5121:
      RETURN_IF_ERROR(AppendAttribute<uint8_t>(attribute, points, components, place, &bytes));
      break;
    case 5122:
      RETURN_IF_ERROR(AppendAttribute<int16_t>(attribute, points, components, place, &bytes));
      break;
    case 5123:
      RETURN_IF_ERROR(AppendAttribute<uint16_t>(attribute, points, components, place, &bytes));
      break;
    case 5125:
      RETURN_IF_ERROR(AppendAttribute<uint32_t>(attribute, points, components, place, &bytes));
      break;
    default:
      RETURN_IF_ERROR(AppendAttribute<float>(attribute, points, components, place, &bytes));
  }
  return bytes;
}

absl::StatusOr<std::unique_ptr<draco::Mesh>> DecodeDraco(std::string_view bytes, const Place& place) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  try {
    auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) return place.Fault("does not decode: " + Quoted(mesh.status().error_msg_string()));
    return std::move(mesh).value();
  } catch (const std::exception& exception) {
    return place.Fault(std::string("does not decode: ") + exception.what());
  }
}

// An accessor like `source` over other bytes; its number.
size_t AddAccessor(const Place& source, std::string bytes, size_t stride, Gltf* gltf) {
  Json accessor = source.json();
  accessor["bufferView"] = AddView(std::move(bytes), gltf);
  accessor["byteOffset"] = 0;
  accessor.erase("sparse");
  if (stride != 0) gltf->json["bufferViews"].back()["byteStride"] = stride;
  gltf->json["accessors"].push_back(std::move(accessor));
  return gltf->json["accessors"].size() - 1;
}

absl::Status DecompressPrimitive(size_t mesh_index, size_t primitive_index, Budget* budget, Gltf* gltf) {
  const auto primitive = [&] { return gltf->At("meshes", mesh_index).Member("primitives").Element(primitive_index); };
  const Place place = primitive().Extension(kDraco);
  const Json& view = gltf->json["bufferViews"][place.json()["bufferView"].get<size_t>()];
  const std::string_view buffer = gltf->buffers[view["buffer"].get<size_t>()];
  if (buffer.empty()) return place.FaultAt("bufferView", "has no bytes of its own");
  const std::string_view bytes = buffer.substr(view.value("byteOffset", size_t(0)), view["byteLength"].get<size_t>());
  ASSIGN_OR_RETURN(const auto mesh, DecodeDraco(bytes, place));
  const size_t points = mesh->num_points();
  std::map<std::string, size_t> accessor_of;
  for (const auto& [name, id] : place.json()["attributes"].items()) {
    const Place at = place.Member("attributes").Member(name);
    ASSIGN_OR_RETURN(const Place accessor, gltf->Follow(primitive().Member("attributes"), name, "accessors"));
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(id.get<uint32_t>());
    if (attribute == nullptr) return at.Fault(id.dump() + "; its bytes have no such attribute");
    if (accessor.json()["count"].get<size_t>() != points) {
      return at.Fault(accessor.pointer() + " has a count of " + accessor.json()["count"].dump() + "; its bytes have " +
                      std::to_string(points) + " vertices");
    }
    const int64_t component = accessor.json()["componentType"].get<int64_t>();
    const int components =
        ElementBytes(accessor.json()["type"].get<std::string>(), component) / ComponentBytes(component);
    const size_t stride = (size_t(components) * size_t(ComponentBytes(component)) + 3) / 4 * 4;
    RETURN_IF_ERROR(budget->Take(at, uint64_t(points) * stride));
    ASSIGN_OR_RETURN(std::string values, AttributeBytes(*attribute, points, component, components, at));
    if (values.empty()) return at.Fault("its bytes have no vertices");
    accessor_of[name] = AddAccessor(accessor, std::move(values), stride, gltf);
  }
  ASSIGN_OR_RETURN(const Place indices, gltf->Follow(primitive(), "indices", "accessors"));
  if (indices.json()["count"].get<size_t>() != size_t{3} * mesh->num_faces()) {
    return primitive().FaultAt("indices", indices.pointer() + " has a count of " + indices.json()["count"].dump() +
                                              "; the compressed bytes have " + std::to_string(mesh->num_faces()) +
                                              " triangles");
  }
  RETURN_IF_ERROR(budget->Take(place, uint64_t{12} * mesh->num_faces()));
  std::string corners;
  for (uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh->face(draco::FaceIndex(f))) {
      const uint32_t value = corner.value();
      corners.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  }
  const size_t triangles = AddAccessor(indices, std::move(corners), 0, gltf);
  gltf->json["accessors"][triangles]["componentType"] = kUnsignedInt;
  Json& rewritten = gltf->json["meshes"][mesh_index]["primitives"][primitive_index];
  rewritten["indices"] = triangles;
  for (const auto& [name, accessor] : accessor_of) rewritten["attributes"][name] = accessor;
  return absl::OkStatus();
}

absl::StatusOr<bool> IsOneOf(const Place& place, const char* key, const std::vector<std::string>& words) {
  ASSIGN_OR_RETURN(const std::string word, place.Text(key));
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

bool IsMeshoptFallback(const Place& buffer) {
  return buffer.HasExtension(kMeshopt) && buffer.Extension(kMeshopt).json().value("fallback", Json(false)) == true;
}

absl::Status CheckMeshoptView(const Gltf& gltf, const Place& view) {
  if (!view.HasExtension(kMeshopt)) {
    const Place buffer = gltf.At("buffers", view.json()["buffer"].get<size_t>());
    if (IsMeshoptFallback(buffer) && !buffer.Has("uri")) {
      return view.FaultAt("buffer", buffer.pointer() + " has no bytes, and this view is not compressed");
    }
    return absl::OkStatus();
  }
  const Place place = view.Extension(kMeshopt);
  ASSIGN_OR_RETURN(const Place buffer, gltf.Follow(place, "buffer", "buffers"));
  const int64_t buffer_length = buffer.json()["byteLength"].get<int64_t>();
  ASSIGN_OR_RETURN(const int64_t length, place.Integer("byteLength", 1, buffer_length));
  ASSIGN_OR_RETURN(const int64_t offset, place.IntegerOr("byteOffset", 0, buffer_length - length, 0));
  (void)offset;
  ASSIGN_OR_RETURN(const bool is_mode, IsOneOf(place, "mode", {"ATTRIBUTES", "TRIANGLES", "INDICES"}));
  if (!is_mode)
    return place.FaultAt("mode", Quoted(place.json()["mode"]) + "; must be ATTRIBUTES, TRIANGLES or INDICES");
  const bool is_indices = place.json()["mode"] != "ATTRIBUTES";
  ASSIGN_OR_RETURN(const int64_t stride, place.Integer("byteStride", 1, 256));
  if (is_indices ? stride != 2 && stride != 4 : stride % 4 != 0) {
    return place.FaultAt("byteStride",
                         std::to_string(stride) + (is_indices ? "; indices have 2 or 4" : "; must be a multiple of 4"));
  }
  ASSIGN_OR_RETURN(const int64_t count, place.Integer("count", 1, std::numeric_limits<int32_t>::max()));
  if (place.json()["mode"] == "TRIANGLES" && count % 3 != 0) {
    return place.FaultAt("count", std::to_string(count) + "; triangles take three each");
  }
  if (count * stride != view.json()["byteLength"].get<int64_t>()) {
    return place.FaultAt("count", std::to_string(count) + " elements of " + std::to_string(stride) +
                                      " bytes; the view has " + view.json()["byteLength"].dump());
  }
  if (!place.Has("filter")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const bool is_filter, IsOneOf(place, "filter", {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"}));
  const std::string filter = place.json()["filter"];
  if (!is_filter) return place.FaultAt("filter", Quoted(filter) + "; no such filter");
  if (filter == "NONE") return absl::OkStatus();
  const bool fits = filter == "OCTAHEDRAL" ? stride == 4 || stride == 8 : filter == "QUATERNION" ? stride == 8 : true;
  if (is_indices || !fits)
    return place.FaultAt("filter",
                         filter + " of " + (is_indices ? "indices" : "a stride of " + std::to_string(stride)));
  return absl::OkStatus();
}

absl::Status CheckDracoPrimitive(const Place& primitive, Gltf* gltf) {
  if (!primitive.HasExtension(kDraco)) return absl::OkStatus();
  const Place place = primitive.Extension(kDraco);
  RETURN_IF_ERROR(gltf->Follow(place, "bufferView", "bufferViews").status());
  ASSIGN_OR_RETURN(const Place attributes, place.Object("attributes"));
  for (const auto& [name, id] : attributes.json().items()) {
    if (!primitive.Member("attributes").Has(name)) {
      return attributes.FaultAt(name, "is not among the primitive's attributes");
    }
    RETURN_IF_ERROR(attributes.Integer(name, 0, std::numeric_limits<uint16_t>::max()).status());
  }
  if (!primitive.Has("indices")) return primitive.FaultAt("indices", std::string("missing beside ") + kDraco);
  ASSIGN_OR_RETURN(const int64_t mode, primitive.IntegerOr("mode", 4, 5, 4));
  if (mode == 5) return primitive.FaultAt("mode", std::string("5; strips of ") + kDraco + " are not supported");
  return absl::OkStatus();
}

absl::Status Decompress(const SceneLoadLimits& limits, Gltf* gltf) {
  Budget budget(limits.max_scene_bytes);
  const size_t views = gltf->Count("bufferViews");
  for (size_t i = 0; gltf->Uses(kMeshopt) && i < views; ++i) {
    if (gltf->At("bufferViews", i).HasExtension(kMeshopt)) RETURN_IF_ERROR(DecompressView(i, &budget, gltf));
  }
  for (size_t m = 0; gltf->Uses(kDraco) && m < gltf->Count("meshes"); ++m) {
    const size_t primitives = gltf->json["meshes"][m]["primitives"].size();
    for (size_t p = 0; p < primitives; ++p) {
      if (!gltf->At("meshes", m).Member("primitives").Element(p).HasExtension(kDraco)) continue;
      RETURN_IF_ERROR(DecompressPrimitive(m, p, &budget, gltf));
    }
  }
  return absl::OkStatus();
}

}  // namespace halfshade
