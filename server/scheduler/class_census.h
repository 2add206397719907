// Which arithmetic classes the farm has, and with how many threads.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "scheduler/scheduler_types.h"

namespace tessera::server {

/// Whether a worker has all tags that a job requires.
bool has_tags(const WorkerInfo& worker, const std::vector<std::string>& required);

/// Counts the workers that may be given units. Machines of one kind are counted together, so looking takes as
/// long as there are kinds of machines.
class ClassCensus {
 public:
  /// Requirements of a job on its workers.
  struct Demand {
    std::string_view isa;  // empty: any
    const std::vector<std::string>& tags;
    std::uint32_t max_workers = 0;  // at a time; 0: any number
  };

  void add(const WorkerInfo& worker);
  void remove(const WorkerInfo& worker);
  /// Goes up whenever a worker comes or goes.
  std::uint64_t revision() const { return revision_; }
  /// Whether there is a worker of just these classes.
  bool has(const std::vector<std::string>& classes) const;

  /// The class in which most threads may work; of equal ones that which its workers like best. Empty when
  /// there is none.
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

  std::map<Kind, std::uint64_t> workers_;
  std::uint64_t revision_ = 1;
};

}  // namespace tessera::server
