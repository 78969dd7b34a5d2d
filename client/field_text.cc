#include "client/field_text.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <vector>

#include "client/exit_code.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

using google::protobuf::EnumDescriptor;
using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

template <typename T>
bool ReadNumber(const std::string& text, T* value) {
  const char* end = text.data() + text.size();
  auto [stop, error] = std::from_chars(text.data(), end, *value);
  return error == std::errc() && stop == end;
}

// "SSM_RESOLVE_" of SSM_RESOLVE_UNSPECIFIED.
std::string EnumPrefix(const EnumDescriptor& type) {
  return std::string(absl::StripSuffix(type.FindValueByNumber(0)->name(), "UNSPECIFIED"));
}

const EnumValueDescriptor* FindEnumValue(const EnumDescriptor& type, const std::string& text) {
  const EnumValueDescriptor* value = type.FindValueByName(EnumPrefix(type) + absl::AsciiStrToUpper(text));
  return value == nullptr || value->number() == 0 ? nullptr : value;
}

std::string EnumChoices(const EnumDescriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.value_count(); ++i) {
    if (type.value(i)->number() != 0) names.push_back(type.value(i)->name().substr(EnumPrefix(type).size()));
  }
  return absl::StrJoin(names, ", ");
}

}  // namespace

absl::Status SetFieldFromText(Message* message, const FieldDescriptor& field, const std::string& key,
                              const std::string& text) {
  const google::protobuf::Reflection& reflection = *message->GetReflection();
  auto wrong = [&](const std::string& wanted) {
    return UsageError(absl::StrCat(key, ": '", text, "' is not ", wanted));
  };
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_UINT32: {
      uint32_t value = 0;
      if (!ReadNumber(text, &value)) return wrong("a whole number from 0 to 4294967295");
      reflection.SetUInt32(message, &field, value);
      return absl::OkStatus();
    }
    case FieldDescriptor::CPPTYPE_FLOAT: {
      float value = 0;
      if (!ReadNumber(text, &value)) return wrong("a number");
      reflection.SetFloat(message, &field, value);
      return absl::OkStatus();
    }
    case FieldDescriptor::CPPTYPE_DOUBLE: {
      double value = 0;
      if (!ReadNumber(text, &value)) return wrong("a number");
      reflection.SetDouble(message, &field, value);
      return absl::OkStatus();
    }
    case FieldDescriptor::CPPTYPE_BOOL:
      if (text != "true" && text != "false") return wrong("true or false");
      reflection.SetBool(message, &field, text == "true");
      return absl::OkStatus();
    case FieldDescriptor::CPPTYPE_ENUM: {
      const EnumValueDescriptor* value = FindEnumValue(*field.enum_type(), text);
      if (value == nullptr) return wrong(absl::StrCat("one of ", EnumChoices(*field.enum_type())));
      reflection.SetEnum(message, &field, value);
      return absl::OkStatus();
    }
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      const auto* type = field.message_type();
      const std::vector<std::string> parts = absl::StrSplit(text, ',');
      if (parts.size() != static_cast<size_t>(type->field_count())) {
        return wrong(absl::StrCat(type->field_count(), " numbers with commas between them"));
      }
      Message* value = reflection.MutableMessage(message, &field);
      for (int i = 0; i < type->field_count(); ++i) {
        RETURN_IF_ERROR(SetFieldFromText(value, *type->field(i), key, parts[static_cast<size_t>(i)]));
      }
      return absl::OkStatus();
    }
    default:
      return wrong("something that the command line can say; use --request");
  }
}

absl::Status SetFieldsFromWords(const std::string& flag, const std::string& text, std::span<const FieldWord> words,
                                Message* message) {
  std::set<std::string> seen;
  for (const auto& part : absl::StrSplit(text, absl::ByAnyChar(" \t\n"), absl::SkipEmpty())) {
    const std::vector<std::string> key_value = absl::StrSplit(part, absl::MaxSplits('=', 1));
    const std::string& key = key_value[0];
    const auto word = std::find_if(words.begin(), words.end(), [&](const FieldWord& w) { return key == w.key; });
    if (word == words.end()) {
      const auto name = [](std::string* out, const FieldWord& w) { out->append(w.key); };
      return UsageError(absl::StrCat(flag, ": no key '", key, "'; there are ", absl::StrJoin(words, ", ", name)));
    }
    if (!seen.insert(key).second) return UsageError(absl::StrCat(flag, ": '", key, "' is given twice"));
    const FieldDescriptor& field = *message->GetDescriptor()->FindFieldByName(word->field);
    const bool is_bare = key_value.size() == 1;
    if (is_bare && field.cpp_type() != FieldDescriptor::CPPTYPE_BOOL) {
      return UsageError(absl::StrCat(flag, ": '", key, "' needs a value: ", key, "=..."));
    }
    RETURN_IF_ERROR(SetFieldFromText(message, field, absl::StrCat(flag, " ", key), is_bare ? "true" : key_value[1]));
  }
  return absl::OkStatus();
}

}  // namespace halfshade
