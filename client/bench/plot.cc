#include "client/bench/plot.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_replace.h>

#include <algorithm>
#include <cmath>

namespace halfshade::bench {
namespace {

constexpr double kWidth = 560, kHeight = 360;
constexpr double kLeft = 64, kRight = 130, kTop = 12, kBottom = 44;
constexpr double kLetter = 6;           // about, across
constexpr size_t kLettersInRight = 16;  // of a name; a longer one makes the picture wider
// Distinct on white, also for the color-blind (Okabe and Ito 2008).
constexpr const char* kColors[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#e69f00", "#56b4e9", "#000000", "#999933"};

bool CanBeDrawn(const PlotPoint& point) { return point.x > 0 && point.y > 0; }

// Decades that hold all values.
struct Axis {
  int low = 0, high = 1;
  double from = 0, to = 1;  // pixels
  void Fit(const std::vector<double>& values) {
    if (values.empty()) return;
    low = int(std::floor(std::log10(*std::min_element(values.begin(), values.end()))));
    high = std::max(low + 1, int(std::ceil(std::log10(*std::max_element(values.begin(), values.end())))));
  }
  double At(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

std::string Line(double x1, double y1, double x2, double y2, const char* style) {
  return absl::StrFormat("<line x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f' style='%s'/>", x1, y1, x2, y2, style);
}

std::string Text(double x, double y, const char* anchor, const std::string& text, const std::string& more = "") {
  return absl::StrFormat("<text x='%.1f' y='%.1f' text-anchor='%s' %s>%s</text>", x, y, anchor, more, HtmlText(text));
}

}  // namespace

std::string HtmlText(const std::string& text) {
  return absl::StrReplaceAll(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}});
}

std::string ToSvg(const Plot& plot) {
  std::vector<double> all_x, all_y;
  for (const PlotSeries& series : plot.series) {
    for (const PlotPoint& point : series.points) {
      if (!CanBeDrawn(point)) continue;
      all_x.push_back(point.x);
      all_y.push_back(point.y);
    }
  }
  Axis x{.from = kLeft, .to = kWidth - kRight};
  Axis y{.from = kHeight - kBottom, .to = kTop};
  x.Fit(all_x);
  y.Fit(all_y);
  size_t letters = kLettersInRight;
  for (const PlotSeries& series : plot.series) letters = std::max(letters, series.name.size());
  const double width = kWidth + kLetter * double(letters - kLettersInRight);
  std::string svg =
      absl::StrFormat("<svg viewBox='0 0 %g %g' width='%g' height='%g' font-family='sans-serif' font-size='11'>", width,
                      kHeight, width, kHeight);
  for (int decade = x.low; decade <= x.high; ++decade) {
    const double at = x.At(std::pow(10.0, decade));
    svg += Line(at, kTop, at, kHeight - kBottom, "stroke:#ddd");
    svg += Text(at, kHeight - kBottom + 14, "middle", absl::StrFormat("%g", std::pow(10.0, decade)));
  }
  for (int decade = y.low; decade <= y.high; ++decade) {
    const double at = y.At(std::pow(10.0, decade));
    svg += Line(kLeft, at, kWidth - kRight, at, "stroke:#ddd");
    svg += Text(kLeft - 6, at + 4, "end", absl::StrFormat("%g", std::pow(10.0, decade)));
  }
  svg += Text((kLeft + kWidth - kRight) / 2, kHeight - 10, "middle", plot.x_title);
  svg += Text(14, kHeight / 2, "middle", plot.y_title, absl::StrFormat("transform='rotate(-90 14 %g)'", kHeight / 2));
  std::string path;
  for (size_t i = 0; i < plot.front.size(); ++i) {
    if (!CanBeDrawn(plot.front[i])) continue;
    const double across = x.At(plot.front[i].x);
    const double down = y.At(plot.front[i].y);
    if (path.empty()) {
      absl::StrAppendFormat(&path, "M%.1f %.1f", across, down);
    } else {
      absl::StrAppendFormat(&path, "H%.1fV%.1f", across, down);
    }
  }
  if (!path.empty()) {
    absl::StrAppend(&svg, "<path d='", path, "' fill='none' stroke='#999' stroke-width='5' stroke-opacity='.4'/>");
  }
  for (size_t s = 0; s < plot.series.size(); ++s) {
    const PlotSeries& series = plot.series[s];
    const char* color = kColors[s % std::size(kColors)];
    std::string line;
    for (const PlotPoint& point : series.points) {
      if (!CanBeDrawn(point)) continue;
      absl::StrAppendFormat(&line, "%s%.1f %.1f", line.empty() ? "M" : "L", x.At(point.x), y.At(point.y));
      absl::StrAppendFormat(&svg, "<circle cx='%.1f' cy='%.1f' r='4' fill='%s'><title>%s</title></circle>",
                            x.At(point.x), y.At(point.y), color, HtmlText(point.label));
    }
    if (series.is_joined) absl::StrAppend(&svg, "<path d='", line, "' fill='none' stroke='", color, "'/>");
    const double row = kTop + 10 + 16 * double(s);
    absl::StrAppendFormat(&svg, "<circle cx='%.1f' cy='%.1f' r='4' fill='%s'/>", kWidth - kRight + 14, row, color);
    svg += Text(kWidth - kRight + 24, row + 4, "start", series.name);
  }
  return svg + "</svg>";
}

}  // namespace halfshade::bench
