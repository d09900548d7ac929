// The loop closed on real logs: the diagnosis of the shipped sample of a single-wheel testbed (29 straight
// runs, two wheels), its errors on days left out, and the twin that it writes on days that it has not seen.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "logs/cmu_testbed.h"
#include "logs/experiment.h"
#include "twin/diagnosis.h"
#include "twin/evaluation.h"

namespace wheel_twin::twin {
namespace {

namespace fs = std::filesystem;

// The project's goals for days left out.
constexpr double most_pull = 1.4, most_displacement = 1.8e-3;  // N, m

class RealDiagnosis : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ =
        (fs::temp_directory_path() / ("wheel_twin_real_diagnosis_test_" + std::to_string(getpid()))).string();
    fs::remove_all(folder_);
    logs::cmu::import(std::string(WHEEL_TWIN_SOURCE_DIR) + "/data/cmu_testbed_sample", folder_);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  static std::string folder_;
};
std::string RealDiagnosis::folder_;

TEST_F(RealDiagnosis, FindsWhatTheTwinLacksAndForetellsDaysLeftOut) {
  DiagnosisOptions options;
  options.choose_without_group = false;  // the whole takes minutes: doc/validation.md has its numbers
  const Diagnosis d = diagnose(logs::read_experiment(folder_ + "/grouser"), options);
  ASSERT_TRUE(d.steady);
  fmt::print("{}\n", d.evidence);
  EXPECT_EQ(d.verdict, "effect_found");
  ASSERT_FALSE(d.candidates.empty());
  EXPECT_THAT(d.candidates.front().candidate.effects, testing::Contains("slip_loosening"));
  EXPECT_LT(d.steady->left_out.at(Channel::drawbar_pull).after, most_pull);
  EXPECT_LT(d.steady->left_out.at(Channel::hub_displacement).after, most_displacement);
  const auto& driving = d.steady->left_out_driving;
  EXPECT_LT(driving.at(Channel::hub_displacement).after,
            d.steady->constant_driving.at(Channel::hub_displacement));
}

// A diagnosis of some days, its twin evaluated on the others.
TEST_F(RealDiagnosis, TheRevisedTwinCarriesToOtherDays) {
  logs::Experiment some = logs::read_experiment(folder_ + "/grouser");
  logs::Experiment others = some;
  const auto is_other = [](const logs::Run& run) { return run.group == "2021-03-02"; };
  some.runs.erase(std::remove_if(some.runs.begin(), some.runs.end(), is_other), some.runs.end());
  others.runs.erase(std::remove_if(others.runs.begin(), others.runs.end(),
                                   [&](const logs::Run& r) { return !is_other(r); }),
                    others.runs.end());
  ASSERT_GE(others.runs.size(), 4u);
  DiagnosisOptions options;
  options.choose_without_group = false;
  const Diagnosis d = diagnose(some, options);
  const auto json = nlohmann::json::parse(evaluate(d.revised, others));
  EXPECT_LT(json["error_straight"]["drawbar_pull"]["rmse"].get<double>(), most_pull);
  EXPECT_LT(json["error_straight"]["hub_displacement"]["rmse"].get<double>(), most_displacement);
  EXPECT_EQ(json["error"].count("normal_load"), 0u) << "the load that was read leads the twin";
}

}  // namespace
}  // namespace wheel_twin::twin
