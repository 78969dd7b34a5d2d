#include "renderer/scene_loader/gltf_json.h"

#include <algorithm>
#include <limits>
#include <unordered_set>

#include "renderer/status.h"

namespace halfshade {
namespace {

std::string Range(const std::string& value, double low, double high) {
  return value + "; must be " + Json(low).dump() + " to " + Json(high).dump();
}

}  // namespace

std::string Quoted(const std::string& text, size_t max_bytes) {
  return Json(text.substr(0, max_bytes)).dump(-1, ' ', true, Json::error_handler_t::replace);
}

absl::Status Place::Fault(const std::string& what) const {
  return absl::InvalidArgumentError((pointer_.empty() ? "/" : pointer_) + ": " + what);
}

std::string Place::MemberPointer(const std::string& key) const {
  std::string pointer = pointer_ + "/";
  for (const char c : key.substr(0, 60)) {
    if (c == '~' || c == '/') {
      pointer += c == '~' ? "~0" : "~1";
    } else {
      pointer += c > ' ' && c < 127 ? c : '?';
    }
  }
  return pointer;
}

bool Place::HasExtension(const char* name) const {
  return Has("extensions") && Member("extensions").json().is_object() && Member("extensions").Has(name) &&
         Extension(name).json().is_object();
}

Place Place::Member(const std::string& key) const { return {(*json_)[key], MemberPointer(key)}; }

absl::Status Place::FaultAt(const std::string& key, const std::string& what) const {
  return absl::InvalidArgumentError(MemberPointer(key) + ": " + what);
}

absl::StatusOr<Place> Place::Object(const std::string& key) const {
  if (!Has(key)) return FaultAt(key, "missing");
  if (!Member(key).json().is_object()) return FaultAt(key, "must be an object");
  return Member(key);
}

absl::StatusOr<Place> Place::Array(const std::string& key) const {
  if (!Has(key)) return FaultAt(key, "missing");
  if (!Member(key).json().is_array()) return FaultAt(key, "must be an array");
  return Member(key);
}

absl::StatusOr<std::string> Place::Text(const std::string& key) const {
  if (!Has(key)) return FaultAt(key, "missing");
  if (!Member(key).json().is_string()) return FaultAt(key, "must be a string");
  return Member(key).json().get<std::string>();
}

absl::StatusOr<int64_t> Place::Integer(const std::string& key, int64_t low, int64_t high) const {
  if (!Has(key)) return FaultAt(key, "missing");
  const Json& value = Member(key).json();
  const std::string range = "; must be " + std::to_string(low) + " to " + std::to_string(high);
  if (!value.is_number_integer()) return FaultAt(key, "must be an integer");
  const bool is_too_large =
      value.is_number_unsigned() && value.get<uint64_t>() > uint64_t(std::numeric_limits<int64_t>::max());
  if (is_too_large || value.get<int64_t>() < low || value.get<int64_t>() > high) {
    return FaultAt(key, value.dump() + range);
  }
  return value.get<int64_t>();
}

absl::StatusOr<int64_t> Place::IntegerOr(const std::string& key, int64_t low, int64_t high, int64_t absent) const {
  if (!Has(key)) return absent;
  return Integer(key, low, high);
}

absl::StatusOr<double> Place::Number(const std::string& key, double low, double high) const {
  if (!Has(key)) return FaultAt(key, "missing");
  const Json& value = Member(key).json();
  if (!value.is_number()) return FaultAt(key, "must be a number");
  if (!(value.get<double>() >= low && value.get<double>() <= high)) return FaultAt(key, Range(value.dump(), low, high));
  return value.get<double>();
}

absl::Status Place::CheckNumber(const std::string& key, double low, double high) const {
  return Has(key) ? Number(key, low, high).status() : absl::OkStatus();
}

absl::Status Place::CheckNumbers(const std::string& key, size_t count, double low, double high) const {
  if (!Has(key)) return absl::OkStatus();
  const Place list = Member(key);
  if (!list.json().is_array() || list.size() != count)
    return list.Fault("must be " + std::to_string(count) + " numbers");
  for (size_t i = 0; i < count; ++i) {
    const Place element = list.Element(i);
    if (!element.json().is_number()) return element.Fault("must be a number");
    const double value = element.json().get<double>();
    if (!(value >= low && value <= high)) return element.Fault(Range(element.json().dump(), low, high));
  }
  return absl::OkStatus();
}

absl::Status Place::CheckFlag(const std::string& key) const {
  return !Has(key) || Member(key).json().is_boolean() ? absl::OkStatus() : FaultAt(key, "must be true or false");
}

void Warnings::Add(const std::string& pointer, const std::string& text) {
  const auto known = entry_of_text_.find(text);
  if (known != entry_of_text_.end()) {
    ++entries_[known->second].count;
  } else if (entries_.size() < kMaxTexts) {
    entry_of_text_[text] = entries_.size();
    entries_.push_back({pointer, text});
  } else {
    ++left_out_;
  }
}

std::vector<std::string> Warnings::Take() {
  std::vector<std::string> texts;
  for (const Entry& entry : entries_) {
    texts.push_back(entry.pointer + ": " + entry.text +
                    (entry.count > 1 ? " (here and in " + std::to_string(entry.count - 1) + " more places)" : ""));
  }
  if (left_out_ > 0) texts.push_back("/: " + std::to_string(left_out_) + " more warnings");
  return texts;
}

size_t Gltf::Count(const std::string& array) const { return json.contains(array) ? json[array].size() : 0; }

bool Gltf::Uses(const std::string& extension) const {
  if (!json.contains("extensionsUsed")) return false;
  const Json& used = json["extensionsUsed"];
  return std::find(used.begin(), used.end(), extension) != used.end();
}

Place Gltf::At(const std::string& array, size_t index) const {
  return {json[array][index], "/" + array + "/" + std::to_string(index)};
}

absl::StatusOr<Place> Gltf::Follow(const Place& index, const std::string& array) const {
  const Json& value = index.json();
  if (!value.is_number_integer() || value < 0) return index.Fault("must be an index");
  if (value >= Count(array)) {
    return index.Fault(value.dump() + "; the file has " + std::to_string(Count(array)) + " " + array);
  }
  return At(array, value.get<size_t>());
}

absl::StatusOr<Place> Gltf::Follow(const Place& from, const std::string& key, const std::string& array) const {
  if (!from.Has(key)) return from.FaultAt(key, "missing");
  return Follow(from.Member(key), array);
}

absl::Status Gltf::CheckOptionalIndex(const Place& from, const std::string& key, const std::string& array) const {
  return from.Has(key) ? Follow(from, key, array).status() : absl::OkStatus();
}

absl::Status Gltf::CheckIndexList(const Place& from, const std::string& key, const std::string& array) const {
  if (!from.Has(key)) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Place list, from.Array(key));
  std::unordered_set<uint64_t> seen;
  for (size_t i = 0; i < list.size(); ++i) {
    const Place index = list.Element(i);
    RETURN_IF_ERROR(Follow(index, array).status());
    if (!seen.insert(index.json().get<uint64_t>()).second)
      return index.Fault(index.json().dump() + " stands here twice");
  }
  return absl::OkStatus();
}

}  // namespace halfshade
