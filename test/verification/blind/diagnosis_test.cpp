// The loop from logs to a named cause, on a drawn rig: something hidden is found, nothing is not.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "draw.h"
#include "logs/experiment.h"
#include "twin/diagnosis.h"
#include "write.h"

namespace wheel_twin::blind {
namespace {

namespace fs = std::filesystem;

class Loop : public testing::Test {
 protected:
  Loop() : folder_(fs::temp_directory_path() / ("wheel_twin_blind_" + std::to_string(getpid()))) {}
  ~Loop() override { fs::remove_all(folder_); }

  twin::Diagnosis diagnosis_of(std::vector<twin::EffectSetting> effects) {
    Drawn drawn = draw(12);  // a rig with reference runs
    drawn.effects = std::move(effects);
    drawn.outside.clear();
    write(drawn, "hidden", folder_.string(), 12);
    twin::DiagnosisOptions options;
    options.threads = 1;
    return twin::diagnose(logs::read_experiment((folder_ / "hidden").string()), options);
  }

  fs::path folder_;
};

TEST_F(Loop, NothingIsFoundWhereNothingIsHidden) {
  EXPECT_EQ(diagnosis_of({}).verdict, "no_residual");
}

TEST_F(Loop, AMisalignedSensorIsNamedWithItsAngles) {
  const twin::Diagnosis found = diagnosis_of({{"ft_misalignment", {0.04, -0.03}}});
  ASSERT_EQ(found.verdict, "effect_found");
  ASSERT_FALSE(found.candidates.empty());
  const twin::Candidate& best = found.candidates.front().candidate;
  ASSERT_EQ(best.effects, std::vector<std::string>{"ft_misalignment"});
  EXPECT_NEAR(best.values[0][0], 0.04, 0.006);  // 15 %
  EXPECT_NEAR(best.values[0][1], -0.03, 0.0045);
}

TEST_F(Loop, ACompactedSoilIsNamedWithItsShare) {
  const twin::Diagnosis found = diagnosis_of({{"multi_pass", {0.4}}});
  ASSERT_EQ(found.verdict, "effect_found");
  ASSERT_FALSE(found.candidates.empty());
  const twin::Candidate& best = found.candidates.front().candidate;
  ASSERT_EQ(best.effects, std::vector<std::string>{"multi_pass"});
  EXPECT_NEAR(best.values[0][0], 0.4, 0.06);
}

}  // namespace
}  // namespace wheel_twin::blind
