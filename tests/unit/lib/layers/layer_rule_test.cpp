#include "layers/layer_rule.h"

#include <gtest/gtest.h>

#include <string>

#include "layers/automaton.h"

namespace tessera::test::layer_rule {
namespace {

using layers::LayerRule;
using layers::parse_rule;
using layers::Part;
using layers::Strategies;

TEST(LayerRule, SaysWhichPartOfThePathsLight) {
  const struct {
    const char* text;
    Part part;
    Strategies strategies;
  } cases[] = {{"LDE", Part::kAll, {}},
               {" C<.D'm'>L", Part::kAll, {}},
               {"shadow", Part::kShadow, {}},
               {"shadow : LDE", Part::kShadow, {}},
               {"s1t2", Part::kOfStrategies, {1, 2, 0}},
               {"s*t1:LS+DE", Part::kOfStrategies, {Strategies::kAny, 1, 0}},
               {"s12t*", Part::kOfStrategies, {12, Strategies::kAny, 0}},
               {"d6+", Part::kOfStrategies, {Strategies::kAny, Strategies::kAny, 6}},
               {"unweighted s0t3", Part::kUnweighted, {0, 3, 0}},
               {"unweighted d0+:LE", Part::kUnweighted, {Strategies::kAny, Strategies::kAny, 0}}};
  for (const auto& c : cases) {
    const absl::StatusOr<LayerRule> rule = parse_rule(c.text);
    ASSERT_TRUE(rule.ok()) << c.text << ": " << rule.status();
    EXPECT_EQ(rule->part, c.part) << c.text;
    EXPECT_EQ(rule->strategies, c.strategies) << c.text;
  }
}

TEST(LayerRule, TellsTheColumnOfWhatIsWrong) {
  const struct {
    const char *text, *message;
  } cases[] = {
      {"sky", "column 2: a number from 0 to 65536 was expected"},
      {"lamp", "column 1: shadow, unweighted, a strategy such as s1t2, or an expression was expected"},
      {"s1", "column 3: 't' was expected"},
      {"s-1t2", "column 2: a number from 0 to 65536 was expected"},
      {"s99999999999t2", "column 2: a number from 0 to 65536 was expected"},
      {"s1tt", "column 4: a number from 0 to 65536 was expected"},
      {"d6", "column 3: '+' was expected"},
      {"unweighted", "column 11: shadow, unweighted, a strategy such as s1t2, or an expression was expected"},
      {"s1t2 LDE", "column 6: ':' was expected, and an expression behind it"},
      {"shadow:LXE", "column 9: 'X' is unknown"},
      {"shadow:", "column 8: an event, a light or the camera was expected"}};
  for (const auto& c : cases) {
    const absl::StatusOr<LayerRule> rule = parse_rule(c.text);
    ASSERT_FALSE(rule.ok()) << c.text;
    EXPECT_EQ(std::string(rule.status().message()).find(c.message), 0u) << rule.status();
  }
}

TEST(LayerRule, KnowsItsStrategies) {
  const auto has = [](const char* text, int s, int t) { return parse_rule(text)->strategies.has(s, t); };
  EXPECT_TRUE(has("s1t2", 1, 2));
  EXPECT_FALSE(has("s1t2", 2, 1));
  EXPECT_TRUE(has("s*t1", 7, 1));
  EXPECT_FALSE(has("s*t1", 7, 2));
  EXPECT_TRUE(has("d2+", 1, 3));
  EXPECT_FALSE(has("d2+", 1, 2));
}

TEST(LayerRule, StandsInListsAndHasNames) {
  const auto asked = layers::parse_layers("a=unweighted s1t2:C<RD'ball'>L,b=shadow:L.{1,2}E,c=d6+");
  ASSERT_TRUE(asked.ok()) << asked.status();
  EXPECT_TRUE(layers::check_layers(*asked).ok()) << layers::check_layers(*asked);
  EXPECT_EQ(layers::names_in(*asked), std::vector<std::string>{"ball"});
}

}  // namespace
}  // namespace tessera::test::layer_rule
