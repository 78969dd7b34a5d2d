// A log-log scatter plot as SVG. Pure.
#pragma once

#include <string>
#include <vector>

namespace halfshade::bench {

struct PlotPoint {
  double x = 1;       // > 0
  double y = 1;       // > 0
  std::string label;  // shown on hover
};

struct PlotSeries {
  std::string name;
  std::vector<PlotPoint> points;
  bool is_joined = false;  // by lines, in the order of x
};

struct Plot {
  std::string x_title, y_title;
  std::vector<PlotSeries> series;
  std::vector<PlotPoint> front;  // a stepped line under everything; may be empty
};

// An <svg> element of 560 x 360, wider where a name is long, with decades as grid lines. Points that are not > 0 are
// left out.
std::string ToSvg(const Plot& plot);

// Text for HTML: & < > " escaped.
std::string HtmlText(const std::string& text);

}  // namespace halfshade::bench
