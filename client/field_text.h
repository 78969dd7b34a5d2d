// Text of the command line -> fields of a message, by protobuf reflection: one reader for --set, --camera, --light and
// --ground. It checks the form of a value only ("nan" is a number); ranges are the server's to judge.
#pragma once

#include <absl/status/status.h>
#include <google/protobuf/message.h>

#include <span>
#include <string>

namespace halfshade {

// Sets `field` of `message`. Numbers in decimal, "nan" and "inf" included; booleans true or false; enum values without
// their prefix in any case; messages of three numbers (Vec3, Rgb) as "x,y,z". Errors: usage, naming `key` and the text.
absl::Status SetFieldFromText(google::protobuf::Message* message, const google::protobuf::FieldDescriptor& field,
                              const std::string& key, const std::string& text);

// A word of the command line and the field that it sets.
struct FieldWord {
  const char* key;
  const char* field;
};

// Reads "key=value key=value flag" (blanks between words; a bare key sets a boolean) into `message`.
// Errors: usage, for a key that is not in `words`, one given twice, and a value of the wrong form; it starts with
// `flag`.
absl::Status SetFieldsFromWords(const std::string& flag, const std::string& text, std::span<const FieldWord> words,
                                google::protobuf::Message* message);

}  // namespace halfshade
