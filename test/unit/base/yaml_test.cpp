#include "base/yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../message_of.h"

namespace wheel_twin::yaml {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Map parse(const std::string& text) {
  return parse_text(text, "a.yaml");
}

TEST(Yaml, ReadsNumbersAsAPersonWould) {
  const Map map = parse("a: 1e3\nb: -0.5\nc: 12\nd: +3.0\n");
  EXPECT_EQ(map.number("a"), 1000.0);
  EXPECT_EQ(map.number("b"), -0.5);
  EXPECT_EQ(map.integer("c"), 12);
  EXPECT_EQ(map.number("d"), 3.0);
  EXPECT_NO_THROW(map.finish());
}

TEST(Yaml, NamesFileLineAndKey) {
  const Map map = parse("a: 1\nb: {c: x}\n");
  EXPECT_THAT(message_of([&] { map.map("b").number("c"); }), AllOf(HasSubstr("a.yaml:2"), HasSubstr("b.c")));
  EXPECT_THAT(message_of([&] { map.number("z"); }),
              AllOf(HasSubstr("a.yaml"), HasSubstr("z"), HasSubstr("missing")));
}

TEST(Yaml, RefusesOctalLookalikes) {
  EXPECT_THAT(message_of([] { parse("a: 010").number("a"); }), HasSubstr("octal"));
  EXPECT_THAT(message_of([] { parse("a: 010").integer("a"); }), HasSubstr("octal"));
  EXPECT_EQ(parse("a: 0.5").number("a"), 0.5);
}

TEST(Yaml, RefusesBooleansOtherThanTrueAndFalse) {
  EXPECT_THAT(message_of([] { parse("a: on").boolean("a"); }), HasSubstr("true or false"));
  EXPECT_THAT(message_of([] { parse("a: on").number("a"); }), HasSubstr("number"));
  EXPECT_TRUE(parse("a: true").boolean("a"));
}

TEST(Yaml, RefusesDoubledKeysEmptyValuesAndQuotedNumbers) {
  EXPECT_THAT(message_of([] { parse("a: 1\na: 2"); }),
              AllOf(HasSubstr("a.yaml:2"), HasSubstr("second time")));
  EXPECT_THAT(message_of([] { parse("a:").number("a"); }), HasSubstr("no value"));
  EXPECT_THAT(message_of([] { parse("a: ''").text("a"); }), HasSubstr("empty"));
  EXPECT_THAT(message_of([] { parse("a: '12'").number("a"); }), HasSubstr("quoted"));
}

TEST(Yaml, RefusesNumbersOutOfRangeAndNotFinite) {
  EXPECT_THAT(message_of([] { parse("a: -1").number("a", positive()); }), HasSubstr("above 0"));
  EXPECT_THAT(message_of([] { parse("a: .nan").number("a"); }), HasSubstr("number"));
  EXPECT_THAT(message_of([] { parse("a: inf").number("a"); }), HasSubstr("out of range"));
  EXPECT_THAT(message_of([] { parse("a: 5").integer("a", 0, 4); }), HasSubstr("out of range"));
}

TEST(Yaml, RefusesUnknownKeys) {
  const Map map = parse("a: 1\nbb: 2\n");
  map.number("a");
  EXPECT_THAT(message_of([&] { map.finish(); }), AllOf(HasSubstr("a.yaml:2"), HasSubstr("bb")));
}

TEST(Yaml, RefusesWhatIsNotAMapping) {
  EXPECT_THAT(message_of([] { parse("- 1\n- 2"); }), HasSubstr("mapping"));
  EXPECT_THAT(message_of([] { parse(""); }), HasSubstr("mapping"));
  EXPECT_THAT(message_of([] { parse("a: [1, 2"); }), HasSubstr("not YAML"));
  EXPECT_THAT(message_of([] { parse_file("/nonexistent.yaml"); }), HasSubstr("cannot be opened"));
}

TEST(Yaml, NullIsNotAbsence) {
  const Map map = parse("a: null\nb: ~\n");
  EXPECT_TRUE(map.is_null("a"));
  EXPECT_FALSE(map.optional_number("b").has_value());
  EXPECT_FALSE(map.optional_number("c").has_value());
  EXPECT_NO_THROW(map.finish());
}

}  // namespace
}  // namespace wheel_twin::yaml
