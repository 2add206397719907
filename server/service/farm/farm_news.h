// News of a farm, for those who count it or write it down.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

struct JobEntry;
struct WorkerInfo;
struct WorkerView;

/// References hold while an observer is told.
namespace news {

// ---- the farm

/// Calls that go through the farm's lock, and its tick.
enum class Call { kLease, kHeartbeat, kComplete, kFail, kTick, kCount };
struct CallServed {
  Call call;
  std::chrono::nanoseconds taken;  // duration, with the wait for the lock
};
struct Committed {
  std::chrono::nanoseconds taken;  // time from the change until it is durable, or known not to be
  std::uint64_t entries;           // entries of the journal
};
/// Told once.
struct JournalFailed {
  const absl::Status& why;
};
struct HostDistrusted {
  const std::string& host;
  const std::string& why;
};

// ---- jobs

struct JobSubmitted {
  const JobEntry& job;
};
struct ResultsAdopted {
  const JobEntry& job;
  const std::string& donor;  // identifier of a job
};
/// A job of an earlier coordinator goes on.
struct JobRecovered {
  const JobEntry& job;
  std::uint32_t units_done;
};
/// Results that were journaled are not on the disk any more.
struct ResultsLost {
  const JobEntry& job;
  std::uint64_t results;
};
struct JobEnded {
  const JobEntry& job;
  v1::JobState state;
  const std::string& error;
};
struct JobNoted {
  const JobEntry& job;
  const std::string& text;
};
/// The job is over, and has results of a host, or an identity, that turned out to be wrong.
struct ResultsDoubted {
  const JobEntry& job;
  const std::string& subject;
  std::uint32_t units;
};
struct JobDeleted {
  const JobEntry& job;
  bool on_request;  // else its time is over
};
struct BlobUploaded {
  std::uint64_t bytes;
};

// ---- workers

struct RegistrationRefused {
  const v1::RegisterRequest& request;
  const std::string& peer;
  const absl::Status& why;
};
struct WorkerRegistered {
  const v1::RegisterRequest& request;
  const std::string& id;
  const std::string& host;
  const std::string& peer;
};
struct WorkerLeft {
  const std::string& id;
  const std::string& name;
};
struct WorkerExpelled {
  const WorkerView& worker;
};
struct WorkerLost {
  const WorkerInfo& worker;
};
struct LeasesLost {
  std::uint64_t leases;
};
/// No message has room for more workers than this.
struct WorkerListCut {
  int workers;
};

// ---- units

struct UnitsLeased {
  std::uint64_t units;
};
struct ResultAccepted {
  const std::string& worker;  // name of the worker
  const v1::LeaseToken& token;
  std::chrono::nanoseconds unit_time;
  std::uint64_t bytes;
};
/// A result that was there already.
struct ResultRepeated {};
struct ResultRefused {
  enum class Reason {
    kNotGranted,    // There was no such lease.
    kUnsound,       // the payload is none of this unit's
    kMisrendered,   // the payload is whole, and none that a renderer makes: the unit failed
    kContradicted,  // another result of the unit was accepted before
    kNotWanted,
  };
  const std::string& worker;  // name of the worker
  const v1::LeaseToken& token;
  Reason reason;
  const absl::Status& why;
};
struct UnitFailed {
  const std::string& worker;  // name of the worker
  const v1::LeaseToken& token;
  const std::string& message;
};

}  // namespace news

using FarmNews =
    std::variant<news::CallServed, news::Committed, news::JournalFailed, news::HostDistrusted,
                 news::JobSubmitted, news::ResultsAdopted, news::JobRecovered, news::ResultsLost,
                 news::JobEnded, news::JobNoted, news::ResultsDoubted, news::JobDeleted, news::BlobUploaded,
                 news::RegistrationRefused, news::WorkerRegistered, news::WorkerLeft, news::WorkerExpelled,
                 news::WorkerLost, news::LeasesLost, news::WorkerListCut, news::UnitsLeased,
                 news::ResultAccepted, news::ResultRepeated, news::ResultRefused, news::UnitFailed>;

/// Told from any thread, with the farm's lock held or not: returns at once, and calls nothing of the farm.
class FarmObserver {
 public:
  virtual ~FarmObserver() = default;
  virtual void note(const FarmNews& news) = 0;
};

}  // namespace tessera::server
