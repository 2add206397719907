#include "scheduler/policy/job_course.h"

#include <utility>

namespace tessera::server {

void JobCourse::take_turns(FarmJob& job) {
  leave_turns(job);
  if (!job.open() || job.paused) return;
  state_.turns.add(job.number, job.request.priority, job.request.user, job.load_ms);
  state_.jobs_by_scene[job.request.scene_digest].insert(job.number);
}

void JobCourse::leave_turns(const FarmJob& job) {
  state_.turns.remove(job.number);
  const auto scene = state_.jobs_by_scene.find(job.request.scene_digest);
  if (scene == state_.jobs_by_scene.end()) return;
  scene->second.erase(job.number);
  if (scene->second.empty()) state_.jobs_by_scene.erase(scene);
}

void JobCourse::end(FarmJob& job, v1::JobState state, std::string error) {
  for (const LeaseId id : job.leases > 0 ? state_.leases.of_job(job.number) : std::vector<LeaseId>{})
    book_.drop(id);
  leave_turns(job);
  state_.auditing.erase(job.number);
  state_.endangered.erase(job.number);
  job.state = state;
  job.error = std::move(error);
  job.audits.clear();
  job.dangerous.clear();
  job.shorter_runs.clear();
  job.tile_cost_ms = {};
  job.hosts.clear();
  job.scene_faults.clear();
  job.renderers.clear();
  // The failures of an incomplete job are what its report consists of.
  if (state != v1::INCOMPLETE) job.failures.clear();
  FarmEvent& event = state_.record(FarmEvent::Kind::kEnded, job.request.id);
  event.value = state;
  event.text = job.error;
}

}  // namespace tessera::server
