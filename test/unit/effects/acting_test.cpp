#include "effects/acting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../message_of.h"

namespace wheel_twin::effects {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(ReadEffects, SetsWhatIsNamedAndLeavesTheRestNeutral) {
  const Acting acting =
      read_effects({"ft_drift:rate_x=0.5,rate_z=-2e-1", "slide_friction:coulomb_force=3.5"});
  ASSERT_EQ(acting.ports.sensor.size(), 1U);
  ASSERT_EQ(acting.ports.rig.size(), 1U);
  rig::RigState state;
  state.time = 2.0;
  rig::WrenchReading reading;
  acting.ports.sensor[0]->change_wrench(state, reading);
  EXPECT_EQ(reading.force, Eigen::Vector3d(1.0, 0.0, -0.4));
  EXPECT_EQ(acting.ports.rig[0]->coulomb_friction(state), 3.5);
}

TEST(ReadEffects, NamesWhatItCanNotRead) {
  const auto message = [](const char* text) { return message_of([&] { read_effects({text}); }); };
  EXPECT_THAT(message("slide_fiction"), StartsWith("effect slide_fiction: not in the catalogue"));
  EXPECT_EQ(message("slide_friction:force=1"), "effect slide_friction: it has no parameter 'force'");
  for (const char* number : {"", "1e", "1 N", "0x10"}) {
    EXPECT_EQ(message(("slide_friction:coulomb_force=" + std::string(number)).c_str()),
              "effect slide_friction: coulomb_force is not a number: '" + std::string(number) + "'");
  }
  EXPECT_THAT(message("slide_friction:coulomb_force"), HasSubstr("is not a number: ''"));
  EXPECT_THAT(message("slide_friction:coulomb_force=-1"), HasSubstr("is outside"));
  EXPECT_EQ(message("wheel_eccentricity:amplitude=0.001"), "effect wheel_eccentricity: phase must be given");
}

TEST(ReadEffects, AsksForEveryEffectByItself) {
  const auto one_wheel = [](const rig::Ports& ports) {
    if (!ports.wheel.empty()) throw Error("no wheel here");
    EXPECT_EQ(ports.sensor.size() + ports.rig.size() + ports.soil.size(), 1U);
  };
  EXPECT_EQ(read_effects({"ft_gain:gain_x=0.1", "soil_cohesion:cohesion=10"}, one_wheel).effects.size(), 2U);
  EXPECT_EQ(message_of([&] {
              read_effects({"ft_gain:gain_x=0.1", "wheel_eccentricity:amplitude=0.001,phase=0"}, one_wheel);
            }),
            "effect wheel_eccentricity: no wheel here");
}

}  // namespace
}  // namespace wheel_twin::effects
