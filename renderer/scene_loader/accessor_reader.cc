#include "renderer/scene_loader/accessor_reader.h"

#include <algorithm>

#include "renderer/scene_loader/tinygltf.h"

namespace halfshade {
namespace {

constexpr char kZeros[64] = {};  // the largest element: MAT4 of floats

const char* ViewBytes(const GltfData& data, int view, size_t offset) {
  const tinygltf::BufferView& source = data.model->bufferViews[size_t(view)];
  return (*data.buffers)[size_t(source.buffer)].data() + source.byteOffset + offset;
}

// Little-endian, as the machine is.
uint32_t ReadUnsigned(const char* at, int bytes) {
  uint32_t value = 0;
  std::memcpy(&value, at, size_t(bytes));
  return value;
}

template <typename T>
T Read(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(value));
  return value;
}

}  // namespace

AccessorReader::AccessorReader(const GltfData& data, int accessor) {
  const tinygltf::Accessor& source = data.model->accessors[size_t(accessor)];
  count_ = source.count;
  components_ = tinygltf::GetNumComponentsInType(uint32_t(source.type));
  component_bytes_ = tinygltf::GetComponentSizeInBytes(uint32_t(source.componentType));
  component_type_ = source.componentType;
  is_float_ = source.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
  is_normalized_ = source.normalized;
  const size_t packed = size_t(components_) * size_t(component_bytes_);  // no matrices of small integers are read
  stride_ = packed;
  if (source.bufferView >= 0) {
    base_ = ViewBytes(data, source.bufferView, source.byteOffset);
    const size_t stride = data.model->bufferViews[size_t(source.bufferView)].byteStride;
    if (stride != 0) stride_ = stride;
  }
  if (!source.sparse.isSparse) return;
  const auto& [is_sparse_count, is_sparse, indices, values] = source.sparse;
  sparse_count_ = size_t(is_sparse_count);
  sparse_indices_ = ViewBytes(data, indices.bufferView, size_t(indices.byteOffset));
  sparse_index_bytes_ = tinygltf::GetComponentSizeInBytes(uint32_t(indices.componentType));
  sparse_values_ = ViewBytes(data, values.bufferView, size_t(values.byteOffset));
  sparse_stride_ = packed;
}

uint32_t AccessorReader::SparseIndex(size_t i) const {
  return ReadUnsigned(sparse_indices_ + i * size_t(sparse_index_bytes_), sparse_index_bytes_);
}

const char* AccessorReader::At(size_t element) const {
  // Indices increase: check_data has seen to that.
  size_t low = 0;
  for (size_t high = sparse_count_; low < high;) {
    const size_t middle = (low + high) / 2;
    if (SparseIndex(middle) < element) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  if (low < sparse_count_ && SparseIndex(low) == element) return sparse_values_ + low * sparse_stride_;
  return base_ == nullptr ? kZeros : base_ + element * stride_;
}

uint32_t AccessorReader::Unsigned(const char* at) const { return ReadUnsigned(at, component_bytes_); }

float AccessorReader::Float(size_t element, int component) const {
  const char* at = At(element) + size_t(component) * size_t(component_bytes_);
  if (is_float_) return Read<float>(at);
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return is_normalized_ ? std::max(float(Read<int8_t>(at)) / 127, -1.0f) : float(Read<int8_t>(at));
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return is_normalized_ ? std::max(float(Read<int16_t>(at)) / 32767, -1.0f) : float(Read<int16_t>(at));
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return is_normalized_ ? float(Unsigned(at)) / 255 : float(Unsigned(at));
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return is_normalized_ ? float(Unsigned(at)) / 65535 : float(Unsigned(at));
    default:
      return float(Unsigned(at));
  }
}

uint32_t AccessorReader::LargestIndex() const {
  uint32_t largest = 0;
  for (size_t i = 0; i < count_; ++i) {
    const char* at = At(i);
    for (int c = 0; c < components_; ++c)
      largest = std::max(largest, Unsigned(at + size_t(c) * size_t(component_bytes_)));
  }
  return largest;
}

}  // namespace halfshade
