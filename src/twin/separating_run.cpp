#include "twin/separating_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "twin/residual_text.h"

namespace wheel_twin::twin {
namespace {

constexpr double near = 3.0;  // in score

/// A run that was not made: the channels of `like`, other conditions.
SteadyRun planned(const SteadyRun& like, double slip, double load, double steering_angle, double radius) {
  logs::Run run = like.grid.declared;
  run.slip = slip;
  run.load = load;
  run.steering_angle = steering_angle;
  const logs::Average any{0.0, std::nullopt};
  run.averages->drawbar_pull = any;
  run.averages->hub_displacement = any;
  run.averages->side_force = any;
  run.averages->normal_load.reset();  // the dead weight leads
  return steady_run(run, "planned", radius);
}

}  // namespace

std::string separating_run(const logs::Experiment& experiment, const SteadyEvidence& evidence,
                           const Selection& selection, const SteadyRuns& runs) {
  std::vector<const Trial*> rivals;
  const auto& chosen = selection.chosen.fit.candidate.effects;
  // More effects on top of the chosen ones are no rivals.
  const auto adds_to_chosen = [&](const std::vector<std::string>& effects) {
    return !chosen.empty() && effects.size() > chosen.size() &&
           std::all_of(chosen.begin(), chosen.end(), [&](const std::string& name) {
             return std::find(effects.begin(), effects.end(), name) != effects.end();
           });
  };
  for (const Trial& t : selection.trials)
    if (t.score > selection.trials.front().score - near && rivals.size() < 6 &&
        !adds_to_chosen(t.fit.candidate.effects))
      rivals.push_back(&t);
  if (rivals.size() < 2 || runs.empty()) return {};
  double load = 0.0;
  for (const SteadyRun* run : runs) load += run->grid.declared.load / static_cast<double>(runs.size());

  struct Best {
    double z = 0.0;
    std::string text;
  } best;
  for (const double slip : {-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 0.9})
    for (const double factor : {0.5, 1.0, 2.0})
      for (const double steering : {0.0, 0.26}) {
        std::vector<std::vector<double>> means;
        SteadyRun run;
        try {
          run = planned(*runs.front(), slip, factor * load, steering, experiment.wheel.radius);
          for (const Trial* rival : rivals) means.push_back(predict_means(rival->fit.candidate.model, run));
        } catch (const Error&) {
          continue;
        }
        for (std::size_t w = 0; w < run.grid.windows.size(); ++w) {
          const Channel channel = run.grid.windows[w].channel;
          double least = means[0][w], most = means[0][w];
          std::size_t low = 0, high = 0;
          for (std::size_t k = 1; k < means.size(); ++k) {
            if (means[k][w] < least) least = means[k][w], low = k;
            if (means[k][w] > most) most = means[k][w], high = k;
          }
          const double z = (most - least) / evidence.noise[index_of(channel)].total();
          if (z <= best.z) continue;
          best.z = z;
          const double f = shown_factor(channel);
          best.text = fmt::format(
              "a run at slip {:.1f} under {:.0f} N, steered by {:.0f} degrees, would tell them apart best: "
              "{} "
              "{:.3g} {} under {}, {:.3g} {} under {}",
              slip, factor * load, steering * 57.29578, name_of(channel), f * least, shown_unit_of(channel),
              effect_list(rivals[low]->fit.candidate.effects), f * most, shown_unit_of(channel),
              effect_list(rivals[high]->fit.candidate.effects));
        }
      }
  std::string names;
  for (const Trial* rival : rivals)
    names += (names.empty() ? "" : ", ") + effect_list(rival->fit.candidate.effects);
  if (best.z < 2.0)
    return fmt::format("Not told apart by these runs, nor by any other slip, load or steering angle: {}.",
                       names);
  return fmt::format("Hardly told apart by these runs: {}; {}.", names, best.text);
}

}  // namespace wheel_twin::twin
