#include "service/web/board.h"

#include <gmock/gmock.h>

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Board, TellsWhatChanged) {
  Board board;
  board.update({{"b", "B1"}, {"a", "A1"}});
  const Board::News first = board.since(0);
  EXPECT_TRUE(first.all);
  EXPECT_THAT(first.rows, ElementsAre("B1", "A1")) << "in the order in which they came";
  const std::uint64_t seen = board.version();
  board.update({{"b", "B1"}, {"a", "A1"}});
  EXPECT_EQ(board.version(), seen);
  EXPECT_TRUE(board.since(seen).empty());
  board.update({{"b", "B2"}, {"c", "C1"}});
  const Board::News news = board.since(seen);
  EXPECT_FALSE(news.all);
  EXPECT_THAT(news.rows, ElementsAre("B2", "C1"));
  EXPECT_THAT(news.gone, ElementsAre("a"));
  EXPECT_THAT(board.since(board.version()).rows, IsEmpty());
}

TEST(Board, TellsEverythingWhereItForgotWhatWent) {
  Board board;
  Board::Rows rows;
  for (std::size_t i = 0; i <= Board::kMostGone; ++i) rows.emplace_back(std::to_string(i), "x");
  board.update(rows);
  const std::uint64_t seen = board.version();
  board.update({{"left", "L"}});
  const Board::News news = board.since(seen);
  EXPECT_TRUE(news.all);
  EXPECT_THAT(news.rows, ElementsAre("L"));
}

TEST(Board, RowsAreJsonWhateverNamesHold) {
  v1::JobStatus job;
  job.set_job_id("1");
  job.set_name("\"},<script>\x01\xff");
  EXPECT_THAT(row_of(job), testing::HasSubstr("\\\"},<script>\\u0001\xef\xbf\xbd"));
}

TEST(Board, TellsSilenceAfterAMissedHeartbeat) {
  v1::WorkerStatus worker;
  worker.set_last_seen_ms_ago(1500);
  EXPECT_THAT(row_of(worker, std::chrono::milliseconds{1000}), testing::HasSubstr("\"silent\":0"));
  worker.set_last_seen_ms_ago(1700);
  EXPECT_THAT(row_of(worker, std::chrono::milliseconds{1000}), testing::HasSubstr("\"silent\":2"));
  EXPECT_THAT(row_of(worker, std::chrono::milliseconds{2000}), testing::HasSubstr("\"silent\":0"));
}

}  // namespace
}  // namespace tessera::server
