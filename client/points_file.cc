#include "client/points_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <bit>
#include <vector>

#include "client/input_file.h"
#include "renderer/status.h"

namespace halfshade {
namespace {

static_assert(std::endian::native == std::endian::little, "floats go to the wire as they are");

absl::Status LineError(const std::string& path, int line, const std::string& fault) {
  return absl::InvalidArgumentError(absl::StrCat(path, ":", line, ": ", fault));
}

void Append(std::string* packed, const float* values) {
  packed->append(reinterpret_cast<const char*>(values), 3 * sizeof(float));
}

}  // namespace

absl::StatusOr<PackedPoints> ReadPointsFile(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadInputFile(path));
  PackedPoints packed;
  size_t columns = 0;
  int line_number = 0;
  bool may_be_names = true;
  for (const std::string& raw : std::vector<std::string>(absl::StrSplit(text, '\n'))) {
    ++line_number;
    const std::string line(absl::StripAsciiWhitespace(raw));
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> cells = absl::StrSplit(line, ',');
    std::vector<float> values;
    for (const std::string& cell : cells) {
      float value = 0;
      if (absl::SimpleAtof(absl::StripAsciiWhitespace(cell), &value)) values.push_back(value);
    }
    const bool are_names = may_be_names && values.empty();
    may_be_names = false;
    if (are_names) continue;
    if (values.size() != cells.size()) return LineError(path, line_number, "not numbers: '" + line.substr(0, 80) + "'");
    if (cells.size() != 3 && cells.size() != 6) {
      return LineError(path, line_number, absl::StrCat(cells.size(), " values; must be x,y,z or x,y,z,nx,ny,nz"));
    }
    if (columns != 0 && cells.size() != columns) {
      return LineError(path, line_number, absl::StrCat(cells.size(), " values; the lines before have ", columns));
    }
    columns = cells.size();
    Append(&packed.points, values.data());
    if (columns == 6) Append(&packed.normals, values.data() + 3);
  }
  if (packed.points.empty()) return absl::InvalidArgumentError(path + ": no points");
  return packed;
}

}  // namespace halfshade
