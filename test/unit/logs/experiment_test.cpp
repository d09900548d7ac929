#include "logs/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support.h"

namespace wheel_twin::logs {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char* const head =
    "schema: 1\nname: e\n"
    "wheel: {name: amalia, radius: 0.09, width: 0.07, grousers: 24, grouser_height: 0.007, stiffness: "
    "9000.0}\n"
    "soil: {name: bin_sand, k_c: 1370.0, k_phi: 814000.0, n: 1.0, c: 0.0, phi: 0.698, K: 0.022, c1: 0.2, c2: "
    "0.15, gamma: "
    "0.3}\n";
const char* const run =
    "- {bag: run_00.bag, role: reference, slip: 0.2, load: 42.1, wheel_speed: 0.28, steering_angle: 0.0}\n";

class ExperimentFile : public testing::Test {
 protected:
  ExperimentFile() { put_bytes(scratch_ / "run_00.bag", "x"); }

  Experiment read(const std::string& text) {
    put_bytes(scratch_ / "experiment.yaml", text);
    return read_experiment(scratch_.path());
  }
  std::string refusal(const std::string& text) {
    return message_of([&] { read(text); });
  }

  Scratch scratch_;
};

TEST_F(ExperimentFile, ReadsTheDocumentedForm) {
  const Experiment e = read(std::string(head) +
                            "sensors: {ft: {rate: 50.0, noise: 0.06, resolution: 0.0625}, draw_wire: {rate: "
                            "50.0, noise: 3.0e-05, resolution: "
                            "5.0e-05}}\nruns:\n" +
                            run +
                            "- {bag: null, role: held_out, slip: 0.503, load: 25.0, wheel_speed: 0.32, "
                            "steering_angle: 0.0, group: 2020-12-05,\n"
                            "   averages: {window: [70.53, 75.53], drawbar_pull: {mean: 0.97, std: 2.7}, "
                            "normal_load: {mean: 25.3, std: 1.9}, "
                            "hub_displacement: {mean: 0.0227, std: 1.0e-05}}}\n");
  EXPECT_EQ(e.wheel.grousers, 24);
  EXPECT_EQ(e.soil.k_phi, 814000.0);
  EXPECT_EQ(e.ft->resolution, 0.0625);
  EXPECT_EQ(e.draw_wire->noise, 3e-5);
  ASSERT_EQ(e.runs.size(), 2u);
  EXPECT_EQ(e.path_of(*e.runs[0].bag), scratch_ / "run_00.bag");
  EXPECT_EQ(e.runs[0].role, Role::reference);
  EXPECT_FALSE(e.runs[0].averages);
  EXPECT_FALSE(e.runs[1].bag);
  EXPECT_EQ(e.runs[1].group, "2020-12-05");
  EXPECT_EQ(e.runs[1].averages->window_end, 75.53);
  EXPECT_EQ(e.runs[1].averages->hub_displacement->std, 1e-5);
  EXPECT_FALSE(e.runs[1].averages->side_force);
}

TEST_F(ExperimentFile, WritesWhatItReads) {
  put_bytes(scratch_ / "run_01.bag", "x");
  put_bytes(scratch_ / "plate.csv", "x");
  put_bytes(scratch_ / "shear.csv", "x");
  Experiment e;
  e.name = "it's: a # name";
  e.wheel.stiffness = std::nullopt;
  e.wheel.name = "010";
  e.soil.phi = 40.0 * 3.14159265358979323846 / 180.0;
  e.soil.weight_density = 13047.3;
  e.ft = DeclaredSensor{1000.0, 0.02, 0.0625};
  e.source = "somewhere, MIT";
  logs::Run measured;
  measured.bag = "run_01.bag";
  measured.role = Role::measured;
  measured.slip = -0.1;
  measured.load = 1e5;
  measured.wheel_speed = 1e-7;
  measured.averages.emplace();
  measured.averages->window_start = 1.0;
  measured.averages->window_end = 2.5;
  measured.averages->drawbar_pull = Average{1.0 / 3.0, std::nullopt};
  e.runs = {measured};
  PlateTest plate;
  plate.csv = "plate.csv";
  plate.indenter = "plate";
  plate.diameter = 0.06;
  e.plate_tests = {plate};
  DirectShear shear;
  shear.csv = "shear.csv";
  shear.normal_stress = 5000.0;
  e.direct_shear = {shear};
  write_experiment(e, scratch_.path());
  const Experiment back = read_experiment(scratch_ / "experiment.yaml");
  EXPECT_EQ(back.name, e.name);
  EXPECT_EQ(back.wheel.name, "010");
  EXPECT_FALSE(back.wheel.stiffness);
  EXPECT_EQ(back.soil.phi, e.soil.phi);
  EXPECT_EQ(back.soil.weight_density, e.soil.weight_density);
  EXPECT_EQ(back.ft->rate, 1000.0);
  EXPECT_FALSE(back.draw_wire);
  EXPECT_EQ(back.source, e.source);
  EXPECT_EQ(back.runs[0].slip, -0.1);
  EXPECT_EQ(back.runs[0].load, 1e5);
  EXPECT_EQ(back.runs[0].wheel_speed, 1e-7);
  EXPECT_EQ(back.runs[0].averages->drawbar_pull->mean, 1.0 / 3.0);
  EXPECT_FALSE(back.runs[0].averages->drawbar_pull->std);
  EXPECT_EQ(back.plate_tests[0].diameter, 0.06);
  EXPECT_EQ(back.direct_shear[0].normal_stress, 5000.0);
  const std::string first = bytes_of(scratch_ / "experiment.yaml");
  write_experiment(back, scratch_.path());
  EXPECT_EQ(bytes_of(scratch_ / "experiment.yaml"), first);
}

TEST_F(ExperimentFile, TakesABareNameFromTheConfigurationDirectory) {
  std::filesystem::create_directories(scratch_ / "config/wheels");
  put_bytes(scratch_ / "config/wheels/small.yaml",
            "{name: small, radius: 0.058, width: 0.05, stiffness: null}");
  ASSERT_EQ(setenv("WHEEL_TWIN_CONFIG", (scratch_ / "config").c_str(), 1), 0);
  std::string text = std::string(head) + "runs: []\n";
  const auto begin = text.find("wheel:");
  const auto end = text.find("soil:");
  const std::string named = text.substr(0, begin) + "wheel: small\n" + text.substr(end);
  EXPECT_EQ(read(named).wheel.radius, 0.058);
  EXPECT_EQ(*read(named).wheel_name, "small");
  const std::string unknown = text.substr(0, begin) + "wheel: other\n" + text.substr(end);
  EXPECT_THAT(refusal(unknown), AllOf(HasSubstr("other"), HasSubstr("known wheels: small")));
  unsetenv("WHEEL_TWIN_CONFIG");
}

TEST_F(ExperimentFile, NamesFileLineAndKeyOfWhatIsWrong) {
  const std::string start = std::string(head) + "runs:\n";
  const auto with = [&](const std::string& key, const std::string& value) {
    std::string text = run;
    const auto at = text.find(key);
    const auto stop = text.find_first_of(",}", at);
    return start + text.replace(at, stop - at, value);
  };
  EXPECT_THAT(refusal(with("slip", "slip: 1.5")),
              AllOf(HasSubstr("experiment.yaml:6"), HasSubstr("runs[0].slip")));
  EXPECT_THAT(refusal(with("role", "role: training")), AllOf(HasSubstr("role"), HasSubstr("held_out")));
  EXPECT_THAT(refusal(with("load", "load: 010")), AllOf(HasSubstr("load"), HasSubstr("octal")));
  EXPECT_THAT(refusal(with("load", "load: on")), AllOf(HasSubstr("load"), HasSubstr("number")));
  EXPECT_THAT(refusal(with("load", "load: 42.1, load: 42.1")),
              AllOf(HasSubstr("load"), HasSubstr("second time")));
  EXPECT_THAT(refusal(with("load", "load:")), AllOf(HasSubstr("load"), HasSubstr("no value")));
  EXPECT_THAT(refusal(with("load", "load: 42.1, laod: 1.0")), HasSubstr("laod: is not a known key"));
  EXPECT_THAT(refusal(with("bag", "bag: run_01.bag")),
              AllOf(HasSubstr("runs[0].bag"), HasSubstr("no file 'run_01.bag'")));
  EXPECT_THAT(refusal(with("bag", "bag: ../run_00.bag")), HasSubstr("outside"));
  EXPECT_THAT(refusal(with("bag", "bag: null")), HasSubstr("nothing was measured"));
  EXPECT_THAT(refusal(start + run + run), AllOf(HasSubstr("runs[1].bag"), HasSubstr("second time")));
  EXPECT_EQ(refusal(with("load", "load: 4.21e1")), "no error");
}

}  // namespace
}  // namespace wheel_twin::logs
