// The page of `twin compare`: one HTML file with its pictures inside, for a rig engineer.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/plot.h"
#include "terramechanics/wheel_on_soil.h"
#include "twin/compare.h"
#include "twin/page.h"

namespace wheel_twin::twin {
namespace {

constexpr double degree = 0.01745329252;
constexpr int measured_color = 0, twin_color = 1, residual_color = 2;

std::string axis(Channel channel) {
  return fmt::format("{} ({})", title_of(channel), shown_unit_of(channel));
}

// Two decimals, more where the value is small; a minus sign as a person writes it.
std::string shown(Channel channel, double value) {
  const double v = shown_factor(channel) * value;
  const double size = std::abs(v);
  const int decimals = size >= 0.1 || size == 0.0 ? 2 : size >= 0.01 ? 3 : 4;
  const std::string text = fmt::format("{:.{}f}", size, decimals);
  return v < 0.0 && text.find_first_not_of("0.") != std::string::npos ? "−" + text : text;
}

// Whole degrees, without the sign of a zero.
std::string degrees(double angle) {
  return fmt::format("{}", std::lround(angle / degree));
}

std::vector<Channel> channels_in(const std::vector<RunComparison>& runs) {
  std::vector<Channel> found;
  for (const Channel channel : all_channels)
    if (std::any_of(runs.begin(), runs.end(),
                    [&](const RunComparison& run) { return run.at(channel).has_value(); }))
      found.push_back(channel);
  return found;
}

std::string errors_table(const std::vector<RunComparison>& runs, const std::vector<Channel>& channels,
                         const RunFilter& filter) {
  std::string rows;
  for (const Channel channel : channels) {
    const auto error = error_of(runs, channel, filter);
    if (!error) continue;
    const auto scatter = repeat_scatter(runs, channel, filter);
    const auto constant = error_of_constant(runs, channel, filter);
    rows += page::row(
        {std::string(title_of(channel)), std::string(shown_unit_of(channel)), shown(channel, error->rmse),
         shown(channel, error->mean), constant ? shown(channel, *constant) : "",
         scatter ? fmt::format("{} ({} runs)", shown(channel, scatter->std), scatter->runs) : "",
         fmt::format("{}", error->runs)});
  }
  return page::table({"Channel", "Unit", "RMSE of the twin", "Mean of twin − measured",
                      "RMSE of the best constant", "Scatter of repeated runs", "Runs"},
                     rows);
}

std::string against_slip(const std::vector<RunComparison>& runs, Channel channel, const RunFilter& filter) {
  Plot values, residuals;
  values.title = fmt::format("{} against slip", title_of(channel));
  values.x_label = residuals.x_label = "Slip (−1 locked, 0 rolling, 1 spinning)";
  values.y_label = axis(channel);
  residuals.title = "Residual";
  residuals.y_label = fmt::format("Twin − measured ({})", shown_unit_of(channel));
  PlotSeries measured, twin, residual, zero;
  measured.label = "measured";
  measured.color = measured_color;
  twin.label = "twin";
  twin.color = twin_color;
  residual.color = residual_color;
  for (PlotSeries* series : {&measured, &twin, &residual}) series->style = PlotSeries::Style::points;
  double low = 1.0, high = -1.0;
  for (const RunComparison& run : runs) {
    const auto& compared = run.at(channel);
    if (!compared || !filter(run.run)) continue;
    const double factor = shown_factor(channel), slip = run.run.slip;
    for (PlotSeries* series : {&measured, &twin, &residual}) series->x.push_back(slip);
    measured.y.push_back(factor * compared->mean.measured);
    twin.y.push_back(factor * compared->mean.twin);
    residual.y.push_back(factor * (compared->mean.twin - compared->mean.measured));
    low = std::min(low, slip);
    high = std::max(high, slip);
  }
  if (measured.x.empty()) return {};
  zero.x = {low, high};
  zero.y = {0.0, 0.0};
  zero.style = PlotSeries::Style::dashed;
  zero.color = 7;
  values.series = {measured, twin};
  residuals.series = {zero, residual};
  return page::pair(svg(values, 560, 340), svg(residuals, 560, 340));
}

// Both curves of a channel and their difference, each point the mean over a three-hundredth of the run.
std::string over_time(const RunComparison& run, Channel channel) {
  const SeriesComparison& series = *run.at(channel)->series;
  Plot plot, residuals;
  plot.title = std::string(title_of(channel));
  residuals.x_label = "Time from the start of the run (s)";
  plot.y_label = axis(channel);
  residuals.y_label = "Twin − measured";
  PlotSeries measured, twin, residual;
  measured.label = "measured";
  measured.color = measured_color;
  twin.label = "twin";
  twin.color = twin_color;
  residual.color = residual_color;
  constexpr std::size_t shown_points = 300;
  const std::size_t stride = std::max<std::size_t>(1, series.time.size() / shown_points);
  const double factor = shown_factor(channel);
  for (std::size_t i = 0; i + stride <= series.time.size(); i += stride) {
    double time = 0.0, a = 0.0, b = 0.0;
    for (std::size_t k = i; k < i + stride; ++k) {
      time += series.time[k];
      a += series.measured[k];
      b += series.twin[k];
    }
    const auto count = static_cast<double>(stride);
    for (PlotSeries* curve : {&measured, &twin, &residual}) curve->x.push_back(time / count);
    measured.y.push_back(factor * a / count);
    twin.y.push_back(factor * b / count);
    residual.y.push_back(factor * (b - a) / count);
  }
  plot.series = {measured, twin};
  residuals.series = {residual};
  if (run.at(channel)->from_average && run.run.averages) {
    PlotSeries window;
    window.label = "window of the averages";
    window.color = 3;
    window.x = {run.run.averages->window_start, run.run.averages->window_end};
    window.y = {factor * run.at(channel)->mean.measured, factor * run.at(channel)->mean.measured};
    plot.series.push_back(window);
  }
  return "<div>" + svg(plot, 460, 260) + svg(residuals, 460, 180) + "</div>";
}

std::string time_courses(const std::vector<RunComparison>& runs, const std::vector<Channel>& channels) {
  std::string html;
  for (const RunComparison& run : runs) {
    std::string pictures;
    for (const Channel channel : channels)
      if (run.at(channel) && run.at(channel)->series) pictures += over_time(run, channel);
    if (pictures.empty()) continue;
    html += page::folded(fmt::format("{} — slip {:.2f}, load {:.1f} N, steering {}°", run.name, run.run.slip,
                                     run.load, degrees(run.run.steering_angle)),
                         "<div class=\"grid\">" + pictures + "</div>");
  }
  return html;
}

std::string runs_table(const std::vector<RunComparison>& runs, const std::vector<Channel>& channels) {
  std::vector<std::string> head = {"Run", "Role", "Slip", "Load (N)", "Steering (°)"};
  for (const Channel channel : channels)
    head.push_back(fmt::format("{} ({}): measured / twin", title_of(channel), shown_unit_of(channel)));
  std::string rows;
  for (const RunComparison& run : runs) {
    std::vector<std::string> cells = {run.name, logs::to_string(run.run.role),
                                      fmt::format("{:.2f}", run.run.slip), fmt::format("{:.1f}", run.load),
                                      degrees(run.run.steering_angle)};
    for (const Channel channel : channels) {
      const auto& compared = run.at(channel);
      cells.push_back(compared ? fmt::format("{} / {}", shown(channel, compared->mean.measured),
                                             shown(channel, compared->mean.twin))
                               : "");
    }
    if (!run.failure.empty()) cells.back() = "no prediction: " + run.failure;
    rows += page::row(cells);
  }
  return page::table(head, rows);
}

std::string plates_plot(const ExperimentComparison& comparison) {
  const PlateFit& fit = *comparison.plate_fit;
  const double compliance = fit.compliance ? fit.compliance->value : 0.0;
  Plot plot;
  plot.title = "Plates pressed into the sand";
  plot.x_label = "Depth, less what the rig gives way (mm)";
  plot.y_label = "Pressure (kPa)";
  std::set<double> diameters;
  for (const PressCurve& curve : comparison.press_curves)
    if (curve.indenter == "plate") diameters.insert(curve.diameter);
  int color = 0;
  for (const double diameter : diameters) {
    bool first = true;
    double deepest = 0.0;
    const double area = 0.25 * 3.14159265358979 * diameter * diameter;
    for (const PressCurve& curve : comparison.press_curves) {
      if (curve.indenter != "plate" || curve.diameter != diameter) continue;
      PlotSeries series;
      series.color = color;
      if (first) series.label = fmt::format("{:.0f} mm, measured", 1e3 * diameter);
      first = false;
      const std::size_t stride = std::max<std::size_t>(1, curve.force.size() / 150);
      for (std::size_t i = 0; i < curve.force.size(); i += stride) {
        const double depth = curve.depth[i] - compliance * curve.force[i];
        series.x.push_back(1e3 * depth);
        series.y.push_back(1e-3 * curve.force[i] / area);
        deepest = std::max(deepest, depth);
      }
      plot.series.push_back(series);
    }
    PlotSeries fitted;
    fitted.label = fmt::format("{:.0f} mm, fitted law", 1e3 * diameter);
    fitted.color = color++;
    fitted.style = PlotSeries::Style::dashed;
    for (int i = 0; i <= 40; ++i) {
      const double depth = deepest * i / 40.0;
      fitted.x.push_back(1e3 * depth);
      fitted.y.push_back(1e-3 * fit.modulus(diameter) * std::pow(depth, fit.n.value));
    }
    plot.series.push_back(fitted);
  }
  return svg(plot, 560, 380);
}

// A wheel pressed straight down was not fitted: it tests the soil.
std::string pressed_wheel_plot(const ExperimentComparison& comparison) {
  const double compliance = comparison.plate_fit->compliance ? comparison.plate_fit->compliance->value : 0.0;
  Plot plot;
  plot.title = "The wheel pressed straight down (not fitted)";
  plot.x_label = "Depth, less what the rig gives way (mm)";
  plot.y_label = "Normal load (N)";
  double deepest = 0.0;
  for (const PressCurve& curve : comparison.press_curves) {
    if (curve.indenter != "wheel") continue;
    PlotSeries series;
    series.color = measured_color;
    if (plot.series.empty()) series.label = "measured";
    const std::size_t stride = std::max<std::size_t>(1, curve.force.size() / 150);
    for (std::size_t i = 0; i < curve.force.size(); i += stride) {
      const double depth = curve.depth[i] - compliance * curve.force[i];
      series.x.push_back(1e3 * depth);
      series.y.push_back(curve.force[i]);
      deepest = std::max(deepest, depth);
    }
    plot.series.push_back(series);
  }
  if (plot.series.empty()) return {};
  const terramechanics::WheelOnSoil model(comparison.experiment.wheel, comparison.soil);
  PlotSeries twin;
  twin.label = "twin with the soil of the plates";
  twin.color = twin_color;
  twin.style = PlotSeries::Style::dashed;
  for (int i = 1; i <= 40; ++i) {
    const double depth = std::min(deepest, 0.9 * comparison.experiment.wheel.radius) * i / 40.0;
    twin.x.push_back(1e3 * depth);
    twin.y.push_back(model.at_rest_at_hub_displacement(depth).normal_load);
  }
  plot.series.push_back(twin);
  return svg(plot, 560, 380);
}

std::string soil_part(const ExperimentComparison& comparison) {
  const auto& soil = comparison.soil;
  std::string html = "<h2>Soil of the twin</h2>";
  if (!comparison.plate_fit) {
    html += page::paragraph(comparison.plate_note.empty()
                                ? "As declared by the experiment: there are no plate tests in it."
                                : "As declared by the experiment: " + comparison.plate_note + ".");
  } else {
    const PlateFit& fit = *comparison.plate_fit;
    html += page::paragraph(fmt::format(
        "k_c, k_phi and n are fitted to {} plate tests as p = (k_c/b + k_phi) z^n, b the plate's diameter; "
        "nothing is fitted to "
        "the runs. Tests of the same sand differ by {:.0f} % in pressure at {:.0f} mm and by {:.2f} in the "
        "exponent; the errors "
        "given are standard errors between tests. At the wheel's width the pressure is known to {:.0f} "
        "%.{}{}",
        fit.tests.size(), 100.0 * fit.between_tests_pressure, 1e3 * fit.reference_depth,
        fit.between_tests_exponent, 100.0 * fit.relative_error_at_width,
        fit.compliance
            ? fmt::format(" The rig gives way by {:.1f} mm per 1000 N on a rigid floor{}: "
                          "taken off the depth.",
                          1e6 * fit.compliance->value,
                          fit.compliance->standard_error > 0.0
                              ? fmt::format(" (± {:.1f} between tests)", 1e6 * fit.compliance->standard_error)
                              : "")
            : "",
        fit.k_c.value < 0.0
            ? " The negative k_c says that wider plates meet more pressure at the same depth: the law holds "
              "between the plates' sizes only."
            : ""));
    html += page::pair(plates_plot(comparison), pressed_wheel_plot(comparison));
  }
  std::string rows;
  const auto entry = [&](const char* name, double value, const char* unit, const Estimate* estimate) {
    rows += page::row({name, fmt::format("{:.4g}", value),
                       estimate != nullptr ? fmt::format("± {:.2g}", estimate->standard_error) : "declared",
                       unit});
  };
  const PlateFit* fit = comparison.plate_fit ? &*comparison.plate_fit : nullptr;
  entry("k_c", soil.k_c, "N/m^(n+1)", fit != nullptr ? &fit->k_c : nullptr);
  entry("k_phi", soil.k_phi, "N/m^(n+2)", fit != nullptr ? &fit->k_phi : nullptr);
  entry("n, sinkage exponent", soil.n, "", fit != nullptr ? &fit->n : nullptr);
  entry("c, cohesion", soil.c, "Pa", nullptr);
  entry("phi, friction angle", soil.phi / degree, "degrees", nullptr);
  entry("K, shear modulus", 1e3 * soil.K, "mm", nullptr);
  entry("c1", soil.c1, "", nullptr);
  entry("c2", soil.c2, "", nullptr);
  entry("gamma, exit", soil.gamma, "", nullptr);
  return html + page::table({"Parameter", "Value", "Error", "Unit"}, rows);
}

// What would be shown as -0.000 without its sign.
double unsigned_zero(double value) {
  return std::abs(value) < 5e-4 ? 0.0 : value;
}

std::string mount_part(const ExperimentComparison& comparison) {
  const rig::MountSettings& mount = comparison.rig.mount;
  const std::string law = "M_y = −arm_z F_x + arm_x F_z + share T";
  std::string html = "<h2>Mount of the force/torque sensor</h2>";
  if (!comparison.mount_fit)
    return html +
           page::paragraph(fmt::format(
               "The pitch torque is taken as {} with arm_x {:.3f} m, arm_z {:.3f} m and a share {:.2f} of "
               "the drive "
               "torque T, as of the rig “{}”. An experiment does not declare its mount and this one has no "
               "reference runs to tell it: a pitch torque that is off by the same factor in every run says "
               "that "
               "the mount is another.",
               law, mount.arm_x, mount.arm_z, mount.drive_torque_share, comparison.rig.name));
  const rig::MountFit& fit = *comparison.mount_fit;
  return html + page::paragraph(fmt::format("An experiment does not declare how its sensor is mounted. The "
                                            "reference runs, taken with the rig in "
                                            "order, tell it by {}, all measured (T is the motor’s torque), "
                                            "without a soil model: arm_x {:.3f} ± "
                                            "{:.3f} m, arm_z {:.3f} ± {:.3f} m, share {:.2f} ± {:.2f}; "
                                            "{:.3f} N m are left. A share of −1 is what "
                                            "statics says of a motor on the tool side; +1 is a log that "
                                            "counts the motor’s torque on the wheel.",
                                            law, unsigned_zero(mount.arm_x), fit.arm_x_error, mount.arm_z,
                                            fit.arm_z_error, mount.drive_torque_share, fit.share_error,
                                            fit.residual));
}

}  // namespace

std::string comparison_page(const ExperimentComparison& comparison) {
  const std::vector<RunComparison>& runs = comparison.runs;
  const std::vector<Channel> channels = channels_in(runs);
  const bool measured_load =
      std::any_of(runs.begin(), runs.end(), [](const RunComparison& r) { return r.measured_load; });
  const auto failed =
      std::count_if(runs.begin(), runs.end(), [](const RunComparison& r) { return !r.failure.empty(); });
  const bool steered =
      std::any_of(runs.begin(), runs.end(), [](const RunComparison& r) { return !is_straight(r.run); });
  std::string html = page::heading(comparison.experiment.name, "Twin and measurement, run by run");
  html += page::paragraph(fmt::format(
      "{} runs with the wheel “{}”. The twin is led by the measured motion of each run, under the {} load, "
      "and says what every "
      "sensor should have read; no soil or wheel is fitted to the runs, the residual is shown as it is.{}",
      runs.size(), comparison.experiment.wheel.name, measured_load ? "measured mean" : "declared",
      failed > 0 ? fmt::format(" For {} runs it has no prediction; the table of runs says why.", failed)
                 : ""));
  if (!comparison.experiment.source.empty())
    html += page::note("Data: " + comparison.experiment.source + ".");
  const RunFilter straight = is_straight;
  html += "<h2>Errors</h2>";
  if (steered) html += "<h3>Steering angle 0</h3>";
  html += errors_table(runs, channels, straight);
  html += "<h3>Driving only (slip above 0.05)</h3>" + errors_table(runs, channels, [](const logs::Run& run) {
            return is_straight(run) && is_driving(run);
          });
  if (steered)
    html += "<h3>Steered runs</h3>" +
            errors_table(runs, channels, [](const logs::Run& run) { return !is_straight(run); });
  html += page::note(
      "Best constant: what one gets by always saying the mean of the measurements. Scatter of repeated runs: "
      "standard deviation between runs of equal slip, steering and declared load; no twin can be better.");
  html += "<h2>Against slip</h2>";
  if (steered) html += "<h3>Steering angle 0</h3>";
  for (const Channel channel : channels) html += against_slip(runs, channel, straight);
  if (steered) {
    html += "<h3>Steered runs, all angles</h3>";
    for (const Channel channel : channels)
      html += against_slip(runs, channel, [](const logs::Run& run) { return !is_straight(run); });
  }
  html += soil_part(comparison);
  if (std::find(channels.begin(), channels.end(), Channel::pitch_torque) != channels.end())
    html += mount_part(comparison);
  const std::string courses = time_courses(runs, channels);
  if (!courses.empty())
    html += "<h2>Over time</h2>" +
            page::note("Open a run to see its channels, from the time when the wheel touches the soil.") +
            courses;
  html += "<h2>Runs</h2>" + page::folded("All runs in numbers", runs_table(runs, channels));
  return page::document(comparison.experiment.name + " · twin and measurement", html);
}

}  // namespace wheel_twin::twin
