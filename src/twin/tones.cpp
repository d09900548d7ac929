#include "twin/tones.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "logs/statistics.h"

namespace wheel_twin::twin {
namespace {

constexpr std::size_t fewest_samples = 256;
constexpr std::size_t most_lines = 12;    // that are kept of a channel
constexpr double doubtful = 1e-2;         // p above which a line is no tone
constexpr double same_frequency = 0.03;   // relative
constexpr int own_width = 3, reach = 60;  // of a line and of what is about it, in 1/length
constexpr double highest_of_rate = 0.45;

std::vector<Tone> lines_of(const std::vector<double>& values, double rate, double lowest) {
  std::vector<Tone> tones;
  const std::vector<double> trend_free = logs::without_line(values);
  const auto n = static_cast<Eigen::Index>(trend_free.size());
  const double deviation = std::sqrt(Eigen::Map<const Eigen::VectorXd>(trend_free.data(), n).squaredNorm() /
                                     static_cast<double>(n));
  if (deviation == 0.0) return tones;
  // Hann's window, whose mean is one half.
  std::vector<double> windowed(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i)
    windowed[static_cast<std::size_t>(i)] =
        trend_free[static_cast<std::size_t>(i)] *
        (1.0 - std::cos(2.0 * M_PI * (static_cast<double>(i) + 0.5) / static_cast<double>(n)));
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(transform, windowed);
  std::vector<double> power;
  for (const std::complex<double>& c : transform) power.push_back(std::norm(c));
  const double step = rate / static_cast<double>(n);
  const int first = std::max(4 * own_width, static_cast<int>(std::ceil(lowest / step)));
  const int last =
      std::min(static_cast<int>(power.size()) - 2, static_cast<int>(highest_of_rate * rate / step));
  for (int k = first; k <= last; ++k) {
    const auto at = [&](int i) { return power[static_cast<std::size_t>(i)]; };
    if (at(k) < at(k - 1) || at(k) < at(k + 1)) continue;
    std::vector<double> about;
    const int far = std::min(reach, k / 2);  // no further than a colour changes
    for (int i = k - far; i <= std::min(last, k + far); ++i)
      if (std::abs(i - k) > own_width) about.push_back(at(i));
    // Two of its standard errors above the median, so that few values about a line make none.
    const double background =
        logs::median(about) * (1.0 + 2.0 / std::sqrt(static_cast<double>(about.size())));
    if (background <= 0.0) continue;
    // 2^-x is the share of an exponential distribution beyond x medians.
    const double p = std::min(1.0, (last - first + 1) * std::exp2(-at(k) / background));
    if (p > doubtful) continue;
    // Between two frequencies by the ratio of neighbouring lines of Hann's window.
    const bool right = at(k + 1) > at(k - 1);
    const double ratio = std::sqrt(at(right ? k + 1 : k - 1) / at(k));
    const double shift = std::clamp((2.0 * ratio - 1.0) / (ratio + 1.0), 0.0, 0.5) * (right ? 1.0 : -1.0);
    const double lost =
        std::abs(shift) < 1e-6 ? 1.0 : std::sin(M_PI * shift) / (M_PI * shift) / (1.0 - shift * shift);
    tones.push_back(
        {(k + shift) * step, 2.0 * std::sqrt(at(k)) / static_cast<double>(n) / lost, deviation, p});
  }
  std::sort(tones.begin(), tones.end(),
            [](const Tone& a, const Tone& b) { return a.amplitude > b.amplitude; });
  if (tones.size() > most_lines) tones.resize(most_lines);
  return tones;
}

/// `values` hold `of(value)` at each of `times`; nothing where the log lacks them.
template <typename Value, typename Of>
std::vector<Tone> lines_between(const std::vector<double>& times, const std::vector<Value>& values,
                                const Of& of, double begin, double end, double lowest) {
  if (values.size() != times.size()) return {};
  std::vector<double> chosen;
  double from = 0.0, to = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (times[i] < begin || times[i] > end) continue;
    if (chosen.empty()) from = times[i];
    to = times[i];
    chosen.push_back(of(values[i]));
  }
  if (chosen.size() < fewest_samples || !(to > from)) return {};
  return lines_of(chosen, static_cast<double>(chosen.size() - 1) / (to - from), lowest);
}

/// Cycles per second, metre or turn of a tone; zero where the run does not move so.
double frequency_by(Follows follows, const RunTones& run, const Tone& tone) {
  if (follows == Follows::time) return tone.frequency;
  const double speed =
      follows == Follows::travel ? std::abs(run.carriage_speed) : std::abs(run.wheel_rate) / (2.0 * M_PI);
  return speed > 0.0 ? tone.frequency / speed : 0.0;
}

const Tone* line_at(const RunTones& run, std::size_t channel, Follows follows, double frequency) {
  for (const Tone& line : (*run.tones)[channel])
    if (std::abs(frequency_by(follows, run, line) / frequency - 1.0) < same_frequency) return &line;
  return nullptr;
}

}  // namespace

Tones tones_of(const run_log::RunLog& log, double begin, double end, double lowest) {
  const auto same = [](double value) { return value; };
  Tones tones;
  for (int axis = 0; axis < 3; ++axis) {
    constexpr std::array<Channel, 3> forces = {Channel::drawbar_pull, Channel::side_force,
                                               Channel::normal_load};
    tones[index_of(forces[static_cast<std::size_t>(axis)])] = lines_between(
        log.ft.time, log.ft.force, [axis](const Eigen::Vector3d& f) { return f[axis]; }, begin, end, lowest);
  }
  tones[index_of(Channel::pitch_torque)] = lines_between(
      log.ft.time, log.ft.torque, [](const Eigen::Vector3d& t) { return t.y(); }, begin, end, lowest);
  tones[index_of(Channel::hub_displacement)] =
      lines_between(log.draw_wire.time, log.draw_wire.value, same, begin, end, lowest);
  tones[index_of(Channel::motor_effort)] =
      lines_between(log.joints.time, log.joints.wheel_effort, same, begin, end, lowest);
  return tones;
}

std::vector<SharedTone> shared_tones(const std::vector<RunTones>& runs,
                                     const std::vector<RunTones>& references, double share) {
  std::vector<SharedTone> shared;
  for (const Channel channel : all_channels) {
    const std::size_t c = index_of(channel);
    for (const Follows follows : {Follows::time, Follows::wheel, Follows::travel}) {
      std::vector<SharedTone> found;
      for (const RunTones& run : runs)
        for (const Tone& tone : (*run.tones)[c]) {
          const double frequency = frequency_by(follows, run, tone);
          if (frequency == 0.0 || tone.amplitude < share * std::sqrt(2.0) * tone.deviation) continue;
          const bool told = std::any_of(found.begin(), found.end(), [&](const SharedTone& f) {
            return std::abs(frequency / f.frequency - 1.0) < same_frequency;
          });
          const bool known =
              std::any_of(references.begin(), references.end(), [&](const RunTones& reference) {
                return line_at(reference, c, follows, frequency) != nullptr;
              });
          if (told || known) continue;
          std::vector<Tone> same;
          for (const RunTones& other : runs)
            if (const Tone* line = line_at(other, c, follows, frequency)) same.push_back(*line);
          if (2 * same.size() <= runs.size()) continue;
          std::sort(same.begin(), same.end(),
                    [](const Tone& a, const Tone& b) { return a.amplitude < b.amplitude; });
          found.push_back(
              {channel, follows, frequency, same[same.size() / 2], static_cast<int>(same.size())});
        }
      shared.insert(shared.end(), found.begin(), found.end());
      if (!found.empty()) break;
    }
  }
  return shared;
}

}  // namespace wheel_twin::twin
