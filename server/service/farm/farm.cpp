#include "service/farm/farm.h"

#include <utility>

#include "service/farm/farm_core.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/job_retention.h"
#include "service/farm/job_submission.h"
#include "service/farm/unit_results.h"
#include "service/farm/user_shares.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"

namespace tessera::server {

/// Each leans on those before it.
struct Farm::Parts {
  FarmCore core;
  UserShares shares{core};
  JobSubmission submission{core, shares};
  WorkerRegistry workers{core};
  WorkerLeases leases{core, workers};
  UnitResults results{core, workers, leases, shares};
  FarmViews views{core, workers};
  JobRetention retention{core, leases};
  JobControl jobs{core, shares, retention, views};

  Parts(Journal& journal, BlobStore& blobs, const FarmOptions& options,
        std::function<void(absl::Status)> on_failure)
      : core(journal, blobs, options, std::move(on_failure)) {}

  void tick() {
    workers.give_up_lost();
    core.commit();
    retention.tick();
  }
};

Farm::Farm(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

absl::StatusOr<std::unique_ptr<Farm>> Farm::open(Journal& journal, BlobStore& blobs,
                                                 const FarmOptions& options,
                                                 std::function<void(absl::Status)> on_failure) {
  std::unique_ptr<Farm> farm(
      new Farm(std::make_unique<Parts>(journal, blobs, options, std::move(on_failure))));
  Parts& parts = *farm->parts_;
  if (absl::Status status = parts.core.recover(); !status.ok()) return status;
  parts.core.start([&parts] { parts.tick(); });
  return farm;
}

Farm::~Farm() {
  stop();
  // Changes that wait for the disk may still ask a part.
  parts_->core.close();
}

void Farm::stop() {
  if (parts_->core.stop()) parts_->retention.stop();
}

bool Farm::stopping() const { return parts_->core.stopping(); }
base::Clock& Farm::clock() const { return parts_->core.clock(); }
void Farm::subscribe(std::function<bool()> wake) { parts_->core.dispatcher().subscribe(std::move(wake)); }

JobSubmission& Farm::submission() { return parts_->submission; }
JobControl& Farm::jobs() { return parts_->jobs; }
FarmViews& Farm::views() { return parts_->views; }
UserShares& Farm::shares() { return parts_->shares; }
WorkerRegistry& Farm::workers() { return parts_->workers; }
WorkerLeases& Farm::leases() { return parts_->leases; }
UnitResults& Farm::results() { return parts_->results; }

}  // namespace tessera::server
