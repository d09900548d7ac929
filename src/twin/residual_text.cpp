#include "twin/residual_text.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <set>

namespace wheel_twin::twin {
namespace {

std::string describe(const Finding& f) {
  if (f.tone)
    return fmt::format("a tone of {} in {} of {}, {:.3g} {} in amplitude", frequency_of(*f.tone),
                       name_of(f.channel), f.run, f.size, unit_of(f.channel));
  return fmt::format("{} of {} in {}: {:.3g} {} ({:+.1f} standard errors)", f.feature, name_of(f.channel),
                     f.run, f.size,
                     f.feature == "lag"           ? "s"
                     : f.feature == "fluctuation" ? "in log"
                                                  : unit_of(f.channel),
                     f.z);
}

}  // namespace

std::string frequency_of(const SharedTone& tone) {
  switch (tone.follows) {
    case Follows::travel:
      return fmt::format("{:.3g} mm of travel", 1000.0 / tone.frequency);
    case Follows::wheel:
      return fmt::format("{:.3g} cycles a turn of the wheel", tone.frequency);
    case Follows::time:
      break;
  }
  return fmt::format("{:.3g} Hz", tone.frequency);
}

std::string describe(const Omnibus& omnibus) {
  if (omnibus.findings.empty()) return "nothing stands out";
  std::string text;
  std::set<std::string> told;
  for (const Finding& f : omnibus.findings) {
    if (std::abs(f.z) < 4.0 || told.size() >= 5) break;
    if (!told.insert(fmt::format("{}/{}", f.feature, name_of(f.channel))).second) continue;
    text += (text.empty() ? "" : "; ") + describe(f);
  }
  return text.empty() ? "nothing stands out" : text;
}

std::string correlations(const Evidence& evidence, const TwinConfig& model) {
  std::string text;
  for (const Channel channel : all_channels) {
    std::vector<double> level, slip;
    for (const RunGrid* run : evidence.runs) {
      const Residual residual = residual_of(*run, simulate(model, *run));
      double sum = 0.0;
      int count = 0;
      for (int i = 0; i < run->bins(); ++i)
        if (run->moving[static_cast<std::size_t>(i)] && std::isfinite(residual.bins(index_of(channel), i))) {
          sum += residual.bins(index_of(channel), i);
          ++count;
        }
      if (count == 0) continue;
      level.push_back(sum / count);
      slip.push_back(run->declared.slip);
    }
    if (level.size() < 4) continue;
    const double n = static_cast<double>(level.size());
    const double ml = std::accumulate(level.begin(), level.end(), 0.0) / n,
                 ms = std::accumulate(slip.begin(), slip.end(), 0.0) / n;
    double ls = 0.0, ll = 0.0, ss = 0.0;
    for (std::size_t i = 0; i < level.size(); ++i) {
      ls += (level[i] - ml) * (slip[i] - ms);
      ll += (level[i] - ml) * (level[i] - ml);
      ss += (slip[i] - ms) * (slip[i] - ms);
    }
    const double r = ll > 0.0 && ss > 0.0 ? ls / std::sqrt(ll * ss) : 0.0;
    if (std::abs(r) > 0.8 && std::sqrt(ll / n) > 2.0 * evidence.noise.front()[index_of(channel)].run_offset)
      text += fmt::format("; the level of {} follows slip (correlation {:+.2f})", name_of(channel), r);
  }
  return text;
}

std::string told(const std::vector<RecordingError>& errors) {
  std::string text;
  for (const RecordingError& error : errors) {
    text += fmt::format("{}{} (in {}", text.empty() ? "Recording: " : "; ", error.what, error.runs.front());
    text += error.runs.size() > 1 ? fmt::format(" to {})", error.runs.back()) : ")";
  }
  return text.empty() ? text : text + ". It was put right before what follows. ";
}

std::string effect_list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "nothing" : text;
}

}  // namespace wheel_twin::twin
