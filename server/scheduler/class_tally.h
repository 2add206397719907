// Which arithmetic classes the farm has, who computes in them, and with how many threads.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "scheduler/scheduler_types.h"

namespace tessera::server {

/// Whether a worker has all tags that a job requires.
bool has_tags(const WorkerInfo& worker, const std::vector<std::string>& required);

/// Counts the workers that may be given units, and chooses the class of a job. A class is a worker's own
/// claim, and so are its threads: what counts is how many identities (identity.h) claim a class, and whether
/// they have confirmed each other's results in it. Machines of one kind are counted together, so looking
/// takes as long as there are kinds of machines, and identities where there are several classes.
class ClassTally {
 public:
  /// Requirements of a job on its workers.
  struct Demand {
    std::string_view isa;  // empty: any
    const std::vector<std::string>& tags;
    std::uint32_t max_workers = 0;  // workers at a time; 0: any number
  };
  // Bounds of what is remembered; further claims are not.
  static constexpr std::size_t kMostConfirmedClasses = 256, kMostConfirmedIdentities = 16'384;

  /// `named`: classes that the operator vouches for.
  explicit ClassTally(const std::vector<std::string>& named = {}) : named_(named.begin(), named.end()) {}

  void add(const WorkerInfo& worker, std::uint32_t threads);
  void remove(const WorkerInfo& worker, std::uint32_t threads);
  /// Another identity of the class has the same result as this one. False when that is known already.
  bool confirm(const std::string& name, const std::string& identity);
  bool is_confirmed(const std::string& name, const std::string& identity) const;
  /// Goes up whenever another class may be the best.
  std::uint64_t revision() const { return revision_; }
  /// Whether there is a worker of just these classes.
  bool has(const std::vector<std::string>& classes) const;
  /// Whether there is a worker of this class that has the tags.
  bool offers(const std::string& name, const std::vector<std::string>& tags) const;

  /// The class of a new job; empty when there is none. Of classes that the operator named, or in which two
  /// identities that are here have been confirmed, the one with most threads of those. Where there is no such
  /// class, the one that most identities claim, each counted once; then that with most threads. Of equal ones
  /// that which its workers like best.
  std::string best(const Demand& demand) const;

  /// Workers that have the job's tags and not what it needs besides, by the class that they would choose.
  struct LeftOut {
    std::uint64_t workers = 0, threads = 0;
  };
  /// `needed` is a class, or with `demand.isa` and an empty one any class of that ISA.
  std::map<std::string, LeftOut> without(const std::string& needed, const Demand& demand) const;

 private:
  using Kind = std::tuple<std::vector<std::string>, std::vector<std::string>,
                          std::uint32_t>;  // classes, tags, threads
  struct Group {
    std::uint64_t workers = 0;
    absl::flat_hash_map<std::string, std::uint64_t> worker_count_by_identity;
  };
  struct Offer;
  std::string choose(const Demand& demand) const;
  void add_support(const std::string& name, const Group& group, std::uint32_t threads, Offer& offer) const;

  std::map<Kind, Group> groups_;
  std::set<std::string> named_;
  std::map<std::string, std::set<std::string>> confirmed_;  // class -> identities
  std::uint64_t revision_ = 1;
  // Answers since the last revision, by ISA, tags and number of workers.
  mutable std::map<std::tuple<std::string, std::vector<std::string>, std::uint32_t>, std::string> answers_;
  mutable std::uint64_t answers_revision_ = 0;
};

}  // namespace tessera::server
