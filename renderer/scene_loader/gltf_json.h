// glTF's JSON with its places: every getter checks what it gets and names the fault by JSON pointer.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace halfshade {

using Json = nlohmann::json;

// A stranger's text for a message: in quotes, short, ASCII, on one line.
std::string Quoted(const std::string& text, size_t max_bytes = 80);

// A value of the JSON and where it stands. The JSON outlives it.
class Place {
 public:
  Place(const Json& json, std::string pointer) : json_(&json), pointer_(std::move(pointer)) {}

  const Json& json() const { return *json_; }
  const std::string& pointer() const { return pointer_; }
  // INVALID_ARGUMENT "<pointer>: <what>".
  absl::Status Fault(const std::string& what) const;

  // Of an object. Member and MemberPointer escape the key; the member must be there.
  bool Has(const std::string& key) const { return json_->contains(key); }
  // Whether there is an object extensions/name here.
  bool HasExtension(const char* name) const;
  Place Extension(const char* name) const { return Member("extensions").Member(name); }
  Place Member(const std::string& key) const;
  absl::Status FaultAt(const std::string& key, const std::string& what) const;
  absl::StatusOr<Place> Object(const std::string& key) const;
  absl::StatusOr<Place> Array(const std::string& key) const;
  absl::StatusOr<std::string> Text(const std::string& key) const;
  absl::StatusOr<int64_t> Integer(const std::string& key, int64_t low, int64_t high) const;
  absl::StatusOr<int64_t> IntegerOr(const std::string& key, int64_t low, int64_t high, int64_t absent) const;
  absl::StatusOr<double> Number(const std::string& key, double low, double high) const;
  // These allow absence.
  absl::Status CheckNumber(const std::string& key, double low, double high) const;
  absl::Status CheckNumbers(const std::string& key, size_t count, double low, double high) const;
  absl::Status CheckFlag(const std::string& key) const;

  // Of an array.
  size_t size() const { return json_->size(); }
  Place Element(size_t index) const { return {(*json_)[index], pointer_ + "/" + std::to_string(index)}; }

 private:
  std::string MemberPointer(const std::string& key) const;

  const Json* json_;
  std::string pointer_;
};

// What is said for the user. The same words about many places are said once, with their number.
class Warnings {
 public:
  static constexpr size_t kMaxTexts = 64;

  void Add(const std::string& pointer, const std::string& text);
  std::vector<std::string> Take();

 private:
  struct Entry {
    std::string pointer, text;
    size_t count = 1;
  };
  std::vector<Entry> entries_;
  std::map<std::string, size_t> entry_of_text_;
  size_t left_out_ = 0;
};

// A glTF on its way through validation.
struct Gltf {
  Json json;
  std::vector<std::string_view> buffers;  // exactly byteLength long; into the root, the file map, or `decoded`
  std::vector<std::string_view> images;   // encoded
  std::deque<std::string> decoded;        // bytes of ours that buffers and images may point to
  Warnings warnings;
  // What the flat scene is built from beside tinygltf's model, kept when the rest of the JSON goes.
  Json materials, textures, animations, lights;
  std::map<size_t, Json> node_extensions;

  size_t Count(const std::string& array) const;
  bool Uses(const std::string& extension) const;  // says that it uses it
  Place At(const std::string& array, size_t index) const;
  // The element of a top-level array that `from`'s member, or an index in an array, names.
  absl::StatusOr<Place> Follow(const Place& from, const std::string& key, const std::string& array) const;
  absl::StatusOr<Place> Follow(const Place& index, const std::string& array) const;
  absl::Status CheckOptionalIndex(const Place& from, const std::string& key, const std::string& array) const;
  // An array, or nothing, of different indices.
  absl::Status CheckIndexList(const Place& from, const std::string& key, const std::string& array) const;
};

}  // namespace halfshade
