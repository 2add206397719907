// Rows of what a page shows, with what changed since a page was last told.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tessera/v1/farm.pb.h"

namespace tessera::server {

/// A table whose rows change: who has seen it up to a version gets the rows that are newer. Not thread-safe.
class Board {
 public:
  /// A row's name and its contents, in JSON.
  using Rows = std::vector<std::pair<std::string, std::string>>;

  static constexpr std::size_t kMostGone = 20'000;

  /// The table is this now, in this order.
  void update(Rows rows);

  std::uint64_t version() const { return version_; }

  struct News {
    std::vector<std::string> rows;  // rows in the order in which they came
    std::vector<std::string> gone;  // names
    bool all = false;               // forget all other rows
    bool empty() const { return rows.empty() && gone.empty() && !all; }
  };
  /// The changes after `version`; 0: everything.
  News since(std::uint64_t version) const;

 private:
  struct Row {
    std::string json;
    std::uint64_t version = 0;
    std::uint64_t last_seen_round = 0;
    std::uint64_t order = 0;
  };

  std::map<std::string, Row> rows_;
  std::deque<std::pair<std::uint64_t, std::string>> gone_;  // version, name
  std::uint64_t forgotten_ = 0;  // rows that went at this version or before are not in gone_
  std::uint64_t version_ = 1, round_ = 0, order_ = 0;
};

/// The row of a job in a page's list, and of a worker; values that change all the time are rounded, so
/// that rows change seldom.
std::string row_of(const v1::JobStatus& job);
/// `heartbeats`: how often it is to be heard of.
std::string row_of(const v1::WorkerStatus& worker, std::chrono::milliseconds heartbeats);
/// Everything that is known of one job: its units that were set aside, failures, notes, warnings, and
/// settings.
std::string details_of(const v1::GetJobResponse& job);

}  // namespace tessera::server
