// Spots of one job's results that others render again, and what is known of the identities that made these.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scheduler/lease_table.h"
#include "scheduler/unit_ledger.h"

namespace tessera::server {

/// A spot of a result (spot.h), as the result has it.
struct Spot {
  std::uint32_t number = 0;  // 0: the result can be checked as a whole only
  ResultFingerprint fingerprint = 0;
  double share = 1;  // part of the result's work that it is
};

/// A spot that another identity is to render.
struct SpotCheck {
  Spot spot;
  std::string maker;    // identity
  std::string checker;  // the identity that is asked
  std::string arithmetic_class;
  std::uint32_t covers = 0;      // an answer that agrees speaks for the maker's results up to this number
  std::set<std::string> silent;  // identities that were asked and did not answer
  Time since{};                  // time when it began to wait, or somebody took it
};

/// Checks by the first unit of the result: some wait for somebody to make them, the others are out.
class SpotTable {
 public:
  bool empty() const { return checks_.empty(); }
  std::size_t size() const { return checks_.size(); }
  std::size_t out() const { return checks_.size() - waiting_.size(); }
  const std::map<std::uint32_t, SpotCheck>& all() const { return checks_; }
  /// Units of those that wait, ascending.
  const std::set<std::uint32_t>& waiting() const { return waiting_; }
  bool waits(std::uint32_t unit) const { return waiting_.contains(unit); }
  /// Null where there is none.
  const SpotCheck* find(std::uint32_t unit) const;

  void put(std::uint32_t unit, SpotCheck check);
  void erase(std::uint32_t unit);
  void clear();
  /// Somebody is at it.
  void take(std::uint32_t unit, Time now);
  /// It waits for another identity.
  void ask(std::uint32_t unit, std::string checker, Time now);
  /// Whoever was at it has not answered. Nothing happens where there is none.
  void give_back(std::uint32_t unit, const std::string& identity);

 private:
  std::map<std::uint32_t, SpotCheck> checks_;
  std::set<std::uint32_t> waiting_;
};

/// How far others have confirmed what one identity did for a job.
class Standing {
 public:
  struct Result {
    std::uint32_t first = 0, units = 0, sequence = 0;
    Spot spot;
  };

  /// Results since the latest that was confirmed, by sequence number.
  const std::vector<Result>& open() const { return open_; }
  /// Units of these.
  std::uint64_t unconfirmed() const { return unconfirmed_; }
  std::uint32_t confirmations() const { return confirmations_; }

  void add(Result result);
  /// A result was checked and is right, which speaks for those up to this number.
  void confirm(std::uint32_t up_to);
  /// The result counts no more.
  void forget(std::uint32_t sequence);

  std::optional<std::uint32_t> asked;  // first unit of the result that was last asked of others
  Time asked_at{};
  std::uint32_t covers = 0;  // an answer to that speaks for results up to this number
  double ask_from = 0;       // unconfirmed units, before which it is in vain to ask
  std::uint32_t unanswered_checks = 0;
  std::uint32_t false_alarms = 0;  // spots of others that differed, as it said, in results that were right

 private:
  std::vector<Result> open_;
  std::uint64_t unconfirmed_ = 0;
  std::uint32_t confirmations_ = 0;
};

}  // namespace tessera::server
