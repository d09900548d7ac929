#include "twin/certify.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/random.h"

namespace wheel_twin::twin {
namespace {

/// Two-sided tail of a standard normal deviate, or of Student's t where its error is known by few values.
double tail(double z, std::optional<double> freedom) {
  if (!freedom) return std::erfc(std::abs(z) / std::sqrt(2.0));
  return 2.0 * boost::math::cdf(boost::math::complement(boost::math::students_t(*freedom), std::abs(z)));
}

/// Projection of a residual on a course over the bins, generalised for the correlation of neighbouring bins:
/// value and standard error.
struct Projection {
  double value = 0.0;
  double error = 0.0;
};

Projection project(const std::vector<double>& residual, const std::vector<double>& course, double deviation,
                   double keep) {
  double cc = 0.0, rc = 0.0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    cc += course[i] * course[i];
    rc += residual[i] * course[i];
  }
  if (cc <= 0.0) return {};
  const double inflation = (1.0 + keep) / (1.0 - keep);
  return {rc / cc, deviation * std::sqrt(inflation / cc)};
}

/// Share of sign flips of `votes` whose sum reaches theirs.
double sign_flip_p(const std::vector<double>& votes) {
  constexpr int flips = 20000;
  double sum = 0.0, square = 0.0;
  for (const double v : votes) sum += v, square += v * v;
  if (sum <= 0.0) return 1.0;
  Random random(1, 17);
  int reached = 0;
  for (int k = 0; k < flips; ++k) {
    double flipped = 0.0;
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < votes.size(); ++i, bits >>= 1) {
      if (i % 64 == 0) bits = random.bits();
      flipped += (bits & 1U) != 0U ? votes[i] : -votes[i];
    }
    if (flipped >= sum) ++reached;
  }
  // Hoeffding's bound holds for the flips, given the magnitudes; it tells what drawn flips do not resolve.
  const double bound = std::exp(-0.5 * sum * sum / square);
  return reached > 0 ? (1.0 + reached) / (1.0 + flips) : std::min(bound, 1.0 / flips);
}

void centre(std::vector<double>& course) {
  double mean = 0.0;
  for (const double v : course) mean += v / static_cast<double>(course.size());
  for (double& v : course) v -= mean;
}

}  // namespace

double certify(const Evidence& evidence, const Candidate& nothing, const Candidate& candidate) {
  std::vector<std::size_t> halves[2];
  for (std::size_t r = 0; r < evidence.runs.size(); ++r) halves[r % 2].push_back(r);
  if (halves[1].empty()) return 1.0;
  std::vector<double> votes;
  for (int h = 0; h < 2; ++h) {
    Candidate base = nothing;
    if (!evidence.nuisance.empty())
      base = fit_candidate(evidence_of(nothing, evidence), nothing.effects, halves[1 - h], nothing.values, 6);
    const Candidate fitted = fit_candidate(evidence_of(candidate, evidence), candidate.effects, halves[1 - h],
                                           candidate.values, 6);
    if (!fitted.usable || !base.usable) return 1.0;
    for (const std::size_t r : halves[h]) {
      std::vector<int> block;
      std::vector<double> without, with;
      try {
        without = run_residuals(evidence, r, base.model, false, &block);
        with = run_residuals(evidence, r, fitted.model, fitted.fluctuates);
      } catch (const Error&) {
        return 1.0;  // a wheel that sinks to its axle where it was not fitted foretells nothing
      }
      struct Block {
        double along = 0.0, square = 0.0;
      };
      std::map<int, Block> blocks;
      for (std::size_t i = 0; i < without.size(); ++i) {
        const double prediction = without[i] - with[i];
        blocks[block[i]].along += without[i] * prediction;
        blocks[block[i]].square += prediction * prediction;
      }
      // Each block votes with the share of the prediction that it shows, between -1 and 1, and counts as its
      // prediction stands out of the noise, at most as one of two deviations: no block, however loud, decides
      // alone.
      for (const auto& entry : blocks) {
        const Block& b = entry.second;
        if (b.square < 1e-6) continue;
        votes.push_back(std::min(4.0, b.square) * std::clamp(b.along / b.square, -1.0, 1.0));
      }
    }
  }
  return sign_flip_p(votes);
}

Omnibus ask_residual(const Evidence& evidence, const TwinConfig& model, bool fluctuates) {
  Omnibus result;
  int asked = 0;
  std::vector<double> lags;
  const auto note = [&](const std::string& run, Channel channel, const char* feature, double size,
                        double error, std::optional<double> freedom = std::nullopt) {
    if (!std::isfinite(size) || !(error > 0.0)) return;
    const auto own = evidence.left_of_references.find({channel, feature});
    if (own != evidence.left_of_references.end()) error = std::hypot(error, own->second);
    ++asked;
    result.findings.push_back({run, channel, feature, size, size / error, tail(size / error, freedom), {}});
  };
  for (std::size_t r = 0; r < evidence.runs.size(); ++r) {
    const RunGrid& grid = *evidence.runs[r];
    Fluctuating simulated;
    if (fluctuates && evidence.fluctuation.known) {
      simulated = simulate_fluctuating(model, grid, evidence.fluctuation_of(r));
    } else {
      simulated.course = simulate(model, grid);
      if (evidence.fluctuation.known) simulated.log_deviation = evidence.calm[r];
    }
    const Residual residual = residual_of(grid, simulated.course);
    const LogDeviation& predicted = simulated.log_deviation;
    const LogDeviation measured_deviation = mean_of(evidence.log_deviation[r]);
    for (const Channel channel : all_channels) {
      const auto c = static_cast<Eigen::Index>(index_of(channel));
      const ChannelNoise& noise = evidence.noise[r][static_cast<std::size_t>(c)];
      std::vector<double> values, level, time, turn_cos, turn_sin;
      for (int i = 0; i < grid.bins(); ++i) {
        if (!grid.moving[static_cast<std::size_t>(i)] || !std::isfinite(residual.bins(c, i))) continue;
        values.push_back(residual.bins(c, i));
        level.push_back(1.0);
        time.push_back(grid.time(i));
        turn_cos.push_back(std::cos(grid.motion[static_cast<std::size_t>(i)].wheel_angle));
        turn_sin.push_back(std::sin(grid.motion[static_cast<std::size_t>(i)].wheel_angle));
      }
      if (values.size() < 12) continue;
      // A run that shakes more than its neighbours in slip and load is told of as fluctuation, not as a
      // level.
      const double deviation = std::max(noise.deviation, robust_deviation(without_level(values)));
      const Projection mean = project(values, level, deviation, noise.keep);
      note(grid.name, channel, "level", mean.value, std::hypot(mean.error, noise.run_offset),
           evidence.slow_freedom);
      for (auto* course : {&time, &turn_cos, &turn_sin}) centre(*course);
      const double span = time.back() - time.front();
      const Projection trend = project(values, time, deviation, noise.keep);
      note(grid.name, channel, "trend", trend.value * span, trend.error * span, evidence.slow_freedom);
      for (const auto* course : {&turn_cos, &turn_sin}) {
        const Projection turn = project(values, *course, deviation, noise.keep);
        note(grid.name, channel, "turn", turn.value, turn.error);
      }
      // A place: the largest mean over four seconds, less the run's own level, against what such means
      // scatter by, so that slow noise is not one. Not the first: how a wheel leaves its print is the soil's.
      const auto width = static_cast<std::size_t>(std::max(2.0, 4.0 / grid.bin));
      std::vector<double> places;
      for (std::size_t begin = width; begin + width <= values.size(); begin += width) {
        double sum = 0.0;
        for (std::size_t i = begin; i < begin + width; ++i)
          sum += (values[i] - mean.value) / static_cast<double>(width);
        places.push_back(sum);
      }
      if (!places.empty()) {
        const double error = std::max(
            deviation * std::sqrt((1.0 + noise.keep) / (1.0 - noise.keep) / static_cast<double>(width)),
            robust_deviation(places));
        const double worst = *std::max_element(places.begin(), places.end(),
                                               [](double a, double b) { return std::abs(a) < std::abs(b); });
        note(grid.name, channel, "place", worst, error);
        asked += static_cast<int>(places.size()) - 1;
      }
      if (evidence.fluctuation.known)
        note(grid.name, channel, "fluctuation",
             measured_deviation[static_cast<std::size_t>(c)] - predicted[static_cast<std::size_t>(c)], 0.25);
    }
    lags.insert(lags.end(), evidence.lag[r].begin(), evidence.lag[r].end());
  }
  if (!lags.empty()) {
    // A clock is late in every run alike: one question.
    const auto n = static_cast<double>(lags.size());
    const double late = std::accumulate(lags.begin(), lags.end(), 0.0) / n - draw_wire_delay(model);
    note("all runs", Channel::hub_displacement, "lag", late, evidence.lag_error / std::sqrt(n));
  }
  double off = 0.0, known = 0.0;
  for (std::size_t r = 0; r < evidence.zero.size(); ++r) {
    if (!std::isfinite(evidence.zero[r])) continue;
    off += evidence.zero[r] - zero_of(model, *evidence.runs[r]);
    known += 1.0;
  }
  if (known > 0.0)
    note("all runs", Channel::hub_displacement, "zero", off / known, evidence.zero_error / std::sqrt(known));
  for (const SharedTone& shared : evidence.tones) {
    ++asked;
    const Tone& tone = shared.tone;
    const double z = std::sqrt(-2.0 * std::log(std::clamp(tone.p, 1e-300, 1.0)));  // of such a tail, about
    result.findings.push_back({"most runs", shared.channel, "tone", tone.amplitude, z, tone.p, shared});
  }
  std::sort(result.findings.begin(), result.findings.end(),
            [](const Finding& a, const Finding& b) { return std::abs(a.z) > std::abs(b.z); });
  for (const Finding& f : result.findings) result.p = std::min(result.p, asked * f.p);
  return result;
}

}  // namespace wheel_twin::twin
