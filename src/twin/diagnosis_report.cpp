#include "twin/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/atomic_file.h"
#include "base/plot.h"
#include "effects/catalogue.h"
#include "twin/json_parts.h"
#include "twin/page.h"
#include "twin/residual_text.h"
#include "twin/steady_page.h"

namespace wheel_twin::twin {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t shown_candidates = 10;

Json effects_json(const Ranked& ranked, const std::map<std::string, double>& probabilities) {
  Json list = Json::array();
  const Candidate& c = ranked.candidate;
  for (std::size_t k = 0; k < c.effects.size(); ++k) {
    const effects::EffectType& type = effects::find_effect(c.effects[k]);
    Json parameters = Json::object();
    for (std::size_t i = 0; i < type.parameters.size(); ++i)
      parameters[type.parameters[i].name] = {{"value", number_json(c.values[k][i])},
                                             {"stderr", number_json(c.errors[k][i])},
                                             {"unit", type.parameters[i].unit}};
    const auto own = probabilities.find(type.name);
    list.push_back({{"name", type.name},
                    {"probability", own == probabilities.end() ? ranked.probability : own->second},
                    {"parameters", parameters}});
  }
  return list;
}

std::string names_of(const Candidate& c) {
  std::string text;
  for (const std::string& name : c.effects) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "nothing acts" : text;
}

std::string parameters_of(const Candidate& c) {
  std::string text;
  for (std::size_t k = 0; k < c.effects.size(); ++k) {
    const effects::EffectType& type = effects::find_effect(c.effects[k]);
    for (std::size_t i = 0; i < type.parameters.size(); ++i)
      text += fmt::format("{}{} = {:.4g} ± {:.2g} {}", text.empty() ? "" : ", ", type.parameters[i].name,
                          c.values[k][i], c.errors[k][i], type.parameters[i].unit);
  }
  return text;
}

std::string error_table(const Errors& errors) {
  std::string rows;
  for (const auto& [channel, e] : errors) {
    const double f = shown_factor(channel);
    rows += page::row({std::string(title_of(channel)), fmt::format("{:.3g}", f * e.before),
                       fmt::format("{:.3g}", f * e.after), fmt::format("{:.3g}", f * e.noise_floor),
                       std::string(shown_unit_of(channel))});
  }
  return page::table({"Channel", "RMSE before", "RMSE after", "Noise floor", "Unit"}, rows);
}

/// Measured, twin before and after over time for one channel of one run.
std::string course_plot(const RunGrid& grid, const Predicted& before, const Predicted& after,
                        Channel channel) {
  const auto c = static_cast<Eigen::Index>(index_of(channel));
  Plot plot;
  plot.title = fmt::format("{}, {} at slip {:.2g}, {:.3g} N", title_of(channel), grid.name,
                           grid.declared.slip, grid.declared.load);
  plot.x_label = "time from the start of the run, s";
  plot.y_label = fmt::format("{}, {}", title_of(channel), shown_unit_of(channel));
  PlotSeries measured{"measured", {}, {}, PlotSeries::Style::points, 0},
      b{"twin before", {}, {}, PlotSeries::Style::dashed, 1},
      a{"twin after", {}, {}, PlotSeries::Style::line, 2};
  const double f = shown_factor(channel);
  for (int i = 0; i < grid.bins(); ++i) {
    if (!std::isfinite(grid.measured(c, i))) continue;
    for (PlotSeries* s : {&measured, &b, &a}) s->x.push_back(grid.time(i));
    measured.y.push_back(f * grid.measured(c, i));
    b.y.push_back(f * before(c, i));
    a.y.push_back(f * after(c, i));
  }
  if (measured.x.empty()) return "";
  plot.series = {measured, b, a};
  return svg(plot, 640, 360);
}

/// Means while moving against slip, of all measured runs.
std::string slip_plot(const Diagnosis& d, Channel channel) {
  const auto c = static_cast<Eigen::Index>(index_of(channel));
  PlotSeries measured{"measured", {}, {}, PlotSeries::Style::points, 0},
      b{"twin before", {}, {}, PlotSeries::Style::points, 1},
      a{"twin after", {}, {}, PlotSeries::Style::points, 2};
  const double f = shown_factor(channel);
  for (const RunGrid& grid : d.grids) {
    if (grid.declared.role == logs::Role::reference) continue;
    const Predicted before = slow_course(d.before, grid), after = slow_course(d.revised, grid);
    double sums[3] = {}, slip = 0.0;
    int count = 0;
    for (int i = 0; i < grid.bins(); ++i)
      if (grid.moving[static_cast<std::size_t>(i)] && std::isfinite(grid.measured(c, i))) {
        sums[0] += grid.measured(c, i);
        sums[1] += before(c, i);
        sums[2] += after(c, i);
        slip += grid.slip[i];
        ++count;
      }
    if (count > 0)
      for (auto& [series, sum] : {std::pair{&measured, sums[0]}, {&b, sums[1]}, {&a, sums[2]}}) {
        series->x.push_back(slip / count);
        series->y.push_back(f * sum / count);
      }
    for (const WindowMean& window : grid.windows)
      if (window.channel == channel)
        for (auto& [series, value] : {std::pair{&measured, window.mean},
                                      {&b, window_mean(before, grid, window)},
                                      {&a, window_mean(after, grid, window)}}) {
          series->x.push_back(grid.declared.slip);
          series->y.push_back(f * value);
        }
  }
  if (measured.x.empty()) return "";
  Plot plot;
  plot.title = fmt::format("{} against slip, means of the runs", title_of(channel));
  plot.x_label = "slip ratio";
  plot.y_label = fmt::format("{}, {}", title_of(channel), shown_unit_of(channel));
  plot.series = {measured, b, a};
  return svg(plot, 640, 360);
}

std::string headline(const Diagnosis& d) {
  if (d.verdict == "no_residual") return "Nothing found: the residual is noise.";
  if (d.verdict == "unexplained") return "Something acts that no effect of the catalogue explains.";
  return "Found: " + names_of(d.candidates.front().candidate);
}

}  // namespace

std::string diagnosis_json(const Diagnosis& d) {
  Json json;
  json["schema"] = 1;
  json["experiment"] = d.experiment;
  json["verdict"] = d.verdict;
  json["effects"] =
      d.verdict == "effect_found" ? effects_json(d.candidates.front(), d.effect_probability) : Json::array();
  json["candidates"] = Json::array();
  for (std::size_t i = 0; i < std::min(shown_candidates, d.candidates.size()); ++i) {
    const Ranked& r = d.candidates[i];
    json["candidates"].push_back({{"effects", r.candidate.effects},
                                  {"probability", r.probability},
                                  {"score", number_json(r.candidate.score)}});
  }
  json["error"] = errors_json(d.error);
  json["held_out"] = {{"runs", d.held_out}, {"error", errors_json(d.held_out_error)}};
  json["residual"] = {{"p_before", number_json(d.omnibus.p)},
                      {"p_after", number_json(d.left.p)},
                      {"findings", Json::array()}};
  for (std::size_t i = 0; i < std::min<std::size_t>(20, d.omnibus.findings.size()); ++i) {
    const Finding& f = d.omnibus.findings[i];
    json["residual"]["findings"].push_back({{"run", f.run},
                                            {"channel", name_of(f.channel)},
                                            {"feature", f.feature},
                                            {"size", number_json(f.size)},
                                            {"standard_errors", number_json(f.z)}});
    if (f.tone) json["residual"]["findings"].back()["tone"] = frequency_of(*f.tone);
  }
  if (d.steady) json.update(steady_json(*d.steady));
  json["warnings"] = d.warnings;
  json["recording_errors"] = Json::array();
  for (const RecordingError& error : d.recording_errors)
    json["recording_errors"].push_back({{"what", error.what}, {"runs", error.runs}});
  std::string evidence = d.evidence;
  for (const Check& check : d.checks) evidence += fmt::format(" {}: {}", check.effect, check.what);
  json["evidence"] = evidence;
  return json.dump(1) + "\n";
}

std::string diagnosis_page(const Diagnosis& d) {
  std::string html = page::heading("Diagnosis of " + d.experiment, headline(d));
  html += page::paragraph(d.evidence);
  if (!d.checks.empty()) html += "<h2>What to check on the rig</h2>";
  for (const Check& check : d.checks)
    html += "<p><strong>" + page::escaped(check.effect) + "</strong>: " + page::escaped(check.what) + "</p>";
  for (const RecordingError& error : d.recording_errors)
    html += page::note(fmt::format("Recording: {} ({} runs).", error.what, error.runs.size()));
  for (const std::string& warning : d.warnings) html += page::note("Note: " + warning);
  std::string rows;
  for (std::size_t i = 0; i < std::min(shown_candidates, d.candidates.size()); ++i) {
    const Ranked& r = d.candidates[i];
    rows += page::row({names_of(r.candidate), fmt::format("{:.3f}", r.probability),
                       fmt::format("{:.1f}", r.candidate.score), parameters_of(r.candidate)});
  }
  html += "<h2>Explanations</h2>" + page::table({"Explanation", "Probability", "Score", "Parameters"}, rows);
  if (d.steady) {
    html += steady_html(*d.steady);
    html += page::note("Twin file: revised_twin.yaml. Everything on this page: diagnosis.json.");
    return page::document("Diagnosis of " + d.experiment, html);
  }
  html += "<h2>Errors of the twin, before and after</h2>";
  html += page::paragraph(
      "Root mean square over time, after the low-pass that measured and twin share. The noise floor is what "
      "a perfect twin would still show.");
  html += error_table(d.error);
  if (!d.held_out_error.empty()) {
    std::string runs;
    for (const std::string& run : d.held_out) runs += (runs.empty() ? "" : ", ") + run;
    html +=
        "<h3>On runs that were not fitted: " + page::escaped(runs) + "</h3>" + error_table(d.held_out_error);
  }
  html += "<h2>Against slip</h2><div class=\"grid\">";
  for (const Channel channel : all_channels) html += slip_plot(d, channel);
  html += "</div><h2>Over time</h2>";
  for (const RunGrid& grid : d.grids) {
    if (grid.declared.role == logs::Role::reference) continue;
    const Predicted before = slow_course(d.before, grid), after = slow_course(d.revised, grid);
    std::string plots;
    for (const Channel channel : all_channels) plots += course_plot(grid, before, after, channel);
    if (!plots.empty())
      html += page::folded(
          fmt::format("{}: slip {:.2g}, load {:.3g} N", grid.name, grid.declared.slip, grid.declared.load),
          "<div class=\"grid\">" + plots + "</div>");
  }
  html += page::note("Twin file: revised_twin.yaml. Everything on this page: diagnosis.json.");
  return page::document("Diagnosis of " + d.experiment, html);
}

void write_diagnosis(const Diagnosis& d, const std::string& directory) {
  std::filesystem::create_directories(directory);
  const auto in = [&](const char* name) { return (std::filesystem::path(directory) / name).string(); };
  write_file(in("diagnosis.json"), diagnosis_json(d));
  TwinConfig revised = d.revised;
  revised.name = d.experiment + "_revised";
  write_twin(revised, in("revised_twin.yaml"));
  std::string csv = "scope,channel,unit,rmse_before,rmse_after,noise_floor\n";
  for (const auto& [scope, errors] :
       {std::pair<const char*, const Errors*>{"measured", &d.error}, {"held_out", &d.held_out_error}})
    for (const auto& [channel, e] : *errors)
      csv += fmt::format("{},{},{},{},{},{}\n", scope, name_of(channel), unit_of(channel), e.before, e.after,
                         e.noise_floor);
  write_file(in("errors.csv"), csv);
  if (d.steady) write_file(in("runs.csv"), steady_csv(*d.steady));
  write_file(in("index.html"), diagnosis_page(d));
}

}  // namespace wheel_twin::twin
