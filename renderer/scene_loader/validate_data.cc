#include <algorithm>
#include <limits>

#include "renderer/scene_loader/validate_parts.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

constexpr int64_t kMaxBufferBytes = int64_t(1) << 40;
constexpr int64_t kMaxCount = int64_t(1) << 32;
constexpr int64_t kMaxSparse = std::numeric_limits<int32_t>::max();  // tinygltf keeps them in an int

struct Shape {
  const char* type;
  int columns, rows;
};
constexpr Shape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                             {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

const Shape* FindShape(const std::string& type) {
  for (const Shape& shape : kShapes) {
    if (type == shape.type) return &shape;
  }
  return nullptr;
}

int ColumnStride(const Shape& shape, int64_t component_type) {
  const int bytes = shape.rows * ComponentBytes(component_type);
  return shape.columns == 1 ? bytes : (bytes + 3) / 4 * 4;
}

// `view` is valid, so no sum below can wrap: every term is at most 2^40, count * stride at most 2^32 * 2^8.
absl::Status CheckFits(const Place& count_place, int64_t count, int64_t offset, int64_t element, int64_t stride,
                       const Place& view) {
  const int64_t length = view.json()["byteLength"].get<int64_t>();
  if (offset + (count - 1) * stride + element <= length) return absl::OkStatus();
  return count_place.Fault(std::to_string(count) + " elements pass the end of " + view.pointer() + " of " +
                           std::to_string(length) + " bytes");
}

int64_t OffsetOf(const Place& view) { return view.json().value("byteOffset", int64_t(0)); }

absl::Status CheckBufferView(const Gltf& gltf, const Place& view) {
  ASSIGN_OR_RETURN(const Place buffer, gltf.Follow(view, "buffer", "buffers"));
  const int64_t buffer_length = buffer.json()["byteLength"].get<int64_t>();
  ASSIGN_OR_RETURN(const int64_t length, view.Integer("byteLength", 1, buffer_length));
  ASSIGN_OR_RETURN(const int64_t offset, view.IntegerOr("byteOffset", 0, buffer_length, 0));
  if (offset > buffer_length - length) {
    return view.FaultAt("byteLength", std::to_string(length) + " from byteOffset " + std::to_string(offset) + "; " +
                                          buffer.pointer() + " has " + std::to_string(buffer_length));
  }
  ASSIGN_OR_RETURN(const int64_t stride, view.IntegerOr("byteStride", 4, 252, 4));
  if (stride % 4 != 0) return view.FaultAt("byteStride", std::to_string(stride) + "; must be a multiple of 4");
  return gltf.Uses("EXT_meshopt_compression") ? CheckMeshoptView(gltf, view) : absl::OkStatus();
}

// A packed array of a sparse accessor: its indices or its values.
absl::Status CheckSparsePart(const Gltf& gltf, const Place& part, const Place& count_place, int64_t component_bytes,
                             int64_t element, int64_t stride) {
  ASSIGN_OR_RETURN(const Place view, gltf.Follow(part, "bufferView", "bufferViews"));
  ASSIGN_OR_RETURN(const int64_t offset, part.IntegerOr("byteOffset", 0, kMaxSparse, 0));
  if (view.Has("byteStride")) return part.FaultAt("bufferView", "must be of a view without byteStride");
  if ((offset + OffsetOf(view)) % component_bytes != 0) {
    return part.FaultAt("byteOffset", "not aligned to its component");
  }
  return CheckFits(count_place, count_place.json().get<int64_t>(), offset, element, stride, view);
}

absl::Status CheckSparse(const Gltf& gltf, const Place& accessor, const std::string& type, int64_t component,
                         int64_t count) {
  ASSIGN_OR_RETURN(const Place sparse, accessor.Object("sparse"));
  RETURN_IF_ERROR(sparse.Integer("count", 1, std::min(count, kMaxSparse)).status());
  const Place count_place = sparse.Member("count");
  ASSIGN_OR_RETURN(const Place indices, sparse.Object("indices"));
  ASSIGN_OR_RETURN(const int64_t index_type, indices.Integer("componentType", 5121, 5125));
  if (index_type % 2 == 0) return indices.FaultAt("componentType", "must be an unsigned integer");
  const int index_bytes = ComponentBytes(index_type);
  RETURN_IF_ERROR(CheckSparsePart(gltf, indices, count_place, index_bytes, index_bytes, index_bytes));
  ASSIGN_OR_RETURN(const Place values, sparse.Object("values"));
  return CheckSparsePart(gltf, values, count_place, ComponentBytes(component), ElementBytes(type, component),
                         PackedStride(type, component));
}

// min and max are numbers, one for each component; what they say is never used.
absl::Status CheckStatedBounds(const Place& accessor, size_t components, Warnings* warnings) {
  for (const char* key : {"min", "max"}) {
    RETURN_IF_ERROR(accessor.CheckNumbers(key, components, -1e300, 1e300));
  }
  if (!accessor.Has("min") || !accessor.Has("max")) return absl::OkStatus();
  for (size_t i = 0; i < components; ++i) {
    if (accessor.json()["min"][i].get<double>() > accessor.json()["max"][i].get<double>()) {
      warnings->Add(accessor.pointer(), "min is over max; bounds are measured");
      break;
    }
  }
  return absl::OkStatus();
}

absl::Status CheckAccessor(const Place& accessor, Gltf* gltf) {
  ASSIGN_OR_RETURN(const int64_t component, accessor.Integer("componentType", 5120, 5126));
  if (ComponentBytes(component) == 0) {
    return accessor.FaultAt("componentType", std::to_string(component) + "; no such type");
  }
  ASSIGN_OR_RETURN(const std::string type, accessor.Text("type"));
  const Shape* shape = FindShape(type);
  if (shape == nullptr) return accessor.FaultAt("type", Quoted(type) + "; no such type");
  ASSIGN_OR_RETURN(const int64_t count, accessor.Integer("count", 1, kMaxCount));
  RETURN_IF_ERROR(accessor.CheckFlag("normalized"));
  RETURN_IF_ERROR(CheckStatedBounds(accessor, size_t(shape->columns * shape->rows), &gltf->warnings));
  if (accessor.Has("sparse")) RETURN_IF_ERROR(CheckSparse(*gltf, accessor, type, component, count));
  if (!accessor.Has("bufferView")) return absl::OkStatus();  // zeros

  ASSIGN_OR_RETURN(const Place view, gltf->Follow(accessor, "bufferView", "bufferViews"));
  const int64_t element = ElementBytes(type, component);
  const int64_t stride = view.json().value("byteStride", int64_t(PackedStride(type, component)));
  ASSIGN_OR_RETURN(const int64_t offset,
                   accessor.IntegerOr("byteOffset", 0, view.json()["byteLength"].get<int64_t>(), 0));
  if (stride < element) {
    return accessor.Fault("its elements of " + std::to_string(element) + " bytes overlap at the stride of " +
                          view.pointer() + ", " + std::to_string(stride));
  }
  if ((offset + OffsetOf(view)) % ComponentBytes(component) != 0) {
    return accessor.FaultAt("byteOffset", "not aligned to its component");
  }
  return CheckFits(accessor.Member("count"), count, offset, element, stride, view);
}

absl::Status CheckSampler(const Place& sampler) {
  for (const char* key : {"wrapS", "wrapT"}) {
    ASSIGN_OR_RETURN(const int64_t wrap, sampler.IntegerOr(key, 0, 65535, 10497));
    if (wrap != 10497 && wrap != 33071 && wrap != 33648) {
      return sampler.FaultAt(key, std::to_string(wrap) + "; no such mode");
    }
  }
  for (const char* key : {"magFilter", "minFilter"}) {
    ASSIGN_OR_RETURN(const int64_t filter, sampler.IntegerOr(key, 0, 65535, 9729));
    const bool is_mip = key == std::string("minFilter") && filter >= 9984 && filter <= 9987;
    if (filter != 9728 && filter != 9729 && !is_mip) {
      return sampler.FaultAt(key, std::to_string(filter) + "; no such filter");
    }
  }
  return absl::OkStatus();
}

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

int ElementBytes(const std::string& type, int64_t component_type) {
  const Shape* shape = FindShape(type);
  if (shape == nullptr) return 0;
  return (shape->columns - 1) * ColumnStride(*shape, component_type) + shape->rows * ComponentBytes(component_type);
}

int PackedStride(const std::string& type, int64_t component_type) {
  const Shape* shape = FindShape(type);
  return shape == nullptr ? 0 : shape->columns * ColumnStride(*shape, component_type);
}

absl::Status ValidateData(const SceneLoadLimits& limits, Gltf* gltf) {
  for (size_t i = 0; i < gltf->Count("buffers"); ++i) {
    RETURN_IF_ERROR(gltf->At("buffers", i).Integer("byteLength", 1, kMaxBufferBytes).status());
  }
  for (size_t i = 0; i < gltf->Count("bufferViews"); ++i) {
    RETURN_IF_ERROR(CheckBufferView(*gltf, gltf->At("bufferViews", i)));
  }
  // Accessors may overlap, and those of zeros have no bytes: what they stand for is bounded all the same.
  uint64_t total = 0;
  for (size_t i = 0; i < gltf->Count("accessors"); ++i) {
    const Place accessor = gltf->At("accessors", i);
    RETURN_IF_ERROR(CheckAccessor(accessor, gltf));
    total += accessor.json()["count"].get<uint64_t>() *
             uint64_t(ElementBytes(accessor.json()["type"].get<std::string>(),
                                   accessor.json()["componentType"].get<int64_t>()));
    if (total > limits.max_scene_bytes) {
      const char* zeros = accessor.Has("bufferView") ? "" : accessor.Has("sparse") ? ", zeros under sparse" : ", zeros";
      return accessor.Fault("the accessors up to here hold " + std::to_string(total) + " bytes" + zeros + "; at most " +
                            std::to_string(limits.max_scene_bytes));
    }
  }
  for (size_t i = 0; i < gltf->Count("samplers"); ++i) RETURN_IF_ERROR(CheckSampler(gltf->At("samplers", i)));
  for (size_t i = 0; i < gltf->Count("textures"); ++i) {
    const Place texture = gltf->At("textures", i);
    RETURN_IF_ERROR(gltf->CheckOptionalIndex(texture, "source", "images"));
    RETURN_IF_ERROR(gltf->CheckOptionalIndex(texture, "sampler", "samplers"));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
