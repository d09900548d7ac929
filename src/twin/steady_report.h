// What a diagnosis by window means tells beyond verdict and candidates: every run as foretold by several
// twins, and errors on groups (days) left out. SI units.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "twin/channel_error.h"
#include "twin/log_survey.h"

namespace wheel_twin::twin {

/// One run as foretold by several twins; NaN where a channel has no window.
struct SteadyRow {
  std::string run, group;
  double slip = 0.0, load = 0.0, steering_angle = 0.0;
  struct Value {
    double measured = 0.0;
    double declared = 0.0;  ///< by the twin as declared, with the plates' soil
    double before = 0.0;    ///< soil fitted to the runs, no effect
    double after = 0.0;     ///< with the effects found
    double left_out = 0.0;  ///< by a twin whose effects were chosen and fitted without the run's group
  };
  std::map<Channel, Value> values;
};

struct SteadyReport {
  std::vector<SteadyRow> rows;     ///< the runs that were diagnosed
  std::vector<std::string> parts;  ///< groups left out together, with the effects chosen without them
  Errors declared;                 ///< before: the twin as declared; after: with the effects found
  Errors left_out;          ///< groups left out; before: without effects, after: effects chosen without them
  Errors left_out_driving;  ///< the same over slips above 0.05
  std::map<Channel, double> constant_driving;  ///< RMSE of the mean of the other groups' driving runs
  Errors outside;                              ///< steered runs, not diagnosed
  std::size_t outside_runs = 0;
  std::vector<std::string> left_aside;  ///< effects that means cannot tell, with the reason
  std::vector<std::string> soil;        ///< fitted soil parameters, as text
  std::vector<SurveyItem> survey;       ///< what else the logs carry
};

}  // namespace wheel_twin::twin
