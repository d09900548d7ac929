#include "write.h"

#include <fmt/format.h>

#include <filesystem>

#include "base/atomic_file.h"
#include "effects/catalogue.h"
#include "logs/bag_writer.h"
#include "logs/experiment.h"

namespace wheel_twin::blind {
namespace {

namespace fs = std::filesystem;

std::string truth_text(const Drawn& d, const std::string& name) {
  std::string text = "experiment: " + name + "\neffects:" + (d.effects.empty() ? " {}\n" : "\n");
  for (const twin::EffectSetting& effect : d.effects) {
    text += "  " + effect.name + ":\n";
    const effects::EffectType& type = effects::find_effect(effect.name);
    for (std::size_t i = 0; i < effect.values.size(); ++i)
      text += fmt::format("    {}: {:.8g}\n", type.parameters[i].name, effect.values[i]);
  }
  if (!d.outside.empty()) text += fmt::format("outside: {}\n", d.outside);
  text += "forms: [";
  for (const ModelForm& form : d.forms) text += (text.back() == '[' ? "" : ", ") + form.name;
  return text + fmt::format("]\nreferences: {}\n", d.reference_slips.size());
}

}  // namespace

void write(const Drawn& d, const std::string& name, const std::string& out_folder, std::uint64_t seed) {
  const fs::path out = out_folder;
  const fs::path folder = out / name;
  fs::create_directories(folder);
  fs::create_directories(out / "truth");
  logs::Experiment experiment;
  experiment.name = name;
  experiment.wheel = d.wheel;
  experiment.soil = d.declared;
  experiment.ft =
      logs::DeclaredSensor{d.run.sensors.ft.rate, d.run.sensors.ft.noise[0], d.run.sensors.ft.resolution[0]};
  experiment.draw_wire = logs::DeclaredSensor{d.run.sensors.draw_wire.rate, d.run.sensors.draw_wire.noise,
                                              d.run.sensors.draw_wire.resolution};
  const auto add = [&](double slip, logs::Role role) {
    const auto index = experiment.runs.size();
    logs::Run run;
    run.bag = fmt::format("run_{:02}.bag", index);
    run.role = role;
    run.slip = slip;
    run.load = d.run.conditions.load;
    run.wheel_speed = d.run.conditions.wheel_speed;
    logs::write_bag(simulate_run(d, slip, role != logs::Role::reference, seed * 100 + index, false),
                    (folder / *run.bag).string());
    experiment.runs.push_back(run);
  };
  for (const double slip : d.reference_slips) add(slip, logs::Role::reference);
  for (const double slip : d.slips) add(slip, logs::Role::measured);
  logs::write_experiment(experiment, folder.string());
  write_file((out / "truth" / (name + ".yaml")).string(), truth_text(d, name));
}

}  // namespace wheel_twin::blind
