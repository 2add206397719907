// In whose arithmetic a job is rendered: results of two classes differ in rounding [docs/decisions/0019].
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "scheduler/scheduler.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {

void Scheduler::count(Worker& worker) {
  const bool counts = !worker.draining && trusts(worker.info.host);
  if (worker.counted == counts) return;
  worker.counted = counts;
  counts ? census_.add(worker.info) : census_.remove(worker.info);
}

bool Scheduler::has_class(const std::string& name) const {
  return std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    const std::vector<std::string>& classes = entry.second.info.classes;
    return entry.second.counted && std::find(classes.begin(), classes.end(), name) != classes.end();
  });
}

/// The class in which the job is rendered; before its first unit is given out, the one that it would be bound
/// to now, and none where there is no worker for it. Not of jobs that are for every class.
const std::string& Scheduler::class_of(const Job& job) const {
  const std::string& bound = job.classes.bound();
  // A journal from before classes knows the ISA alone: any class of it will do.
  if (wire::is_whole_class(bound)) return bound;
  if (job.census_revision != census_.revision()) {
    job.census_revision = census_.revision();
    job.best_class = census_.best({.isa = bound.empty() ? std::string_view(job.request.isa) : bound,
                                   .tags = job.request.required_tags,
                                   .max_workers = job.request.max_workers});
  }
  return job.best_class;
}

/// The class in which the worker renders for the job; null when it may not, for its arithmetic.
const std::string* Scheduler::class_for(const Worker& worker, const Job& job) const {
  const std::string_view wanted = job.request.any_class ? std::string_view() : class_of(job);
  const std::string& bound = job.classes.bound();
  const std::string_view isa = bound.empty() ? std::string_view(job.request.isa) : wire::isa_of(bound);
  const std::vector<std::string>& classes = worker.info.classes;
  const auto found = std::find_if(classes.begin(), classes.end(), [&](const std::string& name) {
    return wanted.empty() ? isa.empty() || wire::isa_of(name) == isa : name == wanted;
  });
  return found == classes.end() ? nullptr : &*found;
}

std::string Scheduler::isa_for(const std::string& worker, std::string_view job) const {
  const auto found = workers_.find(worker);
  const absl::StatusOr<const Job*> known = find_job(job);
  if (found == workers_.end() || !known.ok()) return "";
  const std::string* const name = class_for(found->second, **known);
  return name == nullptr ? "" : std::string(wire::isa_of(*name));
}

const std::string& Scheduler::class_of_result(const Job& job, const AcceptedResult& result) const {
  return job.classes.of(result.host < hosts_.size() ? hosts_[result.host] : "", result.sequence);
}

/// Whether the job's class had better be chosen a moment later.
bool Scheduler::settling(const Job& job, Time now) const {
  return !job.request.any_class && job.classes.bound().empty() && now < settled_at_;
}

void Scheduler::bind(Job& job, const std::string& name) {
  const std::string before = job.classes.bound();
  if (job.request.any_class || before == name) return;
  // Results from before classes were told of stay what they are: of some class of that ISA.
  std::vector<AcceptedResult> unclear;
  if (!before.empty()) unclear = job.units.results();
  std::erase_if(unclear,
                [&](const AcceptedResult& result) { return class_of_result(job, result) != before; });
  job.classes.bind(name);
  record(FarmEvent::Kind::kBound, job.request.id).text = name;
  for (const AcceptedResult& result : unclear) note_class(job, hosts_[result.host], result.sequence, before);
}

void Scheduler::note_class(Job& job, const std::string& host, std::uint32_t sequence,
                           const std::string& name) {
  if (!job.classes.note(host, sequence, name)) return;
  FarmEvent& event = record(FarmEvent::Kind::kClassNoted, job.request.id);
  event.host = host;
  event.value = sequence;
  event.text = name;
}

std::string Scheduler::left_out(std::string_view id) const {
  const absl::StatusOr<const Job*> found = find_job(id);
  if (!found.ok() || !(*found)->open()) return "";
  const Job& job = **found;
  const std::string bound = job.request.any_class ? "" : job.classes.bound();
  const bool by_class = wire::is_whole_class(bound);
  const std::string_view isa = bound.empty() ? std::string_view(job.request.isa) : wire::isa_of(bound);
  const auto groups = census_.without(by_class ? bound : "", {.isa = isa, .tags = job.request.required_tags});
  std::string text;
  for (const auto& [name, group] : groups) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", group.workers,
                    group.workers == 1 ? " worker" : " workers", " (", group.threads,
                    group.threads == 1 ? " thread" : " threads", ") of class ", name);
  }
  if (text.empty()) return "";
  return absl::StrCat(text, by_class ? ": the job's bits are those of class " : ": the job is for kernels ",
                      by_class ? bound : std::string(isa),
                      by_class ? " (--bits any lets every machine work)" : "");
}

/// Open jobs of whatever priority that the worker may not work on for its arithmetic.
std::vector<std::string> Scheduler::closed_jobs(const Worker& worker) const {
  std::vector<std::string> closed;
  for (const auto& [number, job] : jobs_) {
    if (closed.size() == kMaxClosedJobs) break;
    if (job->open() && has_tags(worker.info, job->request.required_tags) &&
        class_for(worker, *job) == nullptr) {
      closed.push_back(job->request.id);
    }
  }
  return closed;
}

}  // namespace tessera::server
