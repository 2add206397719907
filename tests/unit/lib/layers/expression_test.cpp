// Expressions that are none, with the column where they end to be one; every construct is in automaton_test.
#include "layers/expression.h"

#include <gtest/gtest.h>

#include "layers/automaton.h"

namespace tessera::test::expression {
namespace {

using layers::parse_expression;

struct Bad {
  std::string text;
  int column;
  const char* says;
};

TEST(LightPathExpression, NamesTheColumnOfAnError) {
  const std::string deep = std::string(40, '(') + "D" + std::string(40, ')');
  const Bad cases[] = {
      {"", 1, "was expected"},
      {"   ", 4, "was expected"},
      {"LDX", 3, "'X' is unknown here"},
      {"LxE", 2, "'x' is unknown here"},
      {"LD", 3, "begins with C"},
      {"D*", 3, "begins with C"},
      {"CDE", 3, "do not go together"},
      {"L(S|DE", 7, "')' was expected"},
      {"L(|S)E", 3, "was expected"},
      {"L()E", 3, "was expected"},
      {"LS)E", 3, "nothing to close"},
      {"*LE", 1, "'*' is unknown here"},
      {"LD|", 4, "was expected"},
      {"LD{}E", 4, "a number was expected"},
      {"LD{2,1}E", 7, "2 is more than 1"},
      {"LD{0}E", 5, "0 times"},
      {"LD{1E", 5, "'}' was expected"},
      {"LD{1000}E", 7, "more than 256"},
      {"C<RD", 5, "'>' was expected"},
      {"C<XD>L", 3, "'X' is unknown here"},
      {"C<RX>L", 4, "'X' is unknown here"},
      {"C<LD>", 2, "no such event"},
      {"C<VS>L", 2, "no such event"},
      {"C<RD'wall>L", 5, "no end"},
      {"C<RD''>L", 5, "is empty"},
      {"C<RDwall>L", 5, "a name in quotes"},
      {"C<RD['a'>L", 9, "a name in quotes"},
      {"C[D", 4, "']' was expected"},
      {"C[^C]L", 5, "the camera stands in no such set"},
      {"C" + deep + "L", 34, "nested more than 32"},
      {"C" + std::string(5000, 'D') + "L", 4097, "more than 4096"},
  };
  for (const Bad& bad : cases) {
    const auto tree = parse_expression(bad.text);
    ASSERT_FALSE(tree.ok()) << bad.text;
    const std::string message(tree.status().message());
    EXPECT_TRUE(message.starts_with("column " + std::to_string(bad.column) + ": "))
        << bad.text << ": " << message;
    EXPECT_NE(message.find(bad.says), std::string::npos) << bad.text << ": " << message;
  }
}

TEST(LightPathExpression, TakesSpacesAndBothQuotes) {
  for (const char* text : {" L ( S | D ) * E ", "C < R D 'a b' \"c'd\" > . * < L . >", "CO", "BE"})
    EXPECT_TRUE(parse_expression(text).ok()) << text << ": " << parse_expression(text).status();
}

TEST(Layers, AreRefusedByName) {
  const auto message = [](std::vector<layers::Layer> asked) {
    return std::string(layers::check_layers(asked).message());
  };
  EXPECT_EQ(message({{"all", "L.*E"}, {"light.key_2", "C.*<L.'key'>"}}), "");
  EXPECT_EQ(
      message({{"one", "LDE"}, {"two", "LD*"}}),
      "layer 'two': column 4: an expression begins with C, at the camera, or ends with E, at the eye, in "
      "LD*");
  EXPECT_NE(message({{"1st", "LE"}}).find("'1st' is no name"), std::string::npos);
  EXPECT_NE(message({{"a b", "LE"}}).find("'a b' is no name"), std::string::npos);
  EXPECT_NE(message({{"a.", "LE"}}).find("is no name"), std::string::npos);
  EXPECT_NE(message({{std::string(65, 'a'), "LE"}}).find("at most 64"), std::string::npos);
  EXPECT_NE(message({{"a", "LE"}, {"a", "LDE"}}).find("'a' is there twice"), std::string::npos);
  EXPECT_NE(message({{"albedo.x", "LE"}}).find("has the name of other channels"), std::string::npos);
  for (const char* nothing : {"DE", "LLE", "LEE", "LDED", "C.*D", "C.*LD"})
    EXPECT_NE(message({{"a", nothing}}).find("layer 'a': no path is like"), std::string::npos) << nothing;
  std::vector<layers::Layer> many;
  for (int i = 0; i < 33; ++i) many.push_back({"a" + std::to_string(i), "LE"});
  EXPECT_EQ(message(many), "there are 33 layers; at most 32 were expected");
}

TEST(Layers, WhatNeedsTooManyStatesIsRefusedByName) {
  // Whether the 12th event from the light was diffuse: 2^12 states.
  const auto status =
      layers::check_layers(std::vector<layers::Layer>{{"small", "LDE"}, {"big", "C.*D.{12}L"}});
  EXPECT_NE(status.message().find("layer 'big' is too much"), std::string::npos) << status;
  const auto points = layers::check_layers(std::vector<layers::Layer>{{"copies", "L(D{200}S){200}E"}});
  EXPECT_NE(points.message().find("layer 'copies' is too much"), std::string::npos) << points;
}

TEST(Layers, AreReadFromAList) {
  const auto some = layers::parse_layers("a=LDE,b=C<RD'x,y'>{1,2}L,c=L[DS]E");
  ASSERT_TRUE(some.ok()) << some.status();
  ASSERT_EQ(some->size(), 3u);
  EXPECT_EQ((*some)[1].name, "b");
  EXPECT_EQ((*some)[1].expression, "C<RD'x,y'>{1,2}L");
  EXPECT_EQ((*some)[2].expression, "L[DS]E");
  for (const auto& [text, column] :
       std::vector<std::pair<std::string, std::string>>{{"", "column 1:"},
                                                        {"a", "column 1:"},
                                                        {"a=LE,", "column 6:"},
                                                        {"a=LE,=LE", "column 6:"},
                                                        {"a=LE,b=", "column 6:"}}) {
    const auto none = layers::parse_layers(text);
    ASSERT_FALSE(none.ok()) << text;
    EXPECT_EQ(std::string(none.status().message()).find(column), 0u) << text << ": " << none.status();
  }
}

}  // namespace
}  // namespace tessera::test::expression
