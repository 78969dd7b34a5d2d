// Reads the elements of one accessor of a validated glTF, sparse ones and those of zeros too. Copies nothing.
#pragma once

#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace tinygltf {
class Model;
}

namespace halfshade {

// A parsed glTF: tinygltf's arrays, and the bytes, which tinygltf never sees. Both outlive whoever holds this.
struct GltfData {
  const tinygltf::Model* model = nullptr;
  const std::vector<std::string_view>* buffers = nullptr;  // each as long as its byteLength
};

class AccessorReader {
 public:
  AccessorReader(const GltfData& data, int accessor);

  size_t count() const { return count_; }
  int components() const { return components_; }
  bool is_float() const { return is_float_; }

  // An unsigned integer as it is.
  uint32_t Index(size_t element) const { return Unsigned(At(element)); }
  uint32_t IndexAt(size_t element, int component) const {
    return Unsigned(At(element) + size_t(component) * size_t(component_bytes_));
  }
  // A float as it is; an integer too, or normalized where the accessor says so (glTF 2.0, 3.11).
  float Float(size_t element, int component) const;
  template <typename Vec>
  Vec Vector(size_t element) const {
    Vec value;
    for (int i = 0; i < Vec::length(); ++i) value[i] = Float(element, i);
    return value;
  }
  // The largest component of all elements.
  uint32_t LargestIndex() const;

  size_t sparse_count() const { return sparse_count_; }
  // Which element the sparse value `i` replaces.
  uint32_t SparseIndex(size_t i) const;

 private:
  const char* At(size_t element) const;
  uint32_t Unsigned(const char* at) const;

  size_t count_ = 0;
  int components_ = 0;
  int component_bytes_ = 0;
  int component_type_ = 0;
  bool is_float_ = false;
  bool is_normalized_ = false;
  const char* base_ = nullptr;  // null: zeros
  size_t stride_ = 0;
  size_t sparse_count_ = 0;
  const char* sparse_indices_ = nullptr;
  int sparse_index_bytes_ = 0;
  const char* sparse_values_ = nullptr;
  size_t sparse_stride_ = 0;
};

}  // namespace halfshade
