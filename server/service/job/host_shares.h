// Which hosts a job's results are from, and how long they took.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "scheduler/worker_pace.h"
#include "tessera/v1/farm.pb.h"

namespace tessera::server {

/// How one host fares with the units of one job.
struct HostShare {
  std::string host;
  std::uint32_t timed_units = 0;
  double slowness = 1;  // their time, as a multiple of the usual host's
};

class HostShares {
 public:
  static constexpr std::size_t kMostHosts = 8192;  // beyond, hosts that come late are not told apart
  static constexpr double kSlow = 2;

  /// A result of so many units counts.
  void count(const std::string& host, std::uint32_t units);
  /// One of its results does not count any more.
  void discount(const std::string& host, std::uint32_t units);
  /// None counts, until they are counted again.
  void clear_counts();
  /// How long a unit took on one thread, on average over those of a result; 0 when they were not rendered for
  /// this job.
  void time(const std::string& host, std::chrono::nanoseconds taken);

  using Saved = google::protobuf::RepeatedPtrField<v1::JobCost::Host>;
  static HostShares restored(const Saved& saved);
  void save(Saved& saved) const;

  std::uint32_t units_of(const std::string& host) const;
  /// Returns the hosts whose results count.
  std::vector<std::string> hosts() const;

  /// Hosts whose units take kSlow times the usual and more beyond doubt, the slowest first. Hosts are
  /// compared by the units that they return one after the other (scheduler/worker_pace.h), for a job's units
  /// cost very differently.
  std::vector<HostShare> slow() const;

 private:
  struct Share {
    std::uint32_t units = 0;
    std::uint32_t timed_units = 0;
    WorkerPace pace;
  };
  Share* share_of(const std::string& host);
  UsualPace usual() const;

  std::map<std::string, Share> hosts_;
  JobPace job_{0};  // the only one that these paces are compared in
  UsualPace usual_;
  std::size_t timed_ = 0;  // results timed since usual_ was made
};

}  // namespace tessera::server
