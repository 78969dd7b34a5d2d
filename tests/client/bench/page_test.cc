#include "client/bench/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "client/bench/plot.h"
#include "tests/support/status_matchers.h"

namespace halfshade::bench {
namespace {

using testing::HasSubstr;
using testing::Not;

Results Made() {
  Row good;
  good.setting = {.method = "multi_map", .label = "k=4", .options = {}, .family = "multi_map"};
  good.cpu_ms = 12;
  good.shadow_cpu_ms = 10;
  good.error.mae_shadowed = 0.02;
  good.is_on_front = true;
  good.difference = Image(2, 2, 1);
  Row bad;
  bad.setting = {.method = "pcss", .label = "taps=\"7\"", .options = {}, .family = "pcss"};
  bad.failure = "INTERNAL: <broken>";
  CaseResult result;
  result.name = "S1 & light";
  result.primary_cpu_ms = 2;
  result.reference = Image(2, 2, 1);
  result.rows = {bad, good};
  Curve curve;
  curve.work = "pixels";
  curve.setting = good.setting;
  curve.x = {10, 100};
  curve.cpu_ms = {1, 10};
  curve.exponent = 1;
  curve.mae_shadowed = {0.03, 0.02};
  return {{{"cpu", "a \"fast\" one"}}, {result}, {curve}, ""};
}

TEST(TablesTest, WhatIsOverTheAimStandsBetweenAsterisks) {
  Results results = Made();
  Row own = results.cases[0].rows[1];
  own.setting.method = "shaft";
  own.cpu_ms = 4;
  own.shadow_cpu_ms = 2;
  own.predicted = 0.039;
  results.cases[0].rows.push_back(own);
  own.predicted = 0.041;
  own.cpu_ms = 5;
  results.cases[0].rows.push_back(own);
  EXPECT_THAT(ToTable(results), Not(HasSubstr("cheapest rival")));
  results.judged = "shaft";
  EXPECT_THAT(ToTable(results), HasSubstr("0.03: 0.33 (0.20)"));
  EXPECT_THAT(ToTable(results), HasSubstr("0.01: **not reached**"));
  EXPECT_THAT(ToTable(results), HasSubstr("within 2x of the true one in 1 of 2 cells"));
  EXPECT_EQ(nlohmann::json::parse(ToJsonText(results))["cases"][0]["fractions"][0]["rival"], "multi_map");
}

TEST(TablesTest, ACurveOfTrianglesTellsLightDataOfEach) {
  Results results = Made();
  Curve& curve = results.curves[0];
  curve.light_ms = {0.02, 0.1};
  curve.light_bytes = {1000, 12000};
  curve.scene_ms = {0.05, 0.3};
  curve.scene_bytes = {500, 7000};
  EXPECT_THAT(ToTable(results), Not(HasSubstr("a triangle")));
  curve.work = "triangles";
  EXPECT_THAT(ToTable(results), HasSubstr("light data, bytes and wall us a triangle: 100 2.00 120 1.00"));
  EXPECT_THAT(ToTable(results), HasSubstr("kept of the scene, bytes and wall us a triangle: 50 5.00 70 3.00"));
  EXPECT_EQ(nlohmann::json::parse(ToJsonText(results))["curves"][0]["light_data_bytes"][1], 12000);
}

TEST(PageTest, ShowsFailuresFrontsAndCurvesAndEscapesText) {
  const auto html = ToHtml(Made());
  ASSERT_OK(html);
  EXPECT_THAT(*html, HasSubstr("INTERNAL: &lt;broken&gt;"));
  EXPECT_THAT(*html, HasSubstr("S1 &amp; light"));
  EXPECT_THAT(*html, HasSubstr("<tr class=front><td class=l>multi_map"));
  EXPECT_THAT(*html, HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(*html, HasSubstr("<td>1.00</tr>"));
  EXPECT_THAT(*html, Not(HasSubstr("http")));  // self-contained
}

TEST(TablesTest, AFailedSettingIsARowInEveryForm) {
  EXPECT_THAT(ToTable(Made()), HasSubstr("INTERNAL: <broken>"));
  EXPECT_THAT(ToCsv(Made()), HasSubstr("\"S1 & light\",pcss,\"taps=\"\"7\"\"\",\"INTERNAL: <broken>\""));
  const auto json = nlohmann::json::parse(ToJsonText(Made()));
  EXPECT_EQ(json["cases"][0]["rows"][0]["failure"], "INTERNAL: <broken>");
  EXPECT_EQ(json["cases"][0]["rows"][1]["mae_shadowed"], 0.02);
  EXPECT_EQ(json["curves"][0]["exponent"], 1);
  EXPECT_EQ(json["curves"][0]["mae_shadowed"][1], 0.02);
  EXPECT_THAT(ToTable(Made()), HasSubstr("10: 1.0 ms at 0.03000, 100: 10.0 ms at 0.02000, exponent 1.00"));
}

TEST(TablesTest, EveryLineOfTheCsvHasAsManyFieldsAsItsHeader) {
  const std::string csv = ToCsv(Made());
  const std::string header = csv.substr(0, csv.find('\n'));
  const std::string last = csv.substr(csv.rfind('\n', csv.size() - 2) + 1);
  EXPECT_EQ(std::count(last.begin(), last.end(), ','), std::count(header.begin(), header.end(), ','));
}

TEST(PageTest, CurvesOfOneMethodAreToldApartByTheirOptions) {
  Results results = Made();
  results.curves.push_back(results.curves[0]);
  results.curves[1].setting.label = "k=16 map_size=512";
  const auto html = ToHtml(results);
  ASSERT_OK(html);
  EXPECT_THAT(*html, HasSubstr(">multi_map k=4</text>"));
  EXPECT_THAT(*html, HasSubstr(">multi_map k=16 map_size=512</text>"));
  EXPECT_THAT(*html, HasSubstr("width='626'")) << "27 letters are 11 more than fit";
  results.curves.pop_back();
  EXPECT_THAT(*ToHtml(results), HasSubstr(">multi_map</text>"));
}

TEST(PlotTest, PutsADecadeAtItsPlaceAndLeavesOutWhatHasNoLogarithm) {
  Plot plot;
  plot.series = {{"a", {{1, 0.01, "one"}, {100, 1, "two"}, {0, 1, "none"}}, true}};
  const std::string svg = ToSvg(plot);
  // The plot's area is x 64..430, y 316 (low) to 12 (high).
  EXPECT_THAT(svg, HasSubstr("<circle cx='64.0' cy='316.0'"));
  EXPECT_THAT(svg, HasSubstr("<circle cx='430.0' cy='12.0'"));
  EXPECT_THAT(svg, Not(HasSubstr("none</title>")));
}

}  // namespace
}  // namespace halfshade::bench
