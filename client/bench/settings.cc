#include "client/bench/settings.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>

#include "client/field_text.h"
#include "renderer/status.h"

namespace halfshade::bench {

absl::StatusOr<std::vector<Setting>> MakeSettings(const std::vector<SettingText>& texts,
                                                  const std::vector<std::string>& methods) {
  std::vector<Setting> settings;
  for (const SettingText& text : texts) {
    const bool is_there = std::find(methods.begin(), methods.end(), text.method) != methods.end();
    if (!is_there && std::string(text.method) != "auto") continue;
    Setting& setting = settings.emplace_back();
    setting.method = text.method;
    setting.label = absl::StrJoin(text.options, " ");
    setting.filter_radius = text.filter_radius;
    const bool is_adaptive = std::find(text.options.begin(), text.options.end(), "adaptive=true") != text.options.end();
    setting.family = absl::StrCat(text.method, is_adaptive ? " adaptive" : "");
    if (text.filter_radius > 0) {
      const int side = 2 * text.filter_radius + 1;
      absl::StrAppend(&setting.label, " filter ", side, "x", side);
      absl::StrAppend(&setting.family, " filtered");
    }
    const auto* field = v1::Method::descriptor()->FindFieldByName(text.method);
    google::protobuf::Message* options = setting.options.GetReflection()->MutableMessage(&setting.options, field);
    for (const std::string& option : text.options) {
      const size_t equals = option.find('=');
      const std::string key = option.substr(0, equals);
      if (key == "max_error") {  // of the request's budget
        setting.max_error = std::stod(option.substr(equals + 1));
        continue;
      }
      const auto* option_field = options->GetDescriptor()->FindFieldByName(key);
      if (option_field == nullptr) return absl::InternalError(absl::StrCat(text.method, " has no option ", key));
      RETURN_IF_ERROR(SetFieldFromText(options, *option_field, key, option.substr(equals + 1)));
    }
    if (setting.max_error > 0 && setting.method != "auto") setting.family += " by budget";
  }
  return settings;
}

}  // namespace halfshade::bench
