#include "logs/cmu_testbed.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

#include "base/atomic_file.h"
#include "base/config_path.h"
#include "base/error.h"
#include "base/progress.h"
#include "logs/bag_writer.h"
#include "logs/cmu_testbed_bag.h"
#include "logs/cmu_testbed_motion.h"
#include "logs/cmu_testbed_plates.h"
#include "logs/cmu_testbed_tables.h"
#include "logs/experiment.h"

namespace wheel_twin::logs::cmu {
namespace {

namespace fs = std::filesystem;

constexpr double pi = 3.14159265358979323846;
constexpr double raised_mm = 31.5;      // the wheel above its zero at the first row of a driving run
constexpr double declared_load = 25.0;  // the dead weight, about; N
constexpr double fallback_cycle_error =
    0.385e-3;  // s, see cmu_testbed_motion.h; used when no run has kinematics

std::string path_of(const std::string& directory, const std::string& name) {
  return (fs::path(directory) / name).string();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// One remark for all runs with the same oddity.
class Oddities {
 public:
  void add(const std::string& kind, const std::string& where, double size) {
    Entry& entry = entries_[kind];
    ++entry.count;
    if (entry.count == 1 || std::abs(size) > std::abs(entry.worst)) {
      entry.worst = size;
      entry.where = where;
    }
  }
  void report(std::vector<std::string>& remarks) const {
    for (const auto& [kind, entry] : entries_)
      remarks.push_back(fmt::format("{} ({} run{}; most: {:.3g} in {})", kind, entry.count,
                                    entry.count == 1 ? "" : "s", entry.worst, entry.where));
  }

 private:
  struct Entry {
    std::size_t count = 0;
    double worst = 0.0;
    std::string where;
  };
  std::map<std::string, Entry> entries_;
};

struct ImportedRun {
  RunRow row;
  std::optional<Motion> motion;
  double speed_factor = 1.0;  // on both logged speeds
};

// Means of the logged columns over the window, to be compared with runs.csv.
void check_window(const RunRow& row, const Kinematics& kinematics, const std::string& name,
                  Oddities& oddities) {
  double n = 0.0, vx = 0.0, vry = 0.0, z = 0.0;
  for (std::size_t i = 0; i < kinematics.size(); ++i) {
    const double time = kinematics.computer_s[i] - kinematics.computer_s.front();
    if (time < row.window_start_s || time > row.window_end_s) continue;
    n += 1.0, vx += kinematics.vx_mm_s[i], vry += kinematics.vry_mm_s[i], z += kinematics.z_mm[i];
  }
  if (n < 10.0) {
    oddities.add("the window of runs.csv lies outside the kinematics", name, row.window_start_s);
    return;
  }
  const double sinkage = -(z / n - kinematics.z_mm.front() + raised_mm);
  if (std::abs(sinkage - row.sinkage_mm.mean) > 0.05)
    oddities.add("sinkage in runs.csv differs from the kinematics, mm", name, sinkage - row.sinkage_mm.mean);
  if (std::abs(vx / n - row.vx_mm_s) > 0.02)
    oddities.add("Vx in runs.csv differs from the kinematics, mm/s", name, vx / n - row.vx_mm_s);
  if (row.vry_command_mm_s != 0.0 && std::abs(vry / n - row.vry_mm_s) > 0.02)
    oddities.add("Vry in runs.csv differs from the kinematics, mm/s", name, vry / n - row.vry_mm_s);
}

void check_row(const RunRow& row, const std::string& name, Oddities& oddities) {
  const double fastest = std::max(row.vx_mm_s, row.vry_mm_s);
  const double slip = fastest > 0.0 ? (row.vry_mm_s - row.vx_mm_s) / fastest : 0.0;
  if (std::abs(slip - row.slip) > 0.005)
    oddities.add("slip is not (Vry - Vx)/max(Vx, Vry)", name, slip - row.slip);
  if (row.vry_command_mm_s > 0.0 && std::abs(row.vry_mm_s / row.vry_command_mm_s - 1.0) > 0.03)
    oddities.add("rim speed ran otherwise than commanded, ratio (the measured one is used)", name,
                 row.vry_mm_s / row.vry_command_mm_s);
  if (std::abs(row.angle_deg - row.beta_deg) > 0.5)
    oddities.add("steering angle is off the commanded one, degrees (the measured one is used)", name,
                 row.angle_deg - row.beta_deg);
  if (row.load_n.mean < 0.0) oddities.add("normal load is negative, N: sign or tare", name, row.load_n.mean);
}

void check_motion(const Motion& motion, const std::string& name, Oddities& oddities) {
  if (std::abs(motion.speed_factor - 1.0) > 0.05)
    oddities.add("speed readings disagree with the position by more than the cycle error explains, factor",
                 name, motion.speed_factor);
  if (std::abs(motion.clock_skew) > 0.005)
    oddities.add("controller clock is off the computer's, fraction", name, motion.clock_skew);
  if (motion.late_stamp > 0.5)
    oddities.add("computer stamps came late, s (the controller clock is used)", name, motion.late_stamp);
  if (motion.frozen > 0)
    oddities.add("rows at the end that repeat the last reading left out", name,
                 static_cast<double>(motion.frozen));
  if (motion.spikes > 0)
    oddities.add("single wrong readings of the rim speed replaced by their neighbours", name,
                 static_cast<double>(motion.spikes));
}

run_log::RunLog log_of(const RunRow& row, const Motion& motion) {
  run_log::RunLog log;
  log.epoch = std::floor(motion.epoch * 1e6) * 1e-6;
  log.joints.time = motion.time;
  log.joints.carriage_position = motion.carriage_position;
  log.joints.carriage_velocity = motion.carriage_velocity;
  log.joints.wheel_angle = motion.wheel_angle;
  log.joints.wheel_rate = motion.wheel_rate;
  log.draw_wire.time = motion.time;
  for (const double z : motion.z) log.draw_wire.value.push_back(-(z - 1e-3 * row.z0_mm + 1e-3 * raised_mm));
  return log;
}

// The sensor hangs below the steering axis: its readings are in the wheel's axes. The standard deviations are
// turned as those of readings that scatter independently; the table has no covariance.
void turn_to_rig_axes(double steering_angle, Average& along, Average& across) {
  const double c = std::cos(steering_angle), s = std::sin(steering_angle);
  const Average x = along, y = across;
  along = {c * x.mean - s * y.mean, std::hypot(c * x.std.value_or(0.0), s * y.std.value_or(0.0))};
  across = {s * x.mean + c * y.mean, std::hypot(s * x.std.value_or(0.0), c * y.std.value_or(0.0))};
}

Run entry_of(const RunRow& row, double speed_factor) {
  Run run;
  run.role = Role::measured;
  run.slip = row.slip;
  run.load = declared_load;
  // As everywhere here (rig/speeds.h): of the faster of rim and carriage, the slip says the rest.
  run.wheel_speed = 1e-3 * speed_factor * std::max(row.vx_mm_s, row.vry_mm_s) / controller_radius;
  // Lateral is positive to the sensor's +x, which is the right; a positive beta turns the wheel there.
  run.steering_angle = -row.angle_deg * pi / 180.0;
  run.group = row.day;
  Averages averages;
  averages.window_start = row.window_start_s;
  averages.window_end = row.window_end_s;
  Average along{row.tractive_n.mean, row.tractive_n.std}, across{-row.lateral_n.mean, row.lateral_n.std};
  if (run.steering_angle != 0.0) turn_to_rig_axes(run.steering_angle, along, across);
  averages.drawbar_pull = along;
  averages.side_force = across;
  averages.normal_load = Average{row.load_n.mean, row.load_n.std};
  averages.hub_displacement = Average{1e-3 * row.sinkage_mm.mean, 1e-3 * row.sinkage_mm.std};
  run.averages = averages;
  return run;
}

std::vector<ImportedRun> read_driving_runs(const std::string& directory, ImportSummary& summary) {
  Oddities oddities;
  std::vector<ImportedRun> runs;
  const std::vector<RunRow> rows = read_runs(path_of(directory, "runs.csv"), summary.remarks);
  Progress progress("reading runs", static_cast<double>(rows.size()));
  std::vector<double> cycle_errors, skews;
  std::size_t without = 0, steered = 0;
  for (const RunRow& row : rows) {
    ImportedRun run;
    run.row = row;
    const std::string name = fmt::format("{}/{}/{}", row.wheel, row.day, row.file);
    check_row(row, name, oddities);
    if (std::abs(row.angle_deg) > 1.0) ++steered;
    const std::string file = path_of(directory, fmt::format("kinematics/{}.txt", name));
    if (fs::is_regular_file(file)) {
      const Kinematics kinematics = read_kinematics(file, summary.remarks);
      if (std::abs(kinematics.z_mm.front() - row.z0_mm) > 0.05 ||
          std::abs(kinematics.computer_s.front() - row.start_epoch_local) > 1.0)
        throw Error(fmt::format(
            "{}: starts at Z {:.2f} mm and computer time {:.1f} s, runs.csv says {:.2f} and {:.1f}: the "
            "file of another run",
            file, kinematics.z_mm.front(), kinematics.computer_s.front(), row.z0_mm, row.start_epoch_local));
      check_window(row, kinematics, name, oddities);
      run.motion =
          to_motion(kinematics, hours_behind_utc(row.start_epoch_local), row.vry_command_mm_s == 0.0);
      check_motion(*run.motion, name, oddities);
      cycle_errors.push_back((run.motion->speed_factor - 1.0) / run.motion->rate);
      skews.push_back(run.motion->clock_skew);
    } else {
      ++without;
    }
    runs.push_back(std::move(run));
    progress.update(static_cast<double>(runs.size()));
  }
  oddities.report(summary.remarks);
  if (steered > 0)
    summary.remarks.push_back(fmt::format(
        "the sensor turns with the wheel: forces of {} steered runs turned into rig axes", steered));
  if (without > 0)
    summary.remarks.push_back(
        fmt::format("{} of {} runs have no kinematics: window averages alone", without, rows.size()));
  if (!cycle_errors.empty()) {
    summary.remarks.push_back(
        fmt::format("speeds: readings are low against the position, by {:.3f} ms of each cycle (median): "
                    "both speeds corrected, slip unchanged",
                    1e3 * median(cycle_errors)));
    summary.remarks.push_back(
        fmt::format("clocks: the controller's runs {:.3f} % slow against the computer's (median)",
                    100.0 * median(skews)));
  }
  const double cycle_error = cycle_errors.empty() ? fallback_cycle_error : median(cycle_errors);
  for (ImportedRun& run : runs)
    run.speed_factor = run.motion ? run.motion->speed_factor : 1.0 + cycle_error * run.row.rate_hz;
  return runs;
}

// Recordings of the hanging wheel: what the tare was, and how it moves with temperature.
std::optional<DeclaredSensor> read_zeros(const std::string& directory, const std::string& out,
                                         ImportSummary& summary) {
  std::vector<std::string> files;
  if (fs::is_directory(path_of(directory, "zero")))
    for (const auto& entry : fs::directory_iterator(path_of(directory, "zero")))
      if (entry.path().extension() == ".bag") files.push_back(entry.path().string());
  if (files.empty()) {
    summary.remarks.emplace_back(
        "no recordings of the hanging wheel (zero/*.bag): the scatter of the tare is unknown");
    return std::nullopt;
  }
  std::sort(files.begin(), files.end());
  std::string csv =
      "file,time_s,temperature_c,drawbar_pull_n,side_force_n,normal_load_n,std_x_n,std_y_n,std_z_n\n";
  double noise = 0.0, sum_t = 0.0, sum_tt = 0.0, sum_f = 0.0, sum_tf = 0.0;
  const auto n = static_cast<double>(files.size());
  for (const std::string& file : files) {
    const FtRecording recording = read_ft(file);
    if (recording.acceleration.z() > -0.9 || recording.acceleration.z() < -1.1)
      summary.remarks.push_back(
          fmt::format("{}: the sensor's accelerometer reads {:.2f} g along its z, not -1: mounted "
                      "otherwise, or tilted",
                      file, recording.acceleration.z()));
    const Tare tare = tare_of(recording);
    const Eigen::Vector3d force = to_rig_axes(tare.force);
    csv += fmt::format("{},{:.3f},{:.2f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n",
                       fs::path(file).filename().string(), tare.time, tare.temperature, force.x(), force.y(),
                       force.z(), tare.force_std.y(), tare.force_std.x(), tare.force_std.z());
    noise += tare.force_std.norm() / std::sqrt(3.0) / n;
    sum_t += tare.temperature, sum_tt += tare.temperature * tare.temperature;
    sum_f += force.z(), sum_tf += force.z() * tare.temperature;
  }
  write_file(path_of(out, "zeros.csv"), csv);
  const double spread = sum_tt - sum_t * sum_t / n;
  if (files.size() > 3 && spread > 0.5)
    summary.remarks.push_back(
        fmt::format("tare: the zero of the normal load moves by {:+.2f} N a kelvin of the sensor over {} "
                    "recordings ({:.1f} K): loads of a day carry that error",
                    (sum_tf - sum_t * sum_f / n) / spread, files.size(), std::sqrt(spread / n)));
  return DeclaredSensor{100.0, std::round(noise * 1e3) * 1e-3, 0.0};
}

void write_one(const std::string& wheel, const std::vector<ImportedRun>& runs,
               const std::vector<Pressing>& pressings, const std::optional<DeclaredSensor>& ft,
               const std::string& out, ImportSummary& summary) {
  ImportSummary::PerWheel counts;
  counts.wheel = wheel;
  counts.directory = path_of(out, wheel);
  fs::create_directories(path_of(counts.directory, "bags"));
  Experiment experiment;
  experiment.name = "cmu_testbed_" + wheel;
  experiment.wheel = terramechanics::read_wheel(yaml::parse_file(find_config("wheels", "cmu_" + wheel)));
  experiment.soil = terramechanics::read_soil(yaml::parse_file(find_config("soils", "cmu_sand")));
  experiment.ft = ft;
  experiment.draw_wire = DeclaredSensor{73.0, 1e-5, 1e-5};
  experiment.source =
      "Single-wheel testbed of the Robomechanics Lab, Carnegie Mellon University; copyright 2022 Catherine "
      "Pavlov, Carnegie Mellon University, MIT licence";
  for (const ImportedRun& imported : runs) {
    if (imported.row.wheel != wheel) continue;
    Run run = entry_of(imported.row, imported.speed_factor);
    if (imported.motion) {
      run.bag = fmt::format("bags/{}_{}.bag", imported.row.day, imported.row.file);
      write_bag(log_of(imported.row, *imported.motion), path_of(counts.directory, *run.bag));
      ++counts.bags;
    }
    experiment.runs.push_back(run);
    ++counts.runs;
  }
  for (const Pressing& pressing : pressings) {
    const std::string& indenter = pressing.row.indenter;
    if (indenter.rfind("wheel_", 0) == 0 && indenter != "wheel_" + wheel) continue;
    PlateTest test;
    test.bag = fmt::format("bags/{}.bag", pressing.name);
    test.indenter = indenter.substr(0, indenter.find("_smooth"));
    test.indenter = test.indenter.substr(0, test.indenter.find("_grouser"));
    if (pressing.row.diameter_mm) test.diameter = 1e-3 * *pressing.row.diameter_mm;
    test.group = pressing.box;
    write_bag(pressing.log, path_of(counts.directory, *test.bag));
    experiment.plate_tests.push_back(test);
    ++counts.pressings;
  }
  write_experiment(experiment, counts.directory);
  summary.experiments.push_back(counts);
}

}  // namespace

ImportSummary import(const std::string& directory, const std::string& out) {
  if (!fs::is_directory(directory)) throw Error(fmt::format("{}: is no directory", directory));
  if (!fs::is_regular_file(path_of(directory, "runs.csv")))
    throw Error(fmt::format("{}: is no data set of the CMU testbed: runs.csv is missing", directory));
  ImportSummary summary;
  const std::vector<ImportedRun> runs = read_driving_runs(directory, summary);
  std::vector<Pressing> pressings;
  if (fs::is_regular_file(path_of(directory, "plates.csv")))
    pressings = read_pressings(directory, summary.remarks);
  else
    summary.remarks.emplace_back("no plates.csv: no pressings");
  fs::create_directories(out);
  const std::optional<DeclaredSensor> ft = read_zeros(directory, out, summary);
  for (const char* wheel : {"smooth", "grouser"})
    if (std::any_of(runs.begin(), runs.end(), [&](const ImportedRun& run) { return run.row.wheel == wheel; }))
      write_one(wheel, runs, pressings, ft, out, summary);
  std::string notes;
  for (const std::string& remark : summary.remarks) notes += remark + "\n";
  for (const auto& experiment : summary.experiments) {
    write_file(path_of(experiment.directory, "import_notes.txt"), notes);
    if (fs::is_regular_file(path_of(out, "zeros.csv")))
      fs::copy_file(path_of(out, "zeros.csv"), path_of(experiment.directory, "zeros.csv"),
                    fs::copy_options::overwrite_existing);
  }
  if (fs::is_regular_file(path_of(directory, "LICENSE")))
    for (const auto& experiment : summary.experiments)
      fs::copy_file(path_of(directory, "LICENSE"), path_of(experiment.directory, "LICENSE"),
                    fs::copy_options::overwrite_existing);
  return summary;
}

}  // namespace wheel_twin::logs::cmu
