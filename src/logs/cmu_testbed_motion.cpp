#include "logs/cmu_testbed_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace wheel_twin::logs::cmu {
namespace {

// Days since 1970-01-01 of a date of the Gregorian calendar (H. Hinnant, days_from_civil).
std::int64_t days_of(std::int64_t year, int month, int day) {
  year -= month <= 2 ? 1 : 0;
  const std::int64_t era = year / 400;
  const std::int64_t year_of_era = year - era * 400;
  const std::int64_t day_of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return era * 146097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719468;
}

// Local time at which the n-th Sunday of a month begins, s since 1970.
double sunday(std::int64_t year, int month, int n) {
  const std::int64_t first = days_of(year, month, 1);
  const std::int64_t weekday = (first + 4) % 7;  // 1970-01-01 was a Thursday; 0 is Sunday
  return 86400.0 * static_cast<double>(first + (7 - weekday) % 7 + std::int64_t{7} * (n - 1));
}

struct Line {
  double offset = 0.0;
  double slope = 1.0;
};

// computer = offset + slope controller, over the stamps that are not late.
Line fit_clock(const std::vector<double>& controller, const std::vector<double>& computer) {
  std::vector<char> used(controller.size(), 1);
  Line line;
  for (int pass = 0; pass < 6; ++pass) {
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (std::size_t i = 0; i < controller.size(); ++i) {
      if (!used[i]) continue;
      const double x = controller[i] - controller.front(), y = computer[i] - computer.front();
      n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    line.slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    line.offset = (sy - line.slope * sx) / n;
    double variance = 0.0;
    const auto residual = [&](std::size_t i) {
      return computer[i] - computer.front() - line.offset - line.slope * (controller[i] - controller.front());
    };
    for (std::size_t i = 0; i < controller.size(); ++i)
      if (used[i]) variance += residual(i) * residual(i) / n;
    for (std::size_t i = 0; i < controller.size(); ++i)
      used[i] = residual(i) < 2.0 * std::sqrt(variance) + 1e-4 ? 1 : 0;
  }
  return line;
}

std::vector<double> without_spikes(const std::vector<double>& readings, std::size_t& spikes) {
  constexpr double limit = 8.0;  // mm/s: five times the largest scatter of a steady reading
  std::vector<double> cleaned = readings;
  for (std::size_t i = 2; i + 2 < readings.size(); ++i) {
    std::array<double, 5> near{};
    std::copy_n(readings.begin() + static_cast<std::ptrdiff_t>(i) - 2, 5, near.begin());
    std::nth_element(near.begin(), near.begin() + 2, near.end());
    if (std::abs(readings[i] - near[2]) > limit) {
      cleaned[i] = near[2];
      ++spikes;
    }
  }
  return cleaned;
}

// Travelled distance over the integral of the logged speed: median over blocks of 4 s, for a carriage at the
// end of its belt stands still while the reading does not know. 1 where the carriage never runs.
double speed_factor(const Kinematics& kinematics, const std::vector<double>& time) {
  constexpr double block = 4.0, running = 5.0;  // s, mm/s
  std::vector<double> factors;
  std::size_t from = 0;
  double integral = 0.0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    integral += 0.5 * (kinematics.vx_mm_s[i] + kinematics.vx_mm_s[i - 1]) * (time[i] - time[i - 1]);
    if (time[i] - time[from] < block) continue;
    if (integral > running * block)
      factors.push_back((kinematics.x_mm[i] - kinematics.x_mm[from]) / integral);
    from = i;
    integral = 0.0;
  }
  if (factors.size() < 3) return 1.0;
  const auto middle = factors.begin() + static_cast<std::ptrdiff_t>(factors.size() / 2);
  std::nth_element(factors.begin(), middle, factors.end());
  return *middle;
}

}  // namespace

int hours_behind_utc(double local_time) {
  const auto year = static_cast<std::int64_t>(std::floor(1970.0 + local_time / (365.2425 * 86400.0)));
  // US rule since 2007: from the second Sunday of March to the first Sunday of November, 2 h local time.
  const bool summer = local_time >= sunday(year, 3, 2) + 7200.0 && local_time < sunday(year, 11, 1) + 7200.0;
  return summer ? 4 : 5;
}

Motion to_motion(const Kinematics& kinematics, int hours_behind, bool wheel_locked, double locked_from) {
  Motion motion;
  // After the run the controller goes on sending its last readings: rows in which nothing ever changes again.
  std::size_t n = kinematics.size();
  const auto moved = [&](std::size_t i) {
    return kinematics.x_mm[i] != kinematics.x_mm[i - 1] ||
           kinematics.vx_mm_s[i] != kinematics.vx_mm_s[i - 1] || kinematics.z_mm[i] != kinematics.z_mm[i - 1];
  };
  while (n > 10 && !moved(n - 1)) --n;
  motion.frozen = kinematics.size() - n;
  const Line clock = fit_clock(kinematics.controller_s, kinematics.computer_s);
  motion.clock_skew = clock.slope - 1.0;
  motion.epoch = kinematics.computer_s.front() + clock.offset + 3600.0 * hours_behind;
  motion.time.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    motion.time[i] = clock.slope * (kinematics.controller_s[i] - kinematics.controller_s.front());
    motion.late_stamp = std::max(motion.late_stamp, kinematics.computer_s[i] - kinematics.computer_s.front() -
                                                        clock.offset - motion.time[i]);
  }
  motion.rate = static_cast<double>(n - 1) / motion.time.back();

  const std::vector<double> rim = without_spikes(kinematics.vry_mm_s, motion.spikes);
  motion.speed_factor = speed_factor(kinematics, motion.time);

  motion.carriage_position.resize(n);
  motion.carriage_velocity.resize(n);
  motion.wheel_angle.resize(n);
  motion.wheel_rate.resize(n);
  motion.z.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    motion.carriage_position[i] = 1e-3 * (kinematics.x_mm[i] - kinematics.x_mm.front());
    motion.carriage_velocity[i] = 1e-3 * motion.speed_factor * kinematics.vx_mm_s[i];
    const bool locked = wheel_locked && motion.time[i] >= locked_from;
    motion.wheel_rate[i] = locked ? 0.0 : 1e-3 * motion.speed_factor * rim[i] / controller_radius;
    if (i > 0)
      motion.wheel_angle[i] =
          motion.wheel_angle[i - 1] +
          0.5 * (motion.wheel_rate[i] + motion.wheel_rate[i - 1]) * (motion.time[i] - motion.time[i - 1]);
    motion.z[i] = 1e-3 * kinematics.z_mm[i];
  }
  return motion;
}

}  // namespace wheel_twin::logs::cmu
