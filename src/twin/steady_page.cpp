#include "twin/steady_page.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/plot.h"
#include "twin/json_parts.h"
#include "twin/page.h"

namespace wheel_twin::twin {
namespace {

using Json = nlohmann::ordered_json;

Json values_json(const SteadyRow::Value& v) {
  return {{"measured", number_json(v.measured)},
          {"declared", number_json(v.declared)},
          {"before", number_json(v.before)},
          {"after", number_json(v.after)},
          {"left_out", number_json(v.left_out)}};
}

std::string shown(Channel channel, double value) {
  return std::isfinite(value) ? fmt::format("{:.2f}", shown_factor(channel) * value) : "";
}

std::string error_rows(const SteadyReport& report) {
  std::string rows;
  const auto add = [&](const Errors& errors, const std::string& what, const auto& constant) {
    for (const auto& [channel, e] : errors)
      rows += page::row({fmt::format("{}, {}", title_of(channel), what), shown(channel, e.before),
                         shown(channel, e.after), shown(channel, e.noise_floor), constant(channel),
                         std::string(shown_unit_of(channel))});
  };
  add(report.left_out, "all slips", [](Channel) { return std::string(); });
  add(report.left_out_driving, "slips above 0.05", [&](Channel channel) {
    const auto c = report.constant_driving.find(channel);
    return c == report.constant_driving.end() ? std::string() : shown(channel, c->second);
  });
  return rows;
}

std::string slip_plot(const SteadyReport& report, Channel channel) {
  PlotSeries measured{"measured", {}, {}, PlotSeries::Style::points, 0},
      declared{"twin as declared", {}, {}, PlotSeries::Style::points, 3},
      before{"soil fitted, no effect", {}, {}, PlotSeries::Style::points, 1},
      after{"twin, group left out", {}, {}, PlotSeries::Style::points, 2};
  const double f = shown_factor(channel);
  for (const SteadyRow& row : report.rows) {
    const auto value = row.values.find(channel);
    if (value == row.values.end()) continue;
    const SteadyRow::Value& v = value->second;
    for (const auto& [series, y] : {std::pair{&declared, v.declared},
                                    {&before, v.before},
                                    {&after, v.left_out},
                                    {&measured, v.measured}}) {
      if (!std::isfinite(y)) continue;
      series->x.push_back(row.slip);
      series->y.push_back(f * y);
    }
  }
  if (measured.x.empty()) return "";
  Plot plot;
  plot.title = fmt::format("{} against slip", title_of(channel));
  plot.x_label = "slip ratio";
  plot.y_label = fmt::format("{}, {}", title_of(channel), shown_unit_of(channel));
  plot.series = {declared, before, after, measured};
  return svg(plot, 640, 400);
}

std::string residual_plot(const SteadyReport& report, Channel channel) {
  PlotSeries before{"no effect", {}, {}, PlotSeries::Style::points, 1},
      after{"group left out", {}, {}, PlotSeries::Style::points, 2},
      zero{"", {-1.0, 1.0}, {0.0, 0.0}, PlotSeries::Style::dashed, 7};
  const double f = shown_factor(channel);
  for (const SteadyRow& row : report.rows) {
    const auto value = row.values.find(channel);
    if (value == row.values.end()) continue;
    const SteadyRow::Value& v = value->second;
    for (const auto& [series, y] : {std::pair{&before, v.before}, {&after, v.left_out}}) {
      if (!std::isfinite(y)) continue;
      series->x.push_back(row.slip);
      series->y.push_back(f * (v.measured - y));
    }
  }
  if (before.x.empty()) return "";
  Plot plot;
  plot.title = fmt::format("{}: measured less twin", title_of(channel));
  plot.x_label = "slip ratio";
  plot.y_label = fmt::format("Residual, {}", shown_unit_of(channel));
  plot.series = {zero, before, after};
  return svg(plot, 640, 400);
}

}  // namespace

Json steady_json(const SteadyReport& report) {
  Json json;
  json["declared"] = Json::object();
  for (const auto& [channel, e] : report.declared)
    json["declared"][std::string(name_of(channel))] = {{"unit", unit_of(channel)},
                                                       {"rmse", number_json(e.before)}};
  json["left_out"] = {{"groups", report.parts}, {"error", errors_json(report.left_out)}};
  Json driving = errors_json(report.left_out_driving);
  for (const auto& [channel, constant] : report.constant_driving)
    driving[std::string(name_of(channel))]["constant"] = number_json(constant);
  json["left_out"]["driving"] = driving;
  json["not_diagnosed"] = {{"runs", report.outside_runs}, {"error", errors_json(report.outside)}};
  json["effects_left_aside"] = report.left_aside;
  json["soil"] = report.soil;
  json["survey"] = Json::parse(survey_json("", report.survey))["items"];
  json["runs"] = Json::array();
  for (const SteadyRow& row : report.rows) {
    Json entry = {{"run", row.run},
                  {"group", row.group},
                  {"slip", row.slip},
                  {"load", row.load},
                  {"steering_angle", row.steering_angle}};
    for (const auto& [channel, v] : row.values) entry[std::string(name_of(channel))] = values_json(v);
    json["runs"].push_back(entry);
  }
  return json;
}

std::string steady_html(const SteadyReport& report) {
  std::string html = "<h2>Groups left out</h2>";
  html += page::paragraph(
      "Each group of runs (a day, a filling, a tare) is foretold by a twin that was made without it: soil, "
      "choice of effects and their parameters. RMSE over runs of the difference of the window means.");
  html += page::table({"Channel", "No effect", "With effects", "Scatter of repeated runs",
                       "Constant (mean of the other groups)", "Unit"},
                      error_rows(report));
  std::string rows;
  for (const std::string& part : report.parts) {
    const auto colon = part.find(": ");
    rows += page::row({part.substr(0, colon), colon == std::string::npos ? "" : part.substr(colon + 2)});
  }
  html += page::folded("Effects chosen without each group", page::table({"Left out", "Chosen"}, rows));
  html += "<h2>Against slip</h2>";
  for (const Channel channel : all_channels)
    html += page::pair(slip_plot(report, channel), residual_plot(report, channel));
  rows.clear();
  for (const SteadyRow& row : report.rows)
    for (const auto& [channel, v] : row.values)
      rows += page::row({row.run, row.group, fmt::format("{:.2f}", row.slip), fmt::format("{:.1f}", row.load),
                         fmt::format("{}, {}", title_of(channel), shown_unit_of(channel)),
                         shown(channel, v.measured), shown(channel, v.declared), shown(channel, v.before),
                         shown(channel, v.after), shown(channel, v.left_out)});
  html += page::folded("Every run", page::table({"Run", "Group", "Slip", "Load, N", "Channel", "Measured",
                                                 "As declared", "No effect", "With effects", "Left out"},
                                                rows));
  if (!report.outside.empty()) {
    rows.clear();
    for (const auto& [channel, e] : report.outside)
      rows += page::row({std::string(title_of(channel)), shown(channel, e.before), shown(channel, e.after),
                         std::string(shown_unit_of(channel))});
    html += fmt::format("<h3>The {} steered runs, which were not diagnosed</h3>", report.outside_runs) +
            page::table({"Channel", "No effect", "With effects", "Unit"}, rows);
  }
  html += survey_html(report.survey);
  std::string aside;
  for (const std::string& reason : report.left_aside) aside += (aside.empty() ? "" : "; ") + reason;
  if (!aside.empty()) html += page::note("Effects that window means cannot tell: " + aside + ".");
  std::string soil;
  for (const std::string& value : report.soil) soil += (soil.empty() ? "" : ", ") + value;
  html += page::note("Soil fitted along: " + soil + ".");
  return html;
}

std::string steady_csv(const SteadyReport& report) {
  std::string csv =
      "run,group,slip,load,steering_angle,channel,unit,measured,declared,before,after,left_out\n";
  for (const SteadyRow& row : report.rows)
    for (const auto& [channel, v] : row.values)
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", row.run, row.group, row.slip, row.load,
                         row.steering_angle, name_of(channel), unit_of(channel), v.measured, v.declared,
                         v.before, v.after, v.left_out);
  return csv;
}

}  // namespace wheel_twin::twin
