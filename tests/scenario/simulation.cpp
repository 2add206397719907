// The world's clock, network and coordinator. Workers are in simulated_workers.cpp, clients in
// simulated_clients.cpp.
#include "scenario/simulation.h"

#include <algorithm>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

constexpr Time kChaos{40'000};
constexpr Time kLongest{4 * 3600'000};
constexpr Time kTick{1000};

/// Two makers' processors, an old one and a new one of the first, and what they have in common is the old
/// one's class.
const std::vector<std::vector<std::string>> kMachines = {
    {"avx512/e3/a5", "avx2/e3/a2"}, {"avx2/e3/a2"}, {"avx512/e3/b5", "avx2/e3/b2"}};

/// Whether no other event of the job is equal, so that its being there tells of the commit that it was in. Of
/// a dispute, too, is to be known: it lets the scheduler ask a third host.
bool happens_once(const SchedulerEvent& event) {
  const auto kind = static_cast<FarmEvent::Kind>(event.kind);
  return kind == FarmEvent::Kind::kRevoked || kind == FarmEvent::Kind::kAudit;
}

}  // namespace

Simulation::Simulation(const SimulationOptions& options) : options_(options), random_(options.seed) {
  const auto sometimes = [&](double probability) { return pick(2) == 0 ? 0.0 : probability; };
  drop_ = sometimes(0.1), twice_ = sometimes(0.1), fail_ = sometimes(0.05);
  worker_death_ = sometimes(0.03), coordinator_death_ = sometimes(0.1);
  longest_delay_ = Time(1 + pick(pick(4) == 0 ? 12'000 : 300));
  audits_ = pick(4) == 0, settle_ = Time(pick(2) * 1000);
  liars_ = pick(4) == 0, poison_ = pick(4) == 0, full_disk_ = pick(4) == 0;
  if (pick(4) == 0) job_order_ = JobOrder::kFair;
  runs_ = pick(2) == 0;
  phases_ = pick(2) == 0;
  if (options.real_journal) disk_ = std::make_unique<SimulatedDisk>(options.seed);

  workers_.resize(options.workers > 0 ? options.workers : 4 + pick(7));
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Worker& worker = workers_[i];
    worker.host = absl::StrCat("h", i);
    worker.classes = kMachines[pick(kMachines.size())];
    worker.threads = 1 + static_cast<std::uint32_t>(pick(4));
    worker.slowness = pick(6) == 0 ? 10 : 1;
    // Fewer than half, or truth would be outvoted.
    worker.liar = liars_ && i < (workers_.size() - 1) / 3;
  }
  usual_pace_is_common_ = is_usual_pace_common();
}

Simulation::~Simulation() {
  coordinator_.reset();
  real_.reset();  // before its disk
}

std::string Simulation::run() {
  start_coordinator();
  const std::size_t jobs = options_.workers > 0 ? 3 : 1 + pick(2);
  for (std::size_t i = 0; i < jobs; ++i) submit_job();
  for (std::size_t i = 0; i < workers_.size(); ++i) start_worker(i);
  at(kTick, [this] { beat_coordinator(); });
  at(Time(pick(5000)), [this] { meddle(); });

  bool retried = false;
  while (violation_.empty() && now_ < kLongest) {
    const auto next = events_by_time_.begin();
    now_ = next->first.first;
    const Step step = std::move(next->second);
    events_by_time_.erase(next);
    step();
    ++counts_.steps;
    check();
    if (chaos_ && now_ > kChaos) {
      chaos_ = false;
      if (disk_) disk_->set_capacity(std::uint64_t{1} << 40);
    }
    if (chaos_ || !all_ended()) continue;
    if (retried) break;
    if (!coordinator_) continue;  // it is about to start again
    // Units that were set aside are tried again, on a farm where nothing is wrong any more.
    retried = true;
    poison_ = false;
    for (auto& [id, promise] : promises_) {
      if (promise.ended == v1::INCOMPLETE) coordinator_->retry(id, [](const absl::Status&) {});
    }
    commit();
  }
  if (violation_.empty() && !all_ended()) violate("a job does not end");
  for (const auto& [id, promise] : promises_) {
    if (violation_.empty() && promise.ended == v1::INCOMPLETE)
      violate(absl::StrCat(id, " is incomplete after a retry"));
  }
  return violation_;
}

void Simulation::at(Time time, Step step) {
  events_by_time_.emplace(std::pair{now_ + time, ++order_}, std::move(step));
}

void Simulation::violate(const std::string& what) {
  if (violation_.empty())
    violation_ = absl::StrCat("after ", counts_.steps, " steps, at ", now_.count(), " ms: ", what);
}

// ---------------------------------------------------------------- the network

void Simulation::to_coordinator(Step message) {
  if (chaos_ && chance(drop_)) return;
  const int copies = chaos_ && chance(twice_) ? 2 : 1;
  for (int i = 0; i < copies; ++i) {
    at(Time(pick(chaos_ ? static_cast<std::uint64_t>(longest_delay_.count()) : 5)), [this, message] {
      if (coordinator_) message();
    });
  }
}

void Simulation::to_worker(std::size_t worker, Step message) {
  if (chaos_ && chance(drop_)) return;
  const std::uint64_t life = workers_[worker].life;
  at(Time(pick(chaos_ ? static_cast<std::uint64_t>(longest_delay_.count()) : 5)),
     [this, worker, life, message] {
       if (workers_[worker].alive && workers_[worker].life == life) message();
     });
}

// ---------------------------------------------------------------- the coordinator

void Simulation::start_coordinator() {
  Journal* journal = &model_;
  if (options_.real_journal) {
    auto opened = open_journal("/data", {}, *disk_);
    if (absl::IsResourceExhausted(opened.status())) {
      // The power failed on a disk that was full. It says so and ends; somebody makes room and starts it
      // again.
      ++counts_.disk_full;
      disk_->set_capacity(std::uint64_t{1} << 40);
      return at(Time(pick(5000)), [this] { start_coordinator(); });
    }
    if (!opened.ok()) return violate(opened.status().ToString());
    real_ = *std::move(opened);
    journal = real_.get();
  } else {
    model_.begin_epoch();
  }
  std::map<std::string, JobRecord> records;
  const absl::Status read = journal->recover([&](JobRecord record) {
    records.emplace(record.added.id, std::move(record));
    return absl::OkStatus();
  });
  if (!read.ok()) return violate(read.ToString());
  resolve_doubt(records);
  check_recovery(records);
  coordinator_ =
      std::make_unique<SimulatedCoordinator>(*journal, jobs_,
                                             SchedulerOptions{.short_run = runs_ ? Time{10'000} : Time{100},
                                                              .audit_one_in = liars_ || audits_ ? 3u : 0u,
                                                              .order = job_order_,
                                                              .settle = settle_});
  if (!coordinator_->recovery().ok()) violate(coordinator_->recovery().ToString());
  ++incarnation_;
  committing_ = false;
}

void Simulation::kill_coordinator() {
  ++counts_.coordinator_deaths;
  coordinator_.reset();
  if (disk_) {
    real_.reset();
    disk_->restore_power();
  }
  at(Time(pick(chaos_ ? 5000 : 10)), [this] { start_coordinator(); });
}

void Simulation::beat_coordinator() {
  at(kTick, [this] { beat_coordinator(); });
  if (!coordinator_) return;
  coordinator_->advance(now_);
  if (chaos_ && chance(coordinator_death_)) kill_coordinator();
}

/// After every step: what it left to be journaled is journaled a little later, with what comes until then.
void Simulation::check() {
  if (!coordinator_ || !violation_.empty()) return;
  Scheduler& scheduler = coordinator_->scheduler();
  if (coordinator_->waits_for_commit() && !committing_) {
    committing_ = true;
    at(Time(pick(20)), [this, life = incarnation_] {
      if (coordinator_ && life == incarnation_) commit();
    });
  }
  // Bookkeeping is checked against itself now and then, for it takes a look at everything.
  if (counts_.steps % (options_.workers > 0 ? 4096 : 16) != 0) return;
  check_paces();
  std::size_t leases = 0;
  for (const WorkerView& worker : scheduler.workers()) {
    leases += worker.leases;
    if (worker.leases > wire::kMaxLeasesPerWorker) violate("a worker holds more than any may");
  }
  if (leases != scheduler.leases_out()) violate("the leases of workers do not add up");
  for (const auto& [id, promise] : promises_) {
    const absl::StatusOr<JobView> view = scheduler.job(id);
    if (!view.ok()) continue;
    if (view->units_done + view->units_leased + view->units_set_aside > view->units_total) {
      violate(absl::StrCat(id, ": more units than there are"));
    }
    const bool over = view->state != v1::QUEUED && view->state != v1::RUNNING;
    if (over && view->units_leased > 0) violate(absl::StrCat(id, " is over and has leases"));
  }
}

void Simulation::commit() {
  committing_ = false;
  const bool dies_before = chaos_ && chance(coordinator_death_ / 4),
             dies_after = chaos_ && chance(coordinator_death_ / 4);
  if (dies_before) return kill_coordinator();
  if (disk_ && chaos_ && chance(coordinator_death_ / 2)) disk_->fail_power_after(1 + pick(12));
  if (disk_ && chaos_ && full_disk_ && chance(0.01)) disk_->set_capacity(1);
  const absl::Status status = coordinator_->commit();
  if (status.ok()) {
    learn_group(coordinator_->committed());
    if (dies_after) return kill_coordinator();
    return coordinator_->answer();
  }
  // A coordinator that cannot write acknowledges nothing, and ends.
  if (disk_ && disk_->powered()) {
    ++counts_.disk_full;
    disk_->set_capacity(std::uint64_t{1} << 40);
  } else if (disk_) {
    ++counts_.power_failures;
  } else {
    return violate(status.ToString());
  }
  in_doubt_ = coordinator_->committed();
  kill_coordinator();
}

// ---------------------------------------------------------------- what has been promised

void Simulation::learn(const UnitDone& done) {
  Promise& promise = promises_.at(done.job);
  if (done.sequence != promise.journaled.size() + 1)
    violate(absl::StrCat(done.job, ": result ", done.sequence, " out of order"));
  for (const std::uint32_t unit : units_of(done.job, done.units)) {
    if (!promise.live.emplace(unit, promise.journaled.size()).second) {
      violate(absl::StrCat(done.job, "/", unit, " is merged twice"));
    }
  }
  counts_.runs += done.units.ranges > 1;
  if (promise.ended == v1::CANCELLED) violate(absl::StrCat(done.job, ": merged after it was cancelled"));
  if (promise.ended != v1::JOB_STATE_UNSPECIFIED) violate(absl::StrCat(done.job, ": merged after its end"));
  if (!done.from_job.empty()) {
    const Promise& donor = promises_.at(done.from_job);
    if (donor.content != promise.content || done.from_sequence == 0 ||
        done.from_sequence > donor.journaled.size() ||
        donor.journaled[done.from_sequence - 1].units != done.units ||
        donor.journaled[done.from_sequence - 1].digest != done.digest) {
      violate(absl::StrCat(done.job, "/", done.units.first, " is taken over from where there is nothing"));
    }
    ++counts_.adopted;
  }
  const std::optional<std::uint64_t> inputs = inputs_of(promise, done.units.first);
  if (!inputs) violate(absl::StrCat(done.job, "/", done.units.first, " is made of what is not there"));
  check_class(promise, done, inputs.value_or(0));
  promise.journaled.push_back(
      {.units = done.units, .digest = done.digest, .host = done.host, .inputs = inputs.value_or(0)});
  counts_.made += !promise.request.plan->is_of_picture(done.units.first);
  ++counts_.results;
}

/// Hash of the unit's inputs, as it is journaled: LeaseToken.inputs. None where one of them does not count.
std::optional<std::uint64_t> Simulation::inputs_of(const Promise& promise, std::uint32_t unit) const {
  std::vector<ResultFingerprint> inputs;
  for (const std::uint32_t input : promise.request.plan->phases().inputs(unit)) {
    const auto live = promise.live.find(input);
    if (live == promise.live.end()) return std::nullopt;
    inputs.push_back(std::stoull(promise.journaled[live->second].digest.substr(0, 16), nullptr, 16));
  }
  return inputs_key(inputs);
}

/// Checks that results which count were made of results which count.
void Simulation::check_inputs() {
  for (const auto& [id, promise] : promises_) {
    if (promise.phase_parts.empty()) continue;
    for (const auto& [unit, index] : promise.live) {
      if (inputs_of(promise, unit) != promise.journaled[index].inputs)
        return violate(absl::StrCat(id, "/", unit, " was made of results that count no more"));
    }
  }
}

/// All honest results of a job that is to have the same bits everywhere are of one class.
void Simulation::check_class(Promise& promise, const UnitDone& done, std::uint64_t inputs) {
  if (promise.request.any_class) return;
  for (const std::vector<std::string>& machine : kMachines) {
    for (const std::string& name : machine) {
      if (digest_of(truth_of(promise, done.units, name, inputs)) != done.digest) continue;
      if (promise.arithmetic_class.empty()) promise.arithmetic_class = name;
      if (promise.arithmetic_class != name)
        violate(absl::StrCat(done.job, " is of ", promise.arithmetic_class, " and ", name));
      return;
    }
  }
}

void Simulation::learn(const std::vector<JournalEntry>& entries) {
  for (const JournalEntry& entry : entries) {
    if (const auto* added = std::get_if<JobAdded>(&entry)) {
      promises_.at(added->id).journaled_job = true;
      promises_.at(added->id).arrived = ++arrivals_;
    }
    if (const auto* done = std::get_if<UnitDone>(&entry)) learn(*done);
    if (const auto* reopened = std::get_if<JobReopened>(&entry)) {
      promises_.at(reopened->id).ended = v1::JOB_STATE_UNSPECIFIED;
    }
    if (const auto* ended = std::get_if<JobEnded>(&entry)) {
      Promise& promise = promises_.at(ended->id);
      promise.ended = static_cast<v1::JobState>(ended->state);
      const bool whole = promise.live.size() == promise.request.plan->unit_count();
      if (promise.ended == v1::DONE && !whole)
        violate(absl::StrCat(ended->id, " is done without all of its units"));
      if (promise.ended == v1::INCOMPLETE && whole)
        violate(absl::StrCat(ended->id, " is whole and called incomplete"));
    }
    const auto* event = std::get_if<SchedulerEvent>(&entry);
    if (event == nullptr) continue;
    const auto kind = static_cast<FarmEvent::Kind>(event->kind);
    if (kind == FarmEvent::Kind::kDistrusted) {
      ++counts_.quarantines;
      const auto host = std::find_if(workers_.begin(), workers_.end(),
                                     [&](const Worker& worker) { return worker.host == event->host; });
      if (!host->liar) violate(absl::StrCat("honest ", event->host, " is in quarantine: ", event->text));
    }
    if (kind == FarmEvent::Kind::kUnitFailed || kind == FarmEvent::Kind::kUnitLost)
      promises_.at(event->job).failed = true;
    if (kind == FarmEvent::Kind::kAudit) {
      Promise::Result& result =
          promises_.at(event->job).journaled.at(static_cast<std::size_t>(event->value) - 1);
      result.disputed |= !event->text.empty();
      if (event->text.empty() && ++result.audits > 1)
        violate(absl::StrCat(event->job, "/", event->unit, " is audited twice"));
      counts_.audits += event->text.empty();
    }
    if (kind != FarmEvent::Kind::kRevoked) continue;
    ++counts_.revoked;
    Promise& promise = promises_.at(event->job);
    Promise::Result& result = promise.journaled.at(static_cast<std::size_t>(event->value) - 1);
    if (result.units.first != event->unit || result.revoked)
      violate("a result is revoked that does not count");
    result.revoked = true;
    for (const std::uint32_t unit : units_of(event->job, result.units)) promise.live.erase(unit);
    // A job without results may be bound to another class.
    if (promise.live.empty()) promise.arithmetic_class.clear();
  }
}

void Simulation::learn_group(const std::vector<JournalEntry>& entries) {
  for (const JournalEntry& entry : entries) trace_.add(entry);
  learn(entries);
  check_inputs();
}

void Simulation::resolve_doubt(const std::map<std::string, JobRecord>& records) {
  std::size_t there = 0, decidable = 0;
  for (const JournalEntry& entry : in_doubt_) {
    if (const auto* added = std::get_if<JobAdded>(&entry)) {
      ++decidable, there += records.contains(added->id);
    } else if (const auto* done = std::get_if<UnitDone>(&entry)) {
      const auto found = records.find(done->job);
      ++decidable, there += found != records.end() && found->second.results.size() >= done->sequence;
    } else if (const auto* ended = std::get_if<JobEnded>(&entry)) {
      const auto found = records.find(ended->id);
      ++decidable, there += found != records.end() && found->second.ended.state == ended->state;
    } else if (const auto* event = std::get_if<SchedulerEvent>(&entry);
               event != nullptr && happens_once(*event)) {
      const auto found = records.find(event->job);
      const auto same = [&](const SchedulerEvent& other) {
        return std::tie(other.kind, other.unit, other.value, other.host, other.text) ==
               std::tie(event->kind, event->unit, event->value, event->host, event->text);
      };
      ++decidable, there += found != records.end() && std::ranges::any_of(found->second.events, same);
    }
  }
  if (there != 0 && there != decidable) violate("half a commit survived");
  // Without any of these nothing was promised by it: what it told of is read from the journal, or happens
  // again.
  if (there > 0) learn_group(in_doubt_);
  in_doubt_.clear();
}

void Simulation::check_recovery(const std::map<std::string, JobRecord>& records) {
  for (const auto& [id, promise] : promises_) {
    const auto found = records.find(id);
    if (found == records.end()) {
      if (promise.journaled_job) violate(absl::StrCat("job ", id, " is lost"));
      continue;
    }
    const std::vector<JobRecord::Result>& results = found->second.results;
    if (results.size() != promise.journaled.size()) {
      return violate(absl::StrCat(id, ": ", promise.journaled.size(), " results were journaled, ",
                                  results.size(), " are there"));
    }
    for (std::size_t i = 0; i < results.size(); ++i) {
      const Promise::Result& expected = promise.journaled[i];
      if (results[i].units != expected.units || results[i].digest != expected.digest ||
          results[i].host != expected.host) {
        return violate(absl::StrCat(id, ": result ", i + 1, " is not what was journaled"));
      }
    }
  }
}

}  // namespace tessera::server
