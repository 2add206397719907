// Second opinions on the results of one job.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scheduler/unit_ledger.h"

namespace tessera::server {

/// One a host.
using Opinions = std::vector<std::pair<std::string, ResultFingerprint>>;

/// Second opinions on one result.
struct Audit {
  Opinions opinions;                  // the accepted result's first
  std::string arithmetic_class = {};  // class of the accepted result: others do not compare
  bool lost = false;                  // whoever was asked did not answer
  std::string asked_of = {};  // the identity whose opinion is to be the second; empty: whoever comes first

  /// A second opinion is asked for once, whatever becomes of it; who decides between two is asked until
  /// somebody does.
  bool is_over() const { return lost && opinions.size() == 1; }
};

/// Audits by the first unit of the result: some wait for somebody to make them, the others are out. Finding
/// the ones that wait takes as long as there are of them.
class AuditTable {
 public:
  bool empty() const { return audits_.empty(); }
  std::size_t size() const { return audits_.size(); }
  /// How many somebody is at.
  std::size_t out() const { return audits_.size() - waiting_.size(); }
  /// Units of those that wait, ascending.
  const std::set<std::uint32_t>& waiting() const { return waiting_; }
  bool waits(std::uint32_t unit) const { return waiting_.contains(unit); }
  /// Null where there is none.
  const Audit* find(std::uint32_t unit) const;

  /// From now on it waits, in place of one that is there.
  void put(std::uint32_t unit, Audit audit);
  void erase(std::uint32_t unit);
  void erase_if(const std::function<bool(std::uint32_t unit, const Audit&)>& is_meant);
  void clear();

  // The audit of the unit must be there.
  void add_opinion(std::uint32_t unit, const std::string& host, ResultFingerprint result);
  /// Somebody is at it.
  void take(std::uint32_t unit);

  /// Nobody is at it any more, and whoever was has not answered. Nothing happens where there is none.
  void give_back(std::uint32_t unit);
  /// Opinions of these hosts count no more.
  void drop_opinions(const std::function<bool(const std::string& host)>& is_meant);

 private:
  std::map<std::uint32_t, Audit> audits_;
  std::set<std::uint32_t> waiting_;
};

}  // namespace tessera::server
