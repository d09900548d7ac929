// What the logs of an experiment carry besides what a diagnosis names: properties of sensors, rig, wheel and
// soil that can be read off without any twin, with their size and error, also those too small to matter.
#pragma once

#include <string>
#include <vector>

#include "logs/experiment.h"
#include "run_log/run_log.h"

namespace wheel_twin::twin {

struct SurveyItem {
  std::string place;  ///< sensor, rig, wheel, soil or log
  std::string what;
  double value = 0.0;
  double error = 0.0;  ///< standard error; 0: not an estimate
  std::string unit;
  std::string evidence;  ///< from what, over how many runs
  bool found = false;    ///< beyond three standard errors and not negligible
};

/// Reads the bags one at a time. Where `zeros.csv` lies beside experiment.yaml (recordings of the hanging
/// wheel: columns file, time_s, temperature_c, drawbar_pull_n, side_force_n, normal_load_n), the tare is
/// surveyed as well; lines of `import_notes.txt` are taken over. Throws Error naming a file that cannot be
/// read.
std::vector<SurveyItem> survey_logs(const logs::Experiment& experiment);

/// As a table of a page, and as JSON text.
std::string survey_html(const std::vector<SurveyItem>& items);
std::string survey_json(const std::string& experiment, const std::vector<SurveyItem>& items);

/// Collects over runs what one log tells of its motion and its channels.
class MotionSurvey {
 public:
  explicit MotionSurvey(double radius) : radius_(radius) {}
  void add(const logs::Run& run, const run_log::RunLog& log);
  void report(std::vector<SurveyItem>& items) const;

 private:
  struct Line {
    double cycles = 0.0;  ///< a turn
    std::vector<double> amplitude;
    std::vector<double> noise;
  };
  void add_lines(std::vector<Line>& lines, const std::vector<double>& angle,
                 const std::vector<double>& value) const;
  static void report_lines(const std::vector<Line>& lines, const std::string& what, const std::string& unit,
                           double factor, std::vector<SurveyItem>& items);

  double radius_;
  std::vector<double> carriage_scale_, wheel_scale_, locked_speed_, locked_peak_, settling_, step_, gap_;
  std::vector<Line> rim_lines_, hub_lines_, pull_lines_;
};

}  // namespace wheel_twin::twin
