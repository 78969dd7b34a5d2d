#include "client/bench/tables.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_replace.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/bench/fractions.h"

namespace halfshade::bench {
namespace {

std::string Quoted(const std::string& text) {
  return absl::StrCat("\"", absl::StrReplaceAll(text, {{"\"", "\"\""}}), "\"");
}

// Every figure by name; NaN: of an empty set.
std::vector<std::pair<const char*, double>> NamedFigures(const ImageError& error) {
  const auto value = [](const std::optional<double>& figure) {
    return figure.value_or(std::numeric_limits<double>::quiet_NaN());
  };
  return {{"mae_shadowed", value(error.mae_shadowed)},
          {"mae_penumbra", value(error.mae_penumbra)},
          {"mae_all", value(error.mae_all)},
          {"rmse_all", value(error.rmse_all)},
          {"psnr_all", value(error.psnr_all)},
          {"ssim_all", value(error.ssim_all)},
          {"p999", value(error.p999)},
          {"max", value(error.max)}};
}

// Cheapest first, failed ones last.
std::vector<const Row*> InOrder(const CaseResult& result) {
  std::vector<const Row*> rows;
  for (const Row& row : result.rows) rows.push_back(&row);
  std::stable_sort(rows.begin(), rows.end(), [](const Row* a, const Row* b) {
    if (a->failure.empty() != b->failure.empty()) return a->failure.empty();
    return a->shadow_cpu_ms < b->shadow_cpu_ms;
  });
  return rows;
}

nlohmann::ordered_json ToJson(const Row& row) {
  nlohmann::ordered_json json = {{"method", row.setting.method}, {"options", row.setting.label}};
  if (!row.failure.empty()) {
    json["failure"] = row.failure;
    return json;
  }
  for (const auto& [name, value] : NamedFigures(row.error)) json[name] = value;
  json.update({{"shadow_cpu_ms", row.shadow_cpu_ms},
               {"cpu_ms", row.cpu_ms},
               {"wall_ms", row.wall_ms},
               {"light_ms", row.light_ms},
               {"resolve_ms", row.resolve_ms},
               {"warm_cpu_ms", row.warm_cpu_ms},
               {"light_data_bytes", row.light_data_bytes},
               {"predicted", row.predicted},
               {"steps_wall_ms", nlohmann::ordered_json(row.steps)},
               {"on_front", row.is_on_front},
               {"skipped", row.skipped}});
  return json;
}

nlohmann::ordered_json ToJson(const SequenceResult& sequence) {
  nlohmann::ordered_json json = {{"name", sequence.name}};
  if (!sequence.failure.empty()) {
    json["failure"] = sequence.failure;
    return json;
  }
  json.update({{"first_ms", sequence.first_ms},
               {"later_ms", sequence.later_ms},
               {"first_cpu_ms", sequence.first_cpu_ms},
               {"later_cpu_ms", sequence.later_cpu_ms},
               {"mae_shadowed", sequence.error},
               {"predicted", sequence.predicted}});
  if (sequence.lit_tiles) json["lit_tiles"] = *sequence.lit_tiles;
  for (const Skip& skip : sequence.skips) {
    json["skips"].push_back({{"pass", skip.pass}, {"reason", skip.reason}, {"share", skip.share}});
    if (skip.saved_ms) json["skips"].back()["saved_ms"] = *skip.saved_ms;
  }
  return json;
}

// "0.12 (0.10)", or why there is none; misses stand between asterisks.
std::string FractionText(const Fraction& fraction) {
  const std::string text = fraction.own.empty()     ? "not reached"
                           : fraction.rival.empty() ? "alone"
                                                    : absl::StrFormat("%.2f (%.2f)", fraction.whole, fraction.shadow);
  return fraction.IsMissed() ? absl::StrCat("**", text, "**") : text;
}

std::string FractionsToTable(const Results& results) {
  std::string text = absl::StrFormat(
      "\n%s, CPU time of its cheapest setting beside that of the cheapest rival at equal mae_shadowed: with primary\n"
      "visibility (and without); ** over the aim; in brackets: its setting, the rival\n",
      results.judged);
  constexpr double kRegret = 1.25;
  int cells = 0, missed = 0, beside = 0, calm = 0, singles = 0, near_single = 0;
  std::string regrets;
  for (const CaseResult& result : results.cases) {
    absl::StrAppendFormat(&text, "  %-22s", absl::StrCat(result.name, result.is_dense ? " dense" : ""));
    for (const Fraction& fraction : FractionsOf(result, results.judged)) {
      absl::StrAppendFormat(&text, " %g: %-17s [%s, %s]", fraction.error, FractionText(fraction), fraction.own,
                            fraction.rival);
      ++cells;
      missed += fraction.IsMissed() ? 1 : 0;
      if (fraction.whole > 0) {
        ++beside;
        calm += fraction.p999 <= 1 ? 1 : 0;
      }
      if (fraction.of_single == 0) continue;
      ++singles;
      near_single += fraction.of_single <= kRegret ? 1 : 0;
      if (fraction.of_single > kRegret) {
        absl::StrAppendFormat(&regrets, "    %s, %g: %.2f of %s\n", result.name, fraction.error, fraction.of_single,
                              fraction.single);
      }
    }
    text += "\n";
  }
  absl::StrAppendFormat(&text, "  over the aim in %d of %d cells; p999 no worse than the rival's in %d of %d\n", missed,
                        cells, calm, beside);
  if (singles > 0) {
    absl::StrAppendFormat(&text, "  at most %g of the cheapest of our other methods in %d of %d cells; not in\n%s",
                          kRegret, near_single, singles, regrets);
  }
  int within = 0, told = 0, kept = 0, budgets = 0;
  for (const CaseResult& result : results.cases) {
    for (const Row& row : result.rows) {
      const double error = row.error.mae_shadowed.value_or(0);
      if (!row.failure.empty() || row.setting.method != results.judged) continue;
      budgets += row.setting.max_error > 0 ? 1 : 0;
      kept += row.setting.max_error > 0 && error <= row.setting.max_error ? 1 : 0;
      if (row.predicted == 0 || error == 0) continue;
      ++told;
      within += row.predicted <= 2 * error && row.predicted >= error / 2 ? 1 : 0;
    }
  }
  absl::StrAppendFormat(&text, "  predicted error within 2x of the true one in %d of %d cells\n", within, told);
  if (budgets > 0) absl::StrAppendFormat(&text, "  error within the budget in %d of %d cells\n", kept, budgets);
  return text;
}

}  // namespace

std::string ToTable(const Results& results) {
  std::string text;
  for (const auto& [name, value] : results.head) absl::StrAppendFormat(&text, "%-12s %s\n", name, value);
  for (const CaseResult& result : results.cases) {
    absl::StrAppendFormat(&text,
                          "\n%s: primary visibility %.1f CPU-ms; reference noise %.5f\n"
                          "  %-10s %-44s %9s %9s %8s %9s %8s %8s %7s %6s %6s\n",
                          result.name, result.primary_cpu_ms, result.reference_noise, "method", "options", "shadow",
                          "warm", "wall", "mae_shad.", "mae_pen.", "p999", "max", "psnr", "ssim");
    for (const Row* row : InOrder(result)) {
      if (!row->failure.empty()) {
        absl::StrAppendFormat(&text, "  %-10s %-44s %s\n", row->setting.method, row->setting.label, row->failure);
        continue;
      }
      absl::StrAppendFormat(
          &text, "%s %-10s %-44s %9.1f %9.1f %8.1f %9.5f %8.5f %8.4f %7.4f %6.2f %6.4f\n", row->is_on_front ? "*" : " ",
          row->setting.method, row->setting.label, row->shadow_cpu_ms, row->warm_cpu_ms, row->wall_ms,
          row->error.mae_shadowed.value_or(0), row->error.mae_penumbra.value_or(0), row->error.p999.value_or(0),
          row->error.max.value_or(0), row->error.psnr_all.value_or(0), row->error.ssim_all.value_or(0));
      if (row->steps.empty()) continue;
      absl::StrAppendFormat(&text, "    light_data %.1f", row->light_ms);
      for (const auto& [name, ms] : row->steps) absl::StrAppendFormat(&text, ", %s %.1f", name, ms);
      text += " (wall ms)\n";
    }
  }
  for (const Curve& curve : results.curves) {
    absl::StrAppendFormat(&text, "\n%s, %s %s: ", curve.work, curve.setting.method, curve.setting.label);
    if (!curve.failure.empty()) {
      absl::StrAppend(&text, curve.failure);
      continue;
    }
    for (size_t i = 0; i < curve.x.size(); ++i) {
      absl::StrAppendFormat(&text, "%g: %.1f ms", curve.x[i], curve.cpu_ms[i]);
      if (!curve.mae_shadowed.empty()) absl::StrAppendFormat(&text, " at %.5f", curve.mae_shadowed[i]);
      text += ", ";
    }
    absl::StrAppendFormat(&text, "exponent %.2f", curve.exponent);
    if (curve.work != "triangles" || curve.light_bytes.empty()) continue;
    const auto append_each = [&](const char* of_what, const std::vector<double>& bytes, const std::vector<double>& ms) {
      absl::StrAppend(&text, "; ", of_what, ", bytes and wall us a triangle:");
      for (size_t i = 0; i < curve.x.size(); ++i) {
        absl::StrAppendFormat(&text, " %.0f %.2f", bytes[i] / curve.x[i], 1e3 * ms[i] / curve.x[i]);
      }
    };
    append_each("light data", curve.light_bytes, curve.light_ms);
    append_each("kept of the scene", curve.scene_bytes, curve.scene_ms);
  }
  text += "\n";
  if (!results.judged.empty()) text += FractionsToTable(results);
  return text + ToTable(results.sequences, results.replies);
}

std::string ToCsv(const Results& results) {
  std::string text = "case,method,options,failure,shadow_cpu_ms,cpu_ms,wall_ms,light_ms,resolve_ms,warm_cpu_ms";
  for (const auto& [name, value] : NamedFigures(ImageError())) absl::StrAppend(&text, ",", name);
  text += ",reference_noise,on_front\n";
  for (const CaseResult& result : results.cases) {
    for (const Row& row : result.rows) {
      absl::StrAppend(&text, Quoted(result.name), ",", row.setting.method, ",", Quoted(row.setting.label), ",",
                      Quoted(row.failure));
      absl::StrAppendFormat(&text, ",%.3f,%.3f,%.3f,%.3f,%.3f,%.3f", row.shadow_cpu_ms, row.cpu_ms, row.wall_ms,
                            row.light_ms, row.resolve_ms, row.warm_cpu_ms);
      for (const auto& [name, value] : NamedFigures(row.error)) absl::StrAppendFormat(&text, ",%.8g", value);
      absl::StrAppendFormat(&text, ",%.8g,%d\n", result.reference_noise, row.is_on_front);
    }
  }
  return text;
}

std::string ToJsonText(const Results& results) {
  nlohmann::ordered_json json;
  for (const auto& [name, value] : results.head) json["head"][name] = value;
  json["cases"] = nlohmann::ordered_json::array();
  for (const CaseResult& result : results.cases) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Row& row : result.rows) rows.push_back(ToJson(row));
    json["cases"].push_back({{"name", result.name},
                             {"primary_cpu_ms", result.primary_cpu_ms},
                             {"reference_noise", result.reference_noise},
                             {"reference_cpu_ms", result.reference_cpu_ms},
                             {"rows", rows}});
    if (results.judged.empty()) continue;
    for (const Fraction& fraction : FractionsOf(result, results.judged)) {
      json["cases"].back()["fractions"].push_back({{"error", fraction.error},
                                                   {"own", fraction.own},
                                                   {"rival", fraction.rival},
                                                   {"whole", fraction.whole},
                                                   {"shadow", fraction.shadow},
                                                   {"p999", fraction.p999},
                                                   {"single", fraction.single},
                                                   {"of_single", fraction.of_single},
                                                   {"aim", fraction.aim},
                                                   {"missed", fraction.IsMissed()}});
    }
  }
  json["curves"] = nlohmann::ordered_json::array();
  for (const Curve& curve : results.curves) {
    json["curves"].push_back({{"work", curve.work},
                              {"method", curve.setting.method},
                              {"options", curve.setting.label},
                              {"failure", curve.failure},
                              {"x", curve.x},
                              {"shadow_cpu_ms", curve.cpu_ms},
                              {"light_ms", curve.light_ms},
                              {"light_data_bytes", curve.light_bytes},
                              {"scene_data_ms", curve.scene_ms},
                              {"scene_data_bytes", curve.scene_bytes},
                              {"exponent", curve.exponent},
                              {"mae_shadowed", curve.mae_shadowed}});
  }
  for (const SequenceResult& sequence : results.sequences) json["sequences"].push_back(ToJson(sequence));
  for (const ReplyTimes& times : results.replies) {
    json["replies"].push_back({{"name", times.name},
                               {"plan_ms", times.plan_ms},
                               {"repeated_ms", times.repeated_ms},
                               {"first_image_ms", times.first_image_ms},
                               {"whole_ms", times.whole_ms}});
  }
  return json.dump(2) + "\n";
}

}  // namespace halfshade::bench
