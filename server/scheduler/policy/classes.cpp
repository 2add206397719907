#include "scheduler/policy/classes.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "scheduler/identity.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {

void Classes::count(FarmWorker& worker) {
  const bool counts = !worker.draining && trust_.trusts(worker.info.host);
  if (worker.is_tallied == counts) return;
  worker.is_tallied = counts;
  counts ? state_.class_tally.add(worker.info, worker.counted_threads)
         : state_.class_tally.remove(worker.info, worker.counted_threads);
}

void Classes::count_threads(FarmWorker& worker, std::uint32_t threads) {
  if (worker.counted_threads == threads) return;
  if (worker.is_tallied) {
    state_.class_tally.remove(worker.info, worker.counted_threads);
    state_.class_tally.add(worker.info, threads);
  }
  state_.total_threads += threads;
  state_.total_threads -= worker.counted_threads;
  worker.counted_threads = threads;
}

void Classes::confirm(const std::string& name, const std::string& identity, const std::string& other) {
  for (const std::string& confirmed : {identity, other}) {
    if (!state_.class_tally.confirm(name, confirmed)) continue;
    FarmEvent& event = state_.record(FarmEvent::Kind::kClassConfirmed, "");
    event.host = confirmed;
    event.text = name;
  }
}

bool Classes::is_forsaken(const FarmJob& job) const {
  const std::string& bound = job.classes.bound();
  if (job.request.any_class || !wire::is_whole_class(bound)) return false;
  if (state_.class_tally.offers(bound, job.request.required_tags)) return false;
  return !state_.class_tally
              .best({.isa = job.request.isa,
                     .tags = job.request.required_tags,
                     .max_workers = job.request.max_workers})
              .empty();
}

void Classes::unbind(FarmJob& job) {
  job.classes.bind("");
  job.class_tally_revision = 0;
  job.settling_since.reset();
  state_.record(FarmEvent::Kind::kBound, job.request.id);
}

bool Classes::has_class(const std::string& name) const {
  return std::any_of(state_.workers.begin(), state_.workers.end(), [&](const auto& entry) {
    const std::vector<std::string>& classes = entry.second.info.classes;
    return entry.second.is_tallied && std::find(classes.begin(), classes.end(), name) != classes.end();
  });
}

/// The class in which the job is rendered; before its first unit is given out, the one that it would be bound
/// to now, and none where there is no worker for it. Not of jobs that are for every class.
const std::string& Classes::class_of(const FarmJob& job) const {
  const std::string& bound = job.classes.bound();
  // A journal from before classes knows the ISA alone: any class of it will do.
  if (wire::is_whole_class(bound)) return bound;
  if (job.class_tally_revision != state_.class_tally.revision()) {
    job.class_tally_revision = state_.class_tally.revision();
    job.best_class =
        state_.class_tally.best({.isa = bound.empty() ? std::string_view(job.request.isa) : bound,
                                 .tags = job.request.required_tags,
                                 .max_workers = job.request.max_workers});
  }
  return job.best_class;
}

const std::string* Classes::class_for(const FarmWorker& worker, const FarmJob& job) const {
  const std::string_view wanted = job.request.any_class ? std::string_view() : class_of(job);
  const std::string& bound = job.classes.bound();
  const std::string_view isa = bound.empty() ? std::string_view(job.request.isa) : wire::isa_of(bound);
  const std::vector<std::string>& classes = worker.info.classes;
  const auto found = std::find_if(classes.begin(), classes.end(), [&](const std::string& name) {
    return wanted.empty() ? isa.empty() || wire::isa_of(name) == isa : name == wanted;
  });
  return found == classes.end() ? nullptr : &*found;
}

const std::string& Classes::class_of_result(const FarmJob& job, const AcceptedResult& result) const {
  return job.classes.of(
      result.host < state_.hosts_by_number.size() ? state_.hosts_by_number[result.host] : "",
      result.sequence);
}

bool Classes::settling(const FarmJob& job, Time now) const {
  if (job.request.any_class || !job.classes.bound().empty() || now >= state_.settled_at) return false;
  // Whoever comes as another machine again and again keeps no job from beginning.
  if (!job.settling_since) job.settling_since = now;
  return now - *job.settling_since < kMostSettles * state_.options.settle;
}

void Classes::bind(FarmJob& job, const std::string& name) {
  const std::string before = job.classes.bound();
  if (job.request.any_class || before == name) return;
  // Results from before classes were told of stay what they are: of some class of that ISA.
  std::vector<AcceptedResult> unclear;
  if (!before.empty()) unclear = job.units.results();
  std::erase_if(unclear,
                [&](const AcceptedResult& result) { return class_of_result(job, result) != before; });
  job.classes.bind(name);
  state_.record(FarmEvent::Kind::kBound, job.request.id).text = name;
  for (const AcceptedResult& result : unclear)
    note(job, state_.hosts_by_number[result.host], result.sequence, before);
}

void Classes::note(FarmJob& job, const std::string& host, std::uint32_t sequence, const std::string& name) {
  if (!job.classes.note(host, sequence, name)) return;
  FarmEvent& event = state_.record(FarmEvent::Kind::kClassNoted, job.request.id);
  event.host = host;
  event.value = sequence;
  event.text = name;
}

std::string Classes::left_out(const FarmJob& job) const {
  if (!job.open()) return "";
  const std::string bound = job.request.any_class ? "" : job.classes.bound();
  const bool by_class = wire::is_whole_class(bound);
  const std::string_view isa = bound.empty() ? std::string_view(job.request.isa) : wire::isa_of(bound);
  const auto groups =
      state_.class_tally.without(by_class ? bound : "", {.isa = isa, .tags = job.request.required_tags});
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

std::vector<std::string> Classes::closed_jobs(const FarmWorker& worker) const {
  std::vector<std::string> closed;
  for (const auto& [number, job] : state_.jobs_by_number) {
    if (closed.size() == kMaxClosedJobs) break;
    if (job->open() && has_tags(worker.info, job->request.required_tags) &&
        class_for(worker, *job) == nullptr) {
      closed.push_back(job->request.id);
    }
  }
  return closed;
}

}  // namespace tessera::server
