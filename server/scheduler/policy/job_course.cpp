#include "scheduler/policy/job_course.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::server {

void JobCourse::take_turns(FarmJob& job) {
  leave_turns(job);
  if (!job.open() || job.held()) return;
  state_.turns.add(job.number, job.request.priority, job.request.user, job.leased_work_ms);
  state_.jobs_by_scene[job.request.scene_digest].insert(job.number);
}

void JobCourse::leave_turns(const FarmJob& job) {
  state_.turns.remove(job.number);
  const auto scene = state_.jobs_by_scene.find(job.request.scene_digest);
  if (scene == state_.jobs_by_scene.end()) return;
  scene->second.erase(job.number);
  if (scene->second.empty()) state_.jobs_by_scene.erase(scene);
}

void JobCourse::await_others(FarmJob& job) {
  for (const std::string& id : job.request.after) {
    const auto other = state_.jobs_by_id.find(id);
    if (other == state_.jobs_by_id.end() || other->second->state == v1::DONE) continue;
    job.awaited.insert(id);
    state_.awaiting[id].insert(job.number);
  }
}

std::vector<FarmJob*> JobCourse::take_awaiting(const std::string& job) {
  std::vector<FarmJob*> jobs;
  const auto found = state_.awaiting.find(job);
  if (found == state_.awaiting.end()) return jobs;
  for (const std::uint64_t number : found->second) {
    const auto waiting = state_.jobs_by_number.find(number);
    if (waiting == state_.jobs_by_number.end() || !waiting->second->open()) continue;
    waiting->second->awaited.erase(job);
    jobs.push_back(waiting->second.get());
  }
  state_.awaiting.erase(found);
  return jobs;
}

void JobCourse::fail_awaiting(const std::string& job, const std::string& why) {
  // A loop: how many jobs await one another in a row is up to those who submit them.
  std::vector<std::pair<std::string, std::string>> lost{{job, why}};
  while (!lost.empty()) {
    const auto [id, reason] = std::move(lost.back());
    lost.pop_back();
    for (FarmJob* const waiting : take_awaiting(id)) {
      if (!waiting->open()) continue;
      end_alone(*waiting, v1::FAILED, absl::StrCat("job ", id, ", which had to be done first, ", reason));
      lost.emplace_back(waiting->request.id, "failed");
    }
  }
}

void JobCourse::end(FarmJob& job, v1::JobState state, std::string error) {
  const std::string id = job.request.id;
  end_alone(job, state, std::move(error));
  if (state == v1::DONE) {
    for (FarmJob* const waiting : take_awaiting(id)) take_turns(*waiting);
  } else if (state != v1::INCOMPLETE) {
    fail_awaiting(id, state == v1::CANCELLED ? "was cancelled" : "failed");
  }
}

void JobCourse::end_alone(FarmJob& job, v1::JobState state, std::string error) {
  for (const LeaseId id : job.leases > 0 ? state_.leases.of_job(job.number) : std::vector<LeaseId>{})
    book_.drop(id);
  leave_turns(job);
  state_.auditing.erase(job.number);
  state_.endangered.erase(job.number);
  job.state = state;
  job.error = std::move(error);
  state_.checking.erase(job.number);
  job.audits.clear();
  job.spots.clear();
  job.standing_by_identity.clear();
  job.alarms.clear();
  job.dangerous.clear();
  job.shorter_runs.clear();
  job.tile_cost_ms = {};
  job.hosts.clear();
  job.scene_faults.clear();
  job.hosts_with_results.clear();
  // The failures of an incomplete job are what its report consists of.
  if (state != v1::INCOMPLETE) job.failures.clear();
  FarmEvent& event = state_.record(FarmEvent::Kind::kEnded, job.request.id);
  event.value = state;
  event.text = job.error;
}

}  // namespace tessera::server
