#include "twin/twin_config.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/yaml.h"
#include "effects/catalogue.h"

namespace wheel_twin::twin {
namespace {

std::optional<Channel> channel_of(std::string_view name) {
  for (const Channel channel : all_channels)
    if (name == name_of(channel)) return channel;
  return std::nullopt;
}

EffectSetting read_effect(const yaml::Map& map) {
  EffectSetting setting;
  setting.name = map.text("name");
  const effects::EffectType& type = effects::find_effect(setting.name);
  const yaml::Map values = map.map("parameters");
  for (const effects::Parameter& p : type.parameters)
    setting.values.push_back(!values.has(p.name) && !std::isnan(p.neutral)
                                 ? p.neutral
                                 : values.number(p.name, {p.lower, p.upper}));
  values.finish();
  map.finish();
  return setting;
}

Correction read_correction(const yaml::Map& map) {
  Correction correction;
  const std::string name = map.text("channel");
  const auto channel = channel_of(name);
  if (!channel) map.fail("channel", fmt::format("'{}' is not a channel", name));
  correction.channel = *channel;
  correction.slip_length = map.number("slip_length", yaml::positive());
  correction.load_length = map.number("load_length", yaml::positive());
  correction.slip = map.numbers("slip");
  correction.load = map.numbers("load");
  correction.weight = map.numbers("weight");
  if (correction.slip.size() != correction.weight.size() ||
      correction.load.size() != correction.weight.size())
    map.fail("weight", "slip, load and weight must be equally long");
  map.finish();
  return correction;
}

std::string list_text(const std::vector<double>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += fmt::format("{}{}", i == 0 ? "" : ", ", values[i]);
  return text + "]";
}

}  // namespace

double Correction::at(double slip_now, double load_now) const {
  double value = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    const double a = (slip_now - slip[i]) / slip_length;
    const double b = (load_now - load[i]) / load_length;
    value += weight[i] * std::exp(-0.5 * (a * a + b * b));
  }
  return value;
}

TwinConfig read_twin(const std::string& path) {
  const yaml::Map map = yaml::parse_file(path);
  if (map.integer("schema") != 1) map.fail("schema", "this program reads schema 1");
  TwinConfig model;
  model.name = map.text("name");
  model.wheel = terramechanics::read_wheel(map.map("wheel"));
  model.soil = terramechanics::read_soil(map.map("soil"));
  const yaml::Map rig = map.map("rig");
  model.rig.mount.arm_z = rig.number("arm_z");
  model.rig.mount.drive_torque_share = rig.number("drive_torque_share");
  model.rig.drive.coulomb_loss = rig.number("drive_loss", yaml::non_negative());
  model.start_up = rig.number("start_up", yaml::non_negative());
  rig.finish();
  if (map.has("effects")) {
    const yaml::List list = map.list("effects");
    for (std::size_t i = 0; i < list.size(); ++i) model.effects.push_back(read_effect(list.map(i)));
  }
  if (map.has("corrections")) {
    const yaml::List list = map.list("corrections");
    for (std::size_t i = 0; i < list.size(); ++i) model.corrections.push_back(read_correction(list.map(i)));
  }
  map.finish();
  return model;
}

std::string twin_text(const TwinConfig& model) {
  const terramechanics::Wheel& w = model.wheel;
  const terramechanics::Soil& s = model.soil;
  std::string text = fmt::format("schema: 1\nname: {}\n", model.name);
  text += fmt::format(
      "wheel: {{name: {}, radius: {}, width: {}, grousers: {}, grouser_height: {}, stiffness: {}}}\n", w.name,
      w.radius, w.width, w.grousers, w.grouser_height,
      w.stiffness ? fmt::format("{}", *w.stiffness) : "null");
  text += fmt::format(
      "soil: {{name: {}, k_c: {}, k_phi: {}, n: {}, c: {}, phi: {}, K: {}, c1: {}, c2: {}, gamma: {}, "
      "weight_density: {}}}\n",
      s.name, s.k_c, s.k_phi, s.n, s.c, s.phi, s.K, s.c1, s.c2, s.gamma, s.weight_density);
  text += fmt::format("rig: {{arm_z: {}, drive_torque_share: {}, drive_loss: {}, start_up: {}}}\n",
                      model.rig.mount.arm_z, model.rig.mount.drive_torque_share, model.rig.drive.coulomb_loss,
                      model.start_up);
  if (!model.effects.empty()) text += "effects:\n";
  for (const EffectSetting& setting : model.effects) {
    const effects::EffectType& type = effects::find_effect(setting.name);
    text += fmt::format("- name: {}\n  parameters:\n", setting.name);
    for (std::size_t i = 0; i < type.parameters.size(); ++i)
      text += fmt::format("    {}: {}  # {}\n", type.parameters[i].name, setting.values[i],
                          type.parameters[i].unit);
  }
  if (!model.corrections.empty())
    text +=
        "# empirical, without a physical name: what the baseline misses on reference runs\ncorrections:\n";
  for (const Correction& c : model.corrections)
    text +=
        fmt::format("- {{channel: {}, slip_length: {}, load_length: {}, slip: {}, load: {}, weight: {}}}\n",
                    name_of(c.channel), c.slip_length, c.load_length, list_text(c.slip), list_text(c.load),
                    list_text(c.weight));
  return text;
}

void write_twin(const TwinConfig& model, const std::string& path) {
  write_file(path, twin_text(model));
}

}  // namespace wheel_twin::twin
