#include "command/report/progress.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

namespace tessera::client {
namespace {

using std::chrono::milliseconds;

Progress::TimePoint at(int ms) { return Progress::TimePoint(milliseconds(ms)); }

TEST(Progress, CountsHaveThreeDigits) {
  EXPECT_EQ(format_count(0), "0");
  EXPECT_EQ(format_count(999), "999");
  EXPECT_EQ(format_count(1000), "1.00k");
  EXPECT_EQ(format_count(12345), "12.3k");
  EXPECT_EQ(format_count(999499), "999k");
  EXPECT_EQ(format_count(999500), "1.00M");
  EXPECT_EQ(format_count(9.999e6), "10.0M");
  EXPECT_EQ(format_count(1.8e19), "18000P");
}

TEST(Progress, DurationsRoundUp) {
  EXPECT_EQ(format_duration(0), "0:00");
  EXPECT_EQ(format_duration(0.1), "0:01");
  EXPECT_EQ(format_duration(59.5), "1:00");
  EXPECT_EQ(format_duration(4000), "1:06:40");
  EXPECT_EQ(format_duration(-1), "0:00");
}

TEST(Progress, BarShowsSamplesRateAndTimeLeft) {
  const ProgressState state{"box", 0.5, 32'000'000, 64'000'000, 4, 8'000'000, 4};
  EXPECT_EQ(format_bar(state, 100),
            "box [===============>              ]   50%  32.0M of 64.0M samples  8.00M/s  0:04 left");
}

TEST(Progress, BarNeverFillsTheLastColumn) {
  const ProgressState state{"a rather long label of a scene", 1.0 / 64e6, 1, 64'000'000, 4, 0.25, 1e9};
  for (int columns = 1; columns < 140; ++columns) {
    EXPECT_LE(format_bar(state, columns).size(), std::size_t(std::max(columns - 1, 1)));
  }
}

TEST(Progress, NothingToDoIsDone) {
  EXPECT_EQ(format_line({"box", 1, 0, 0, 1.5}), "box: 100% (0 samples), in 0:02");
}

TEST(Progress, HundredPercentMeansDone) {
  EXPECT_EQ(format_line({"box", 0.999999, 999'999, 1'000'000, 1}), "box: 99% (1.00M of 1.00M samples)");
}

TEST(Progress, LinesComeEveryTwoSecondsAndAtTheEnd) {
  std::ostringstream out;
  Progress progress(ProgressMode::kLines, out, "box", 10'000, at(0));
  for (int ms = 0; ms <= 5000; ms += 50) progress.update(std::uint64_t(ms), at(ms));
  progress.update(10'000, at(5050));
  progress.finish(at(5050));
  EXPECT_EQ(out.str(),
            "box: 0% (0 of 10.0k samples)\n"
            "box: 20% (2.00k of 10.0k samples), 1.00k samples/s, 0:08 left\n"
            "box: 40% (4.00k of 10.0k samples), 1.00k samples/s, 0:06 left\n"
            "box: 100% (10.0k of 10.0k samples), 1.98k samples/s, in 0:06\n");
}

TEST(Progress, WhereTheNoiseDecidesOnlyWhatWasTakenIsCounted) {
  std::ostringstream out;
  Progress progress(ProgressMode::kLines, out, "box", /*samples_total=*/0, at(0));
  progress.update({0.25, 1'000}, at(0));
  progress.update({0.5, 3'000}, at(4000));
  progress.update({1, 4'000}, at(8000));
  progress.finish(at(8000));
  // A quarter of the work took four seconds; half of it is left.
  EXPECT_EQ(out.str(),
            "box: 25% (1.00k samples)\n"
            "box: 50% (3.00k samples), 500 samples/s, 0:08 left\n"
            "box: 100% (4.00k samples), 375 samples/s, in 0:08\n");
}

TEST(Progress, SaysOnceWhatItWaitsFor) {
  std::ostringstream out;
  Progress progress(ProgressMode::kLines, out, "box", 100, at(0));
  for (int ms = 0; ms < 9000; ms += 1000)
    progress.update({}, at(ms), ms < 5000 ? "waiting for a worker" : "building");
  progress.update({0.5, 50}, at(9000));
  EXPECT_EQ(out.str(),
            "box: waiting for a worker\n"
            "box: building\n"
            "box: 50% (50 of 100 samples), 6 samples/s, 0:09 left\n");
}

TEST(Progress, TheEndIsNotSaidTwice) {
  std::ostringstream out;
  Progress progress(ProgressMode::kLines, out, "box", 10, at(0));
  progress.update(10, at(1));
  progress.finish(at(1));
  EXPECT_EQ(out.str(), "box: 100% (10 of 10 samples), in 0:01\n");
}

TEST(Progress, WhatWasThereBeforeIsNotPartOfTheRate) {
  std::ostringstream out;
  Progress progress(ProgressMode::kLines, out, "box", 10'000, at(0));
  progress.update(5'000, at(0));
  progress.update(6'000, at(2000));
  EXPECT_EQ(out.str(),
            "box: 50% (5.00k of 10.0k samples)\n"
            "box: 60% (6.00k of 10.0k samples), 500 samples/s, 0:08 left\n");
}

TEST(Progress, BarIsRedrawnAtMostTenTimesASecond) {
  std::ostringstream out;
  Progress progress(ProgressMode::kBar, out, "box", 1000, at(0));
  for (int ms = 0; ms < 1000; ++ms) progress.update(std::uint64_t(ms), at(ms));
  const std::string text = out.str();
  EXPECT_EQ(std::ranges::count(text, '\r'), 10);
  EXPECT_EQ(std::ranges::count(text, '\n'), 0);
  progress.update(1000, at(1000));
  progress.finish(at(1000));
  EXPECT_TRUE(out.str().ends_with("in 0:01\n"));
}

TEST(Progress, ClearMakesRoomForOtherOutput) {
  std::ostringstream out;
  Progress progress(ProgressMode::kBar, out, "box", 1000, at(0));
  progress.clear();
  EXPECT_EQ(out.str(), "");
  progress.update(1, at(0));
  progress.clear();
  EXPECT_TRUE(out.str().ends_with("\r\x1b[K"));
  const std::size_t before = out.str().size();
  progress.update(2, at(1));  // drawn again at once
  EXPECT_GT(out.str().size(), before);
}

TEST(Progress, SilentSaysNothing) {
  std::ostringstream out;
  Progress progress(ProgressMode::kSilent, out, "box", 10, at(0));
  progress.update(5, at(5000));
  progress.finish(at(10000));
  EXPECT_EQ(out.str(), "");
}

TEST(Progress, PipesGetLines) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  EXPECT_EQ(progress_mode(ends[1], false), ProgressMode::kLines);
  EXPECT_EQ(progress_mode(ends[1], true), ProgressMode::kSilent);
  EXPECT_EQ(terminal_columns(ends[1]), 80);
  close(ends[0]);
  close(ends[1]);
}

}  // namespace
}  // namespace tessera::client
