#include "import/pbrt/file/tokenizer.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace tessera::client::pbrt {
namespace {

using testing::ElementsAre;

TEST(Tokenizer, SplitsAndLocates) {
  Tokenizer tokenizer("Shape \"sphere\"# not a token\n  [ -0 4.37114e-8]\"a b\"", 3);
  const auto expect = [&](TokenKind kind, std::string_view text, std::uint32_t line, std::uint32_t column) {
    const Token token = tokenizer.next();
    EXPECT_EQ(token.kind, kind);
    EXPECT_EQ(token.text, text);
    EXPECT_EQ(token.where.file, 3u);
    EXPECT_EQ(token.where.line, line) << text;
    EXPECT_EQ(token.where.column, column) << text;
  };
  expect(TokenKind::kWord, "Shape", 1, 1);
  expect(TokenKind::kString, "sphere", 1, 7);
  expect(TokenKind::kOpen, "[", 2, 3);
  expect(TokenKind::kWord, "-0", 2, 5);
  expect(TokenKind::kWord, "4.37114e-8", 2, 8);
  expect(TokenKind::kClose, "]", 2, 18);
  expect(TokenKind::kString, "a b", 2, 19);
  expect(TokenKind::kEnd, "", 2, 24);
}

TEST(Tokenizer, ReadsNumbersUntilSomethingElse) {
  Tokenizer tokenizer(" 1 +2.5 # 99\n-3e2\t1e-400 x5 ]", 0);
  std::vector<double> numbers;
  tokenizer.read_numbers([&](double value) { numbers.push_back(value); });
  EXPECT_THAT(numbers, ElementsAre(1, 2.5, -300, 0));
  EXPECT_EQ(tokenizer.next().text, "x5");
}

TEST(Tokenizer, ReportsStringsWithoutEnd) {
  EXPECT_EQ(Tokenizer("\"abc\n\"", 0).next().kind, TokenKind::kProblem);
  EXPECT_EQ(Tokenizer("\"abc", 0).next().kind, TokenKind::kProblem);
  EXPECT_EQ(Tokenizer("\"abc\\", 0).next().kind, TokenKind::kProblem);
  EXPECT_EQ(Tokenizer("\"", 0).next().kind, TokenKind::kProblem);
}

TEST(Tokenizer, NumbersAreFinite) {
  EXPECT_EQ(parse_number("1e3"), 1000);
  EXPECT_EQ(parse_number("+.5"), 0.5);
  for (const char* bad : {"nan", "inf", "-inf", "1e999", "1x", "", "+", "0x10", "1,5"}) {
    EXPECT_FALSE(parse_number(bad).has_value()) << bad;
  }
}

TEST(Tokenizer, ResolvesEscapes) {
  EXPECT_EQ(unescape(R"(a\"b\\c\n)"), "a\"b\\c\n");
  EXPECT_FALSE(unescape(R"(\q)").has_value());
  EXPECT_FALSE(unescape("\\").has_value());
}

}  // namespace
}  // namespace tessera::client::pbrt
