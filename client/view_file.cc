#include "client/view_file.h"

#include <absl/strings/str_cat.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "client/input_file.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

using Json = nlohmann::json;
using Vector = std::array<double, 3>;

// Reads keys of one object of the view. The first key that is missing or of the wrong type is kept as the error.
class Reader {
 public:
  Reader(const Json& object, std::string place, absl::Status* status)
      : object_(object), place_(std::move(place)), status_(*status) {}

  double Number(const char* key) {
    const auto found = object_.find(key);
    if (found != object_.end() && found->is_number()) return found->get<double>();
    Fail(key, "needs a number");
    return 0;
  }
  Vector Three(const char* key) {
    const auto found = object_.find(key);
    if (found != object_.end() && found->is_array() && found->size() == 3 && (*found)[0].is_number() &&
        (*found)[1].is_number() && (*found)[2].is_number()) {
      return {(*found)[0].get<double>(), (*found)[1].get<double>(), (*found)[2].get<double>()};
    }
    Fail(key, "needs three numbers");
    return {};
  }
  bool Truth(const char* key) {
    const auto found = object_.find(key);
    if (found != object_.end() && found->is_boolean()) return found->get<bool>();
    Fail(key, "needs true or false");
    return false;
  }
  void Fail(const char* key, const char* why) {
    if (status_.ok()) status_ = absl::InvalidArgumentError(absl::StrCat(place_, ".", key, ": ", why));
  }

 private:
  const Json& object_;
  std::string place_;
  absl::Status& status_;
};

void Set(const Vector& vector, double factor, v1::Vec3* out) {
  out->set_x(vector[0] * factor);
  out->set_y(vector[1] * factor);
  out->set_z(vector[2] * factor);
}

// dot(cross(u, v), n): 1 where the axes are right-handed, -1 where they are left-handed.
double Handedness(const Vector& u, const Vector& v, const Vector& n) {
  return (u[1] * v[2] - u[2] * v[1]) * n[0] + (u[2] * v[0] - u[0] * v[2]) * n[1] + (u[0] * v[1] - u[1] * v[0]) * n[2];
}

void ReadCamera(Reader view, v1::Camera* camera) {
  v1::LookAt* look_at = camera->mutable_look_at();
  Set(view.Three("eye"), 1, look_at->mutable_eye());
  Set(view.Three("target"), 1, look_at->mutable_target());
  Set(view.Three("up"), 1, look_at->mutable_up());
  look_at->set_fovy_deg(view.Number("fovy_deg"));
}

void ReadLight(Reader view, v1::AreaLight* light) {
  const Vector u = view.Three("u"), v = view.Three("v"), normal = view.Three("normal");
  const double width = view.Number("width"), height = view.Number("height");
  const double handedness = Handedness(u, v, normal);
  // Axes are written with six digits or so; an angle of more than about 2.5 degrees is no rounding.
  if (!(std::abs(handedness) > 0.999)) view.Fail("normal", "is not cross(u, v) or its negative");
  Set(view.Three("center"), 1, light->mutable_center());
  Set(u, width, light->mutable_edge_u());
  Set(v, handedness < 0 ? -height : height, light->mutable_edge_v());
  if (width == 0 || height == 0) Set(normal, 1, light->mutable_direction());
}

absl::Status ReadView(const Json& view, v1::RenderRequest* request) {
  if (!view.is_object()) return absl::InvalidArgumentError("is not a JSON object");
  absl::Status status;
  if (const auto camera = view.find("camera"); camera != view.end()) {
    ReadCamera(Reader(*camera, "camera", &status), request->mutable_camera());
  }
  if (const auto lights = view.find("lights"); lights != view.end()) {
    request->clear_lights();
    for (const Json& light : *lights) {
      const std::string place = absl::StrCat("lights[", request->lights_size(), "]");
      ReadLight(Reader(light, place, &status), request->add_lights());
    }
  } else if (const auto light = view.find("light"); light != view.end()) {
    request->clear_lights();
    ReadLight(Reader(*light, "light", &status), request->add_lights());
  }
  if (const auto ground = view.find("ground"); ground != view.end()) {
    Reader reader(*ground, "ground", &status);
    request->clear_ground();
    if (reader.Truth("add")) {
      request->mutable_ground()->set_height_m(reader.Number("y"));
      request->mutable_ground()->set_size_m(reader.Number("size"));
    }
  }
  return status;
}

}  // namespace

absl::Status ApplyViewFile(const std::string& path, v1::RenderRequest* request) {
  ASSIGN_OR_RETURN(const std::string text, ReadInputFile(path));
  const Json view = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (view.is_discarded()) return absl::InvalidArgumentError(absl::StrCat(path, ": is not JSON"));
  if (absl::Status status = ReadView(view, request); !status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", status.message()));
  }
  if (const auto scene = view.find("scene"); scene != view.end() && scene->is_string()) {
    const std::filesystem::path views = std::filesystem::absolute(path).lexically_normal().parent_path();
    request->set_scene((views.parent_path() / scene->get<std::string>()).string());
  }
  return absl::OkStatus();
}

}  // namespace halfshade
