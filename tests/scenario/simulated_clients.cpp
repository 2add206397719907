// The clients of the simulated farm, and people who meddle with jobs.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"
#include "scenario/simulation.h"

namespace tessera::server {
namespace {

constexpr std::size_t kMostJobs = 4;

/// Plans are made once: they are the same in every world.
std::shared_ptr<const WorkPlan> plan_of(std::uint32_t tiles, std::uint32_t ranges,
                                        const std::vector<std::uint32_t>& parts) {
  using Key = std::tuple<std::uint32_t, std::uint32_t, std::vector<std::uint32_t>>;
  static std::map<Key, std::shared_ptr<const WorkPlan>> plans;
  auto& plan = plans[{tiles, ranges, parts}];
  if (plan == nullptr) plan = row_of_tiles(tiles, ranges, parts);
  return plan;
}

}  // namespace

void Simulation::submit_job() {
  const std::string id = absl::StrCat("j", promises_.size());
  const bool many = options_.workers > 0;
  // Some continue an earlier job, to more samples or fewer.
  const std::string donor =
      !many && !promises_.empty() && pick(2) == 0 ? absl::StrCat("j", pick(promises_.size())) : "";
  const auto tiles = donor.empty() ? static_cast<std::uint32_t>(many ? options_.workers * 3 : 1 + pick(24))
                                   : promises_.at(donor).request.plan->tile_count();
  std::vector<std::uint32_t> parts;
  if (!donor.empty()) {
    parts = promises_.at(donor).phase_parts;
  } else if (phases_ && !many) {
    parts = {1 + static_cast<std::uint32_t>(pick(24)), 1 + static_cast<std::uint32_t>(pick(4))};
  }
  JobRequest request{
      .id = id,
      .plan = plan_of(tiles, many ? 1 : 1 + static_cast<std::uint32_t>(pick(runs_ ? 12 : 3)), parts),
      .scene_digest = absl::StrCat("s", pick(2)),
      .isa = pick(3) == 0 ? "avx2" : "",
      .priority = static_cast<std::int32_t>(pick(2)),
      .user = absl::StrCat("u", pick(3)),
      .required_tags = {},
      .max_workers = !many && pick(4) == 0 ? 2u : 0u,
      .any_class = pick(3) == 0};
  jobs_.emplace(id, request);
  Promise& promise = promises_[id];
  promise.request = std::move(request);
  promise.donor = donor;
  promise.phase_parts = parts;
  promise.content = donor.empty() ? id : promises_.at(donor).content;
  ask_for_job(id);
}

/// The client asks until it is told.
void Simulation::ask_for_job(const std::string& id) {
  if (promises_.at(id).acknowledged) return;
  to_coordinator([this, id] {
    const Promise& promise = promises_.at(id);
    const JobRequest* const donor = promise.donor.empty() ? nullptr : &promises_.at(promise.donor).request;
    coordinator_->submit(promise.request, donor, [this, id](const absl::Status& status) {
      if (!status.ok()) return violate(status.ToString());
      promises_.at(id).acknowledged = true;
    });
  });
  at(Time(3000), [this, id] { ask_for_job(id); });
}

void Simulation::meddle() {
  at(Time(500 + pick(8000)), [this] { meddle(); });
  const std::string id = absl::StrCat("j", pick(promises_.size()));
  Promise& promise = promises_.at(id);
  if (!chaos_) {
    // Whoever paused a job or distrusts a host comes to their senses.
    if (!coordinator_) return;
    for (const auto& [job, paused] : promises_) {
      if (paused.acknowledged) coordinator_->pause(job, false, [](const absl::Status&) {});
    }
    for (const Worker& worker : workers_)
      static_cast<void>(coordinator_->scheduler().trust_host(worker.host));
    return;
  }
  switch (pick(8)) {
    case 0:
      if (promises_.size() < kMostJobs) submit_job();
      return;
    case 1:
      if (!promise.acknowledged || pick(3) != 0) return;
      return to_coordinator([this, id] {
        const absl::StatusOr<JobView> before = coordinator_->scheduler().job(id);
        const bool open = before.ok() && (before->state == v1::QUEUED || before->state == v1::RUNNING);
        coordinator_->cancel(id, [this, id, open](const absl::Status& status) {
          Promise& cancelled = promises_.at(id);
          // One that was over stays as it was, and if it was incomplete it may be tried again.
          cancelled.cancel_acknowledged |= status.ok() && cancelled.ended == v1::CANCELLED;
          if (status.ok() && open && cancelled.ended != v1::CANCELLED)
            violate("a cancellation is not durable");
        });
      });
    case 2:
    case 3:
      if (!promise.acknowledged) return;
      return to_coordinator(
          [this, id, pause = pick(2) == 0] { coordinator_->pause(id, pause, [](const absl::Status&) {}); });
    case 4:
      if (promise.acknowledged)
        to_coordinator([this, id] { coordinator_->retry(id, [](const absl::Status&) {}); });
      return;
    default:
      return;
  }
}

bool Simulation::all_ended() const {
  return std::all_of(promises_.begin(), promises_.end(),
                     [](const auto& entry) { return entry.second.ended != v1::JOB_STATE_UNSPECIFIED; });
}

}  // namespace tessera::server
