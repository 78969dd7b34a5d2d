// halfshade query
#include <absl/strings/str_cat.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "client/points_file.h"
#include "client/session.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

// [point][light].
std::vector<std::vector<float>> Unpack(const v1::QueryVisibilityResponse& response, size_t points) {
  const size_t lights = response.visibility().size() / sizeof(float) / points;
  std::vector<std::vector<float>> values(points, std::vector<float>(lights));
  for (size_t i = 0; i < points; ++i) {
    std::memcpy(values[i].data(), response.visibility().data() + i * lights * sizeof(float), lights * sizeof(float));
  }
  return values;
}

}  // namespace

absl::Status RunQuery(const GlobalFlags& global, const RenderFlags& flags, const std::string& points_file) {
  ASSIGN_OR_RETURN(const PreparedRender job, PrepareRender(flags));
  ASSIGN_OR_RETURN(PackedPoints packed, ReadPointsFile(points_file));
  const size_t points = packed.points.size() / (3 * sizeof(float));
  v1::QueryVisibilityRequest query;
  *query.mutable_request() = job.request;
  query.set_points(std::move(packed.points));
  query.set_normals(std::move(packed.normals));
  ASSIGN_OR_RETURN(const std::unique_ptr<SceneFiles> files, TakeSceneFiles(query.mutable_request()));
  ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(global));
  ASSIGN_OR_RETURN(const v1::QueryVisibilityResponse response, session->client().QueryVisibility(query, files.get()));
  const std::vector<std::vector<float>> values = Unpack(response, points);
  if (global.wants_json) {
    nlohmann::ordered_json json;
    json["visibility"] = values;
    json["report"] = nlohmann::ordered_json::parse(ToJson(response.report(), /*with_defaults=*/true));
    return Print(json.dump(1) + "\n");
  }
  std::string text;
  for (const std::vector<float>& of_point : values) {
    for (size_t light = 0; light < of_point.size(); ++light) {
      absl::StrAppend(&text, light > 0 ? "," : "", of_point[light]);
    }
    text += '\n';
  }
  return Print(text);
}

}  // namespace halfshade
