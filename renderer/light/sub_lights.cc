#include "renderer/light/sub_lights.h"

#include <algorithm>
#include <cmath>

namespace halfshade {
namespace {

// The part of [-half, half] where height + slope x > 0.
LitPart CutLine(float half, float slope, float height, int axis) {
  float low = -half, high = half;
  if (slope > 0) low = std::clamp(-height / slope, -half, half);
  if (slope < 0) high = std::clamp(-height / slope, -half, half);
  if (slope == 0 && height <= 0) high = low;
  LitPart part;
  part.share = half > 0 ? (high - low) / (2 * half) : float(height > 0);
  part.middle[axis] = (low + high) / 2;
  part.half_edges[axis] = (high - low) / 2;
  return part;
}

}  // namespace

SubLights MakeSubLights(const AreaLight& light, int q) {
  const int columns = light.width_m > 0 ? q : 1;
  const int rows = light.height_m > 0 ? q : 1;
  SubLights cells;
  cells.half_edges = {light.width_m / (2 * columns), light.height_m / (2 * rows)};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      cells.centers.emplace_back((2 * column + 1 - columns) * cells.half_edges.x,
                                 (2 * row + 1 - rows) * cells.half_edges.y);
    }
  }
  return cells;
}

AreaLight SubLight(const AreaLight& light, const SubLights& cells, size_t index) {
  AreaLight cell = light;
  cell.width_m = 2 * cells.half_edges.x;
  cell.height_m = 2 * cells.half_edges.y;
  cell.center_ws += light.axis_u_ws * cells.centers[index].x + light.axis_v_ws * cells.centers[index].y;
  return cell;
}

LitPart CutCell(const glm::vec2& half_edges, const glm::vec2& normal, float height) {
  const float reach = std::abs(normal.x) * half_edges.x + std::abs(normal.y) * half_edges.y;
  if (height >= reach && height > 0) return {1, glm::vec2(0), half_edges};
  if (height <= -reach) return {};
  if (half_edges.y == 0) return CutLine(half_edges.x, normal.x, height, 0);
  if (half_edges.x == 0) return CutLine(half_edges.y, normal.y, height, 1);
  // Sutherland and Hodgman against one line, in units of the half edges; then moments of the polygon.
  const glm::vec2 slope = normal * half_edges;
  const glm::vec2 corners[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  glm::vec2 polygon[5];
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    const glm::vec2& a = corners[i];
    const glm::vec2& b = corners[(i + 1) % 4];
    const float height_a = height + glm::dot(slope, a);
    const float height_b = height + glm::dot(slope, b);
    if (height_a > 0) polygon[count++] = a;
    if ((height_a > 0) != (height_b > 0)) polygon[count++] = glm::mix(a, b, height_a / (height_a - height_b));
  }
  float area = 0;
  glm::vec2 first(0), second(0);
  for (int i = 1; i + 1 < count; ++i) {  // a fan of triangles
    const glm::vec2 &a = polygon[0], &b = polygon[i], &c = polygon[i + 1];
    const float twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    area += twice / 2;
    first += (a + b + c) * (twice / 6);
    second += (a * a + b * b + c * c + a * b + b * c + c * a) * (twice / 12);
  }
  if (!(area > 0)) return {};
  const glm::vec2 middle = first / area;
  const glm::vec2 variance = glm::max(second / area - middle * middle, glm::vec2(0));
  return {area / 4, middle * half_edges, glm::sqrt(3.0f * variance) * half_edges};
}

}  // namespace halfshade
