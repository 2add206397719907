// Which hosts a job's results are from, and how long they took.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tessera/v1/farm.pb.h"

namespace tessera::server {

/// How one host fares with the units of one job.
struct HostShare {
  std::string host;
  std::uint32_t units = 0;
  std::chrono::nanoseconds mean{0};  // of a unit
};

class HostShares {
 public:
  static constexpr std::size_t kMostHosts = 8192;       // beyond, hosts that come late are not told apart
  static constexpr std::uint32_t kLeastTimedUnits = 4;  // before that, one expensive unit would speak for the host
  static constexpr double kSlow = 2;

  /// A result of so many units counts.
  void count(const std::string& host, std::uint32_t units);
  /// One of its results does not count any more.
  void discount(const std::string& host, std::uint32_t units);
  /// None counts, until they are counted again.
  void clear_counts();
  /// How long a unit took on one thread, on average over those of a result; 0 when they were not rendered for this job.
  void time(const std::string& host, std::chrono::nanoseconds taken);

  using Saved = google::protobuf::RepeatedPtrField<v1::JobCost::Host>;
  static HostShares restored(const Saved& saved);
  void save(Saved& saved) const;

  std::uint32_t units_of(const std::string& host) const;
  /// Those whose results count.
  std::vector<std::string> hosts() const;

  /// Median of the hosts' means; 0 while fewer than two hosts have units enough to be compared.
  std::chrono::nanoseconds usual() const;
  /// Hosts whose units take kSlow times the usual and more, the slowest first.
  std::vector<HostShare> slow() const;

 private:
  struct Share {
    std::uint32_t units = 0;
    std::uint32_t timed_units = 0;
    std::chrono::nanoseconds total{0};

    std::chrono::nanoseconds mean() const { return total / timed_units; }
  };
  Share* share_of(const std::string& host);

  std::map<std::string, Share> hosts_;
};

}  // namespace tessera::server
