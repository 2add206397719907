// The coordinator's logic behind its services: parts over one core.
#pragma once

#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "service/farm/farm_options.h"

namespace tessera::server {

class BlobStore;
class FarmViews;
class JobControl;
class JobSubmission;
class Journal;
class UnitResults;
class UserShares;
class WorkerLeases;
class WorkerRegistry;

/// Owns the parts of a farm. Safe to use from any number of threads, and so are they.
class Farm {
 public:
  /// Recovers the journal's jobs. `on_failure` is called, once, when the journal can no longer be written:
  /// nothing is acknowledged from then on. Journal and blobs must outlive the farm.
  static absl::StatusOr<std::unique_ptr<Farm>> open(Journal& journal, BlobStore& blobs,
                                                    const FarmOptions& options,
                                                    std::function<void(absl::Status)> on_failure);
  /// Answers what waits, and commits all that is left.
  ~Farm();

  /// Answers all waiting calls with Unavailable, and all later ones. Not to be called from a `done` or a
  /// `wake`.
  void stop();
  bool stopping() const;
  base::Clock& clock() const;

  // ---- for clients

  JobSubmission& submission();
  JobControl& jobs();
  FarmViews& views();
  UserShares& shares();
  /// Calls `wake`, from one thread for all, after each change of any job and every second or so; false from
  /// `wake` ends that.
  void subscribe(std::function<bool()> wake);

  // ---- for workers

  WorkerRegistry& workers();
  WorkerLeases& leases();
  UnitResults& results();

 private:
  struct Parts;
  explicit Farm(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tessera::server
