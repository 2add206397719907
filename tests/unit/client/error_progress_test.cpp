#include "command/measure/error_progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace tessera::client {
namespace {

SamplingProgress after(int rounds, double worst) {
  return {.samples = 33'400'000, .rounds = rounds, .worst = worst, .worst_meter = rounds > 0 ? "desk" : ""};
}

TEST(ErrorProgress, NamesTheWorstMeterAndItsError) {
  EXPECT_EQ(format_error_line(after(1, 0.0234), 0.01), "33.4M samples: desk is within 2.34 %, 1 % is wanted");
  EXPECT_EQ(format_error_line(after(1, 0.0234), 0), "33.4M samples: desk is within 2.34 %");
  EXPECT_EQ(format_error_line({.samples = 64, .rounds = 1}, 0.01), "64 samples: all figures are exact");
  // A quarter of the samples that an error twice as large needs.
  EXPECT_EQ(format_error_bar(after(1, 0.02), 0.01, 80),
            "[=====>              ] 33.4M samples  desk: within 2 %, 1 % is wanted");
  EXPECT_EQ(format_error_bar(after(2, 0.0099), 0.01, 80),
            "[====================] 33.4M samples  desk: within 0.99 %, 1 % is wanted");
  EXPECT_EQ(format_error_bar(after(0, 0), 0.01, 80), "33.4M samples");
  EXPECT_EQ(format_error_bar(after(1, 0.02), 0.01, 24).size(), 23u);
}

TEST(ErrorProgress, WritesALineForEachRoundAndRedrawsABar) {
  std::ostringstream lines, bar, none;
  ErrorProgress in_lines(ProgressMode::kLines, lines, 0.01), in_place(ProgressMode::kBar, bar, 0.01),
      silent(ProgressMode::kSilent, none, 0.01);
  for (ErrorProgress* const progress : {&in_lines, &in_place, &silent}) {
    for (const SamplingProgress& now : {after(0, 0), after(1, 0.2), after(1, 0.2), after(2, 0.1)})
      progress->show(now);
    progress->finish();
  }
  const auto count = [](const std::string& text, char letter) {
    return std::count(text.begin(), text.end(), letter);
  };
  EXPECT_EQ(count(lines.str(), '\n'), 2);
  EXPECT_EQ(count(bar.str(), '\r'), 4);
  EXPECT_EQ(count(bar.str(), '\n'), 1);
  EXPECT_EQ(none.str(), "");
}

}  // namespace
}  // namespace tessera::client
