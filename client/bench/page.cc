#include "client/bench/page.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>

#include "client/bench/plot.h"
#include "renderer/status.h"
#include "server/encode.h"

namespace halfshade::bench {
namespace {

// Differences of this size are drawn in full color.
constexpr float kFullDifference = 0.1f;
constexpr int kThumbnailWidth = 320;

constexpr char kStyle[] =
    "body{font:14px sans-serif;margin:24px;max-width:1240px}table{border-collapse:collapse;font-size:12px}"
    "td,th{padding:2px 8px;text-align:right;border-bottom:1px solid #eee}td.l,th.l{text-align:left}"
    "tr.front td{font-weight:bold}tr.failed td{color:#b00}figure{display:inline-block;margin:4px;vertical-align:top}"
    "figcaption{font-size:11px;max-width:320px}section{border-top:1px solid #ccc;margin-top:24px}";

std::string Picture(const std::string& png, const std::string& caption) {
  return absl::StrFormat(
      "<figure><img width='%d' alt='%s' src='data:image/png;base64,%s'><figcaption>%s</figcaption></figure>",
      kThumbnailWidth, HtmlText(caption), absl::Base64Escape(png), HtmlText(caption));
}

absl::StatusOr<std::string> ToPng(OutputKind kind, Image image) {
  ASSIGN_OR_RETURN(const OutputFormat format, FormatOf(kind, Encoding::kPng, 1, /*has_alpha=*/false));
  std::vector<RenderedImage> images;
  images.push_back({kind, std::move(image)});
  ASSIGN_OR_RETURN(std::vector<EncodedOutput> encoded,
                   Encode(std::move(images), {format}, [] { return absl::OkStatus(); }));
  return std::move(encoded[0].bytes);
}

// Red: darker than the reference; blue: brighter; white: equal.
absl::StatusOr<std::string> DifferencePng(const Image& difference) {
  Image colors(difference.width(), difference.height(), 4);
  for (int y = 0; y < difference.height(); ++y) {
    for (int x = 0; x < difference.width(); ++x) {
      const float share = std::clamp(difference.at(x, y, 0) / kFullDifference, -1.0f, 1.0f);
      colors.at(x, y, 0) = share > 0 ? 1 - share : 1;
      colors.at(x, y, 1) = 1 - std::abs(share);
      colors.at(x, y, 2) = share < 0 ? 1 + share : 1;
      colors.at(x, y, 3) = 1;
    }
  }
  return ToPng(OutputKind::kFrame, std::move(colors));
}

std::string Name(const Setting& setting) { return absl::StrCat(setting.method, " ", setting.label); }

std::string ErrorPlot(const CaseResult& result) {
  Plot plot;
  plot.x_title = "shadow cost, CPU-ms of all threads";
  plot.y_title = "mean |dv| over shadowed pixels";
  std::map<std::string, PlotSeries> by_method;
  for (const Row& row : result.rows) {
    if (!row.failure.empty()) continue;
    const PlotPoint point = {
        row.shadow_cpu_ms, row.error.mae_shadowed.value_or(0),
        absl::StrFormat("%s: %.1f ms, %.5f", Name(row.setting), row.shadow_cpu_ms, row.error.mae_shadowed.value_or(0))};
    PlotSeries& series = by_method[row.setting.method];
    series.name = row.setting.method;
    series.points.push_back(point);
    if (row.is_on_front) plot.front.push_back(point);
  }
  for (auto& [method, series] : by_method) plot.series.push_back(std::move(series));
  std::sort(plot.front.begin(), plot.front.end(), [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
  return ToSvg(plot);
}

std::string RowsTable(const CaseResult& result) {
  std::string html =
      "<table><tr><th class=l>method<th class=l>options<th>shadow CPU-ms<th>warm CPU-ms<th>wall ms<th>mae shadowed"
      "<th>mae penumbra<th>p999<th>max<th class=l>skipped</tr>";
  for (const Row& row : result.rows) {
    if (!row.failure.empty()) {
      absl::StrAppend(&html, "<tr class=failed><td class=l>", row.setting.method, "<td class=l>",
                      HtmlText(row.setting.label), "<td class=l colspan=8>", HtmlText(row.failure), "</tr>");
      continue;
    }
    absl::StrAppendFormat(&html,
                          "<tr%s><td class=l>%s<td class=l>%s<td>%.1f<td>%.1f<td>%.1f<td>%.5f<td>%.5f<td>%.4f<td>%.4f"
                          "<td class=l>%d</tr>",
                          row.is_on_front ? " class=front" : "", row.setting.method, HtmlText(row.setting.label),
                          row.shadow_cpu_ms, row.warm_cpu_ms, row.wall_ms, row.error.mae_shadowed.value_or(0),
                          row.error.mae_penumbra.value_or(0), row.error.p999.value_or(0), row.error.max.value_or(0),
                          row.skipped.size());
  }
  return html + "</table>";
}

absl::StatusOr<std::string> CaseSection(const CaseResult& result) {
  std::string html = absl::StrFormat(
      "<section><h2>%s</h2><p>Primary visibility %.1f CPU-ms, not in the costs below; noise of the "
      "reference %.5f.</p>%s",
      HtmlText(result.name), result.primary_cpu_ms, result.reference_noise, ErrorPlot(result));
  absl::StrAppend(&html, Picture(result.frame_png, "the frame"));
  ASSIGN_OR_RETURN(const std::string reference, ToPng(OutputKind::kVisibility, result.reference));
  absl::StrAppend(&html, Picture(reference, "visibility, reference"));
  std::map<std::string, const Row*> worst;
  for (const Row& row : result.rows) {
    if (!row.failure.empty()) continue;
    const Row*& held = worst[row.setting.method];
    if (held == nullptr || row.error.mae_shadowed.value_or(0) > held->error.mae_shadowed.value_or(0)) held = &row;
  }
  for (const auto& [method, row] : worst) {
    ASSIGN_OR_RETURN(const std::string png, DifferencePng(row->difference));
    absl::StrAppend(&html, Picture(png, absl::StrFormat("%s: red too dark, blue too bright, full at %g",
                                                        Name(row->setting), kFullDifference)));
  }
  return absl::StrCat(html, RowsTable(result), "</section>");
}

// A joined line of one figure of a curve, into the plot of its work.
void AddLine(const Curve& curve, const std::string& name, const std::vector<double>& figures, const char* figure,
             const char* unit, Plot* plot) {
  plot->x_title = curve.work;
  plot->y_title = figure;
  PlotSeries& series = plot->series.emplace_back();
  series.name = name;
  series.is_joined = true;
  for (size_t i = 0; i < figures.size(); ++i) {
    series.points.push_back(
        {curve.x[i], figures[i], absl::StrFormat("%s: %g, %.4g%s", Name(curve.setting), curve.x[i], figures[i], unit)});
  }
}

std::string CurvesSection(const std::vector<Curve>& curves) {
  std::map<std::string, Plot> costs, errors;
  std::map<std::pair<std::string, std::string>, int> lines;  // of a work and a method
  for (const Curve& curve : curves) ++lines[{curve.work, curve.setting.method}];
  std::string html =
      "<section><h2>Cost and error against work</h2><table><tr><th class=l>work<th class=l>method<th>exponent</tr>";
  for (const Curve& curve : curves) {
    absl::StrAppend(&html, "<tr", curve.failure.empty() ? "" : " class=failed", "><td class=l>", HtmlText(curve.work),
                    "<td class=l>", HtmlText(Name(curve.setting)), "<td>",
                    curve.failure.empty() ? absl::StrFormat("%.2f", curve.exponent) : HtmlText(curve.failure), "</tr>");
    if (!curve.failure.empty()) continue;
    const bool is_alone = lines[{curve.work, curve.setting.method}] == 1;
    const std::string name = is_alone ? curve.setting.method : Name(curve.setting);
    AddLine(curve, name, curve.cpu_ms, "shadow cost, CPU-ms of all threads", " ms", &costs[curve.work]);
    if (curve.mae_shadowed.empty()) continue;
    AddLine(curve, name, curve.mae_shadowed, "mean |error| over shadowed pixels", "", &errors[curve.work]);
  }
  html += "</table>";
  for (const auto& [work, plot] : costs) {
    absl::StrAppend(&html, ToSvg(plot));
    if (errors.contains(work)) absl::StrAppend(&html, ToSvg(errors[work]));
  }
  return html + "</section>";
}

}  // namespace

absl::StatusOr<std::string> ToHtml(const Results& results) {
  std::string html =
      absl::StrCat("<!doctype html><html lang=en><meta charset=utf-8><title>Halfshade bench</title><style>", kStyle,
                   "</style><h1>Error against time</h1><table>");
  for (const auto& [name, value] : results.head) {
    absl::StrAppend(&html, "<tr><td class=l>", HtmlText(name), "<td class=l>", HtmlText(value), "</tr>");
  }
  html += "</table><p>Bold rows, and the grey line in each plot: no other setting is both cheaper and more exact.</p>";
  for (const CaseResult& result : results.cases) {
    ASSIGN_OR_RETURN(const std::string section, CaseSection(result));
    html += section;
  }
  if (!results.curves.empty()) html += CurvesSection(results.curves);
  return html + "</html>\n";
}

}  // namespace halfshade::bench
