// One call, two formats of the log.
#include "telemetry/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "telemetry/line_limit.h"
#include "telemetry/recent_lines.h"

namespace tessera::telemetry {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

class Log : public testing::Test {
 protected:
  void SetUp() override { before_ = spdlog::default_logger(); }
  void TearDown() override { spdlog::set_default_logger(before_); }

  void use(LogFormat format, const std::string& worker = "") {
    auto logger = std::make_shared<spdlog::logger>(
        "tessera-test", std::make_shared<spdlog::sinks::ostream_sink_st>(written_));
    logger->set_formatter(make_log_formatter(format, worker));
    spdlog::set_default_logger(std::move(logger));
  }
  std::string line() { return std::exchange(written_, std::ostringstream{}).str(); }
  nlohmann::json object() { return nlohmann::json::parse(line()); }

  std::ostringstream written_;
  std::shared_ptr<spdlog::logger> before_;
};

TEST_F(Log, TextEndsWithTheFields) {
  use(LogFormat::kText);
  log(spdlog::level::warn, {.job = "4f0c", .unit = 0, .attempt = 3, .worker = "render 7"}, "unit {} failed",
      0);
  EXPECT_THAT(
      line(),
      EndsWith("[tessera-test] [warning] unit 0 failed job=4f0c unit=0 attempt=3 worker=\"render 7\"\n"));
  spdlog::info("about nothing");
  EXPECT_THAT(line(), EndsWith("[info] about nothing\n"));
}

TEST_F(Log, JsonHasTheSameFields) {
  use(LogFormat::kJson);
  log(spdlog::level::warn,
      {.job = "4f0c", .unit = 0, .attempt = 3, .worker = "w", .host = "h", .user = "u", .peer = "p"},
      "unit {} failed", 0);
  const nlohmann::json all = object();
  EXPECT_THAT(all["time"].get<std::string>(),
              testing::MatchesRegex("20[0-9]+-[0-9]+-[0-9]+T[0-9]+:[0-9]+:[0-9]+\\.[0-9][0-9][0-9]Z"));
  const nlohmann::json expected = {{"level", "warning"},
                                   {"program", "tessera-test"},
                                   {"message", "unit 0 failed"},
                                   {"job", "4f0c"},
                                   {"unit", 0},
                                   {"attempt", 3},
                                   {"worker", "w"},
                                   {"host", "h"},
                                   {"user", "u"},
                                   {"peer", "p"}};
  nlohmann::json without_time = all;
  without_time.erase("time");
  EXPECT_EQ(without_time, expected);
  spdlog::info("about nothing");
  EXPECT_FALSE(object().contains("job"));
}

TEST_F(Log, EveryLineOfAWorkerNamesIt) {
  use(LogFormat::kJson, "render7:12");
  spdlog::info("registered");
  EXPECT_EQ(object()["worker"], "render7:12");
  use(LogFormat::kText, "render7:12");
  log(spdlog::level::info, {.job = "4f0c"}, "begun");
  EXPECT_THAT(line(), EndsWith("begun job=4f0c worker=render7:12\n"));
}

// A worker's reports end up in the coordinator's log: it must not be able to write lines of its own
// there.
TEST_F(Log, WhatIsQuotedCannotForgeLines) {
  const std::string evil = "broken\n[2026-01-01] [info] all is well\x1b[2J\r\x7f";
  use(LogFormat::kText);
  log(spdlog::level::warn, {.user = "a\" job=\"b\n"}, "{}", evil);
  const std::string text = line();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_THAT(
      text,
      HasSubstr("broken\\n[2026-01-01] [info] all is well\\x1b[2J\\x0d\\x7f user=\"a\\\" job=\\\"b\\n\"\n"));

  use(LogFormat::kJson);
  log(spdlog::level::warn, {.user = "a\", \"job\": \"b"}, "{}", evil);
  const std::string json = line();
  EXPECT_EQ(std::count(json.begin(), json.end(), '\n'), 1);
  const nlohmann::json read = nlohmann::json::parse(json);
  EXPECT_EQ(read["message"], evil);
  EXPECT_EQ(read["user"], "a\", \"job\": \"b");
  EXPECT_FALSE(read.contains("job"));
  spdlog::info("not UTF-8: \xff");
  EXPECT_EQ(object()["message"], "not UTF-8: \xef\xbf\xbd");
}

TEST(LineLimit, TenAMinuteAndTheRestCounted) {
  LineLimit limit;
  const std::chrono::steady_clock::time_point start{std::chrono::hours{1}};
  for (int i = 0; i < 25; ++i) EXPECT_EQ(limit.count(start + std::chrono::seconds{2 * i}).write, i < 10) << i;
  const LineLimit::Verdict next = limit.count(start + std::chrono::seconds{61});
  EXPECT_TRUE(next.write);
  EXPECT_EQ(next.left_out, 15);
  EXPECT_EQ(limit.count(start + std::chrono::seconds{200}).left_out, 0);
}

TEST_F(Log, TheLastLinesAboutAJobAreKept) {
  use(LogFormat::kText);
  const std::shared_ptr<RecentLines> lines = keep_recent_lines();
  spdlog::warn("the disk is slow");
  spdlog::info("about nothing");
  log(spdlog::level::info, {.job = "4f0c"}, "scene\nbuilt");
  log(spdlog::level::err, {.job = "91be"}, "of another job");
  log(spdlog::level::err, {.job = "4f0c", .unit = 7}, "unit 7 failed");
  EXPECT_THAT(lines->last_about("4f0c", 4096),
              testing::ElementsAre(EndsWith("Z [warning] the disk is slow"),
                                   EndsWith("Z [info] scene\\nbuilt"), EndsWith("Z [error] unit 7 failed")));
  const std::size_t last = std::string{"2026-01-31T12:00:00.000Z [error] unit 7 failed"}.size();
  EXPECT_THAT(lines->last_about("4f0c", last + 20), testing::ElementsAre(EndsWith("unit 7 failed")));
  EXPECT_THAT(lines->last_about("4f0c", last - 3), testing::ElementsAre(EndsWith("unit 7 fai")));
}

}  // namespace
}  // namespace tessera::telemetry
