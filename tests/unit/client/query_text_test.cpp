// Lines of queries, as users and strangers write them.
#include "command/query/query_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "absl/strings/str_cat.h"
#include "command/query/line_reader.h"
#include "command/query/row_text.h"
#include "support/process/temp_dir.h"

namespace tessera::client::query_text {
namespace {

using testing::HasSubstr;

TEST(QueryText, TakesBlanksAndCommas) {
  for (const char* line :
       {"ray 1 2 3 0 0 -1", "  ray,1,2,3,0,0,-1", "ray 1, 2, 3,\t0 0 -1\r", "ray +1 2e0 3.0 0 0 -1 # why"}) {
    const ParsedQuery parsed = parse_query(line, {});
    ASSERT_TRUE(parsed.query.has_value()) << line << ": " << parsed.error;
    EXPECT_EQ(parsed.query->kind, QueryKind::kRay);
    EXPECT_EQ(parsed.query->point[2], 3);
    EXPECT_EQ(parsed.query->direction[2], -1);
  }
  EXPECT_EQ(parse_query("closest 1 2 3", {}).query->kind, QueryKind::kClosest);
  EXPECT_EQ(parse_query("1 2 3", QueryKind::kInside).query->kind, QueryKind::kInside);
}

TEST(QueryText, LeavesOutEmptyLinesAndComments) {
  for (const char* line : {"", "   ", "# ray 1 2 3", "\r"}) {
    const ParsedQuery parsed = parse_query(line, {});
    EXPECT_FALSE(parsed.query.has_value());
    EXPECT_EQ(parsed.error, "") << line;
  }
}

TEST(QueryText, SaysWhatIsWrongAndWhere) {
  struct Case {
    std::string line;
    const char* message;
    std::uint32_t column;
  };
  const Case cases[] = {{"ray 1 2 3 0 0", "expected 6 numbers; there are 5", 14},
                        {"inside 1 2 3 4", "expected 3 numbers, and then '4'", 14},
                        {"inside nan 0 0", "'nan' is not a finite number", 8},
                        {"inside 0 -inf 0", "'-inf' is not a finite number", 10},
                        {"inside 1e308 0 0", "'1e308' is beyond 1e18", 8},
                        {"inside 0 1e999 0", "'1e999' is beyond what doubles hold", 10},
                        {"inside 0 1.2.3 0", "expected a number instead of '1.2.3'", 10},
                        {"inside 0x10 0 0", "expected a number", 8},
                        {"ray 0 0 0 0 0 0", "the direction has no length", 15},
                        {"ray 0 0 0 0 1e-300 0", "below 1e-18", 20},
                        {"raze 0 0 0", "expected ray, inside or closest instead of 'raze'", 1},
                        {"inside 0,,0,0", "expected 3 numbers", 10},
                        {absl::StrCat("inside \x01\x1b[31m", std::string(300, 'x')), "expected a number", 8}};
  for (const Case& c : cases) {
    const ParsedQuery parsed = parse_query(c.line, {});
    EXPECT_FALSE(parsed.query.has_value()) << c.line;
    EXPECT_THAT(parsed.error, HasSubstr(c.message)) << c.line;
    EXPECT_EQ(parsed.column, c.column) << c.line;
    EXPECT_LT(parsed.error.size(), 200u);
    EXPECT_EQ(parsed.error.find('\x1b'), parsed.error.npos);
  }
  EXPECT_THAT(parse_query("ray 0 0 0 1 0 0", QueryKind::kInside).error, HasSubstr("not what the lines"));
}

/// Lines that nobody meant: what is taken is within bounds, and what is not is told in a short line.
TEST(QueryText, TakesNoMutationThatIsOutOfBounds) {
  const std::string words[] = {
      "ray",  "inside", "closest", "1e18", "-1e18", "1e19", "nan",    "inf", "-",  "+",
      ",",    " ",      "#",       "0",    "1",     ".",    "1e-320", "e",   "\n", std::string(1, '\0'),
      "\xff", "0x1p3"};
  std::mt19937 random(1);
  int taken = 0, refused = 0;
  for (int i = 0; i < 50'000; ++i) {
    std::string line = i % 2 == 0 ? "ray 1 2 3 0 0 -1" : "inside 0.5, -2e3 7";
    for (std::uint32_t edits = random() % 4; edits > 0; --edits) {
      const std::size_t at = random() % (line.size() + 1);
      line.replace(at, random() % 3, words[random() % std::size(words)]);
    }
    const ParsedQuery parsed = parse_query(line, i % 3 == 0 ? std::optional(QueryKind::kRay) : std::nullopt);
    EXPECT_LT(parsed.error.size(), 300u);
    EXPECT_LE(parsed.column, line.size() + 1);
    refused += !parsed.error.empty();
    if (!parsed.query) continue;
    ++taken;
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(parsed.query->point[k]), kLargestQueryNumber) << line;
      EXPECT_LE(std::abs(parsed.query->direction[k]), kLargestQueryNumber) << line;
    }
  }
  EXPECT_GT(taken, 5000);
  EXPECT_GT(refused, 5000);
}

TEST(LineReader, GivesLinesOfAnyLengthUpToItsBound) {
  const support::TempDir directory;
  const std::string path = (directory.path() / "lines").string();
  const std::string longest(kLongestQueryLine, 'a');
  std::ofstream(path) << "one\n\n"
                      << longest << '\n'
                      << longest << "b\n"
                      << std::string(1 << 20, 'c') << "\nlast";
  auto reader = LineReader::open(path);
  ASSERT_TRUE(reader.ok());
  std::string_view line;
  using Got = LineReader::Got;
  EXPECT_EQ(reader->next(line), Got::kLine);
  EXPECT_EQ(line, "one");
  EXPECT_EQ(reader->next(line), Got::kLine);
  EXPECT_EQ(line, "");
  EXPECT_EQ(reader->next(line), Got::kLine);
  EXPECT_EQ(line, longest);
  EXPECT_EQ(reader->next(line), Got::kTooLong);
  EXPECT_EQ(reader->next(line), Got::kTooLong);
  EXPECT_EQ(reader->next(line), Got::kLine);
  EXPECT_EQ(line, "last");
  EXPECT_EQ(reader->next(line), Got::kEnd);
  EXPECT_EQ(reader->next(line), Got::kEnd);
  EXPECT_FALSE(LineReader::open((directory.path() / "none").string()).ok());
}

TEST(RowText, QuotesAndLeavesOutWhatDoesNotApply) {
  constexpr const char* kColumns[] = {"i", "x", "f", "t", "none", "nan"};
  const Row row{std::int64_t{7}, 0.1, 0.1f, std::string_view("a,\"b\"\n"), {}, std::nan("")};
  std::string csv, json;
  append_header(kColumns, RowFormat::kCsv, csv);
  append_row(kColumns, row, RowFormat::kCsv, csv);
  EXPECT_EQ(csv, "i,x,f,t,none,nan\n7,0.1,0.1,\"a,\"\"b\"\"\n\",,\n");
  append_header(kColumns, RowFormat::kJson, json);
  append_row(kColumns, row, RowFormat::kJson, json);
  EXPECT_EQ(json, "{\"i\":7,\"x\":0.1,\"f\":0.1,\"t\":\"a,\\\"b\\\"\\n\"}\n");
}

}  // namespace
}  // namespace tessera::client::query_text
