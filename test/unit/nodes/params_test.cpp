#include "nodes/params.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../message_of.h"

namespace wheel_twin::nodes {
namespace {

using testing::HasSubstr;
using XmlRpc::XmlRpcValue;

XmlRpcValue values() {
  XmlRpcValue v;
  v["real"] = 0.5;
  v["whole"] = 3;
  v["exponent"] = std::string("1e3");  // what roslaunch makes of 1e3
  v["octal"] = std::string("010");
  v["word"] = std::string("fast");
  v["flag"] = true;
  return v;
}

TEST(Params, ReadsNumbersOfEveryKind) {
  Params params(values(), "/rig");
  EXPECT_EQ(params.number("real", 1.0), 0.5);
  EXPECT_EQ(params.number("whole", 1.0), 3.0);
  EXPECT_EQ(params.number("exponent", 1.0), 1000.0);
  EXPECT_EQ(params.number("absent", 7.0), 7.0);
  EXPECT_EQ(params.integer("whole", 1, 0, 10), 3);
}

TEST(Params, PartsATextAtItsBlanks) {
  XmlRpcValue v;
  v["several"] = std::string("  a:b=1,c=2 d ");
  v["none"] = std::string(" ");
  Params params(v, "/rig");
  EXPECT_THAT(params.words("several"), testing::ElementsAre("a:b=1,c=2", "d"));
  EXPECT_TRUE(params.words("none").empty());
  EXPECT_TRUE(params.words("absent").empty());
}

TEST(Params, RefusesWhatIsNotANumberInsteadOfTakingTheDefault) {
  Params params(values(), "/rig");
  EXPECT_THAT(message_of([&] { params.number("word", 1.0); }),
              HasSubstr("parameter /rig/word: 'fast' is not a number"));
  EXPECT_THAT(message_of([&] { params.number("octal", 1.0); }), HasSubstr("/rig/octal"));
  EXPECT_THAT(message_of([&] { params.number("flag", 1.0); }), HasSubstr("/rig/flag"));
  for (const char* text : {"", "1e3x", " 1", "nan", "inf", "0x10", "--1", "1e999", "."}) {
    XmlRpcValue v;
    v["x"] = std::string(text);
    Params odd(v, "/rig");
    EXPECT_THAT(message_of([&] { odd.number("x", 1.0); }), HasSubstr("is not a number"))
        << "'" << text << "'";
  }
}

TEST(Params, RefusesRelativePaths) {
  XmlRpcValue v;
  v["bag"] = std::string("run.bag");
  v["picture"] = std::string("/tmp/rig.png");
  Params params(v, "/rig");
  EXPECT_THAT(message_of([&] { params.absolute_path("bag"); }),
              HasSubstr("/rig/bag: 'run.bag' must be an absolute path"));
  EXPECT_EQ(params.absolute_path("picture"), "/tmp/rig.png");
  EXPECT_EQ(params.absolute_path("absent"), "");
}

TEST(Params, RefusesValuesOutOfRangeAndOfTheWrongType) {
  Params params(values(), "/rig");
  EXPECT_THAT(message_of([&] { params.number("whole", 1.0, {0.0, 2.0}); }), HasSubstr("3 is outside 0 to 2"));
  EXPECT_THAT(message_of([&] { params.integer("real", 1, 0, 10); }), HasSubstr("0.5 is not a whole number"));
  EXPECT_THAT(message_of([&] { params.boolean("whole", true); }), HasSubstr("must be true or false"));
  EXPECT_THAT(message_of([&] { params.text("real", ""); }), HasSubstr("must be a text"));
  EXPECT_THAT(message_of([&] {
                params.choice("word", "slow", {"slow", "slower"});
              }),
              HasSubstr("slow, slower"));
}

TEST(Params, RefusesParametersThatNobodyRead) {
  Params params(values(), "/rig");
  for (const char* key : {"real", "whole", "exponent", "octal", "word"})
    message_of([&] { params.optional_number(key); });
  EXPECT_THAT(message_of([&] { params.finish(); }), HasSubstr("parameter /rig/flag: is not known"));
  params.boolean("flag", false);
  EXPECT_EQ(message_of([&] { params.finish(); }), "no error");
}

TEST(Params, EmptyNamespaceGivesDefaults) {
  Params params(XmlRpcValue(), "/rig");
  EXPECT_EQ(params.text("bag", "none"), "none");
  EXPECT_EQ(message_of([&] { params.finish(); }), "no error");
}

}  // namespace
}  // namespace wheel_twin::nodes
