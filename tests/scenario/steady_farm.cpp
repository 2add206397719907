#include "scenario/steady_farm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "scenario/scenario_runner.h"

namespace tessera::server {
namespace {

constexpr std::chrono::milliseconds kPoll{250};  // a parked call of Lease is looked at again
constexpr std::uint32_t kQueuedPerThread = 2;    // the same as in the agent
constexpr std::uint64_t kRaysPerMs = 1000;
constexpr std::size_t kScenesHeld = 2;

}  // namespace

SteadyFarm::SteadyFarm(SteadyFarmOptions options)
    : options_(std::move(options)),
      scheduler_(options_.scheduler),
      workers_(options_.machines.size()),
      done_(options_.jobs.size()),
      results_(options_.jobs.size()),
      waits_(options_.jobs.size()),
      finished_(options_.jobs.size()),
      first_lease_(options_.jobs.size()),
      random_(options_.seed) {
  std::normal_distribution<double> normal;
  const double innovation = std::sqrt(1 - options_.correlation * options_.correlation);
  for (std::size_t job = 0; job < options_.jobs.size(); ++job) {
    const SteadyFarmOptions::Work& work = options_.jobs[job];
    std::vector<double>&costs = costs_.emplace_back(work.units), &rays = rays_.emplace_back(work.units);
    const std::uint32_t tiles = work.units / work.ranges;
    double along = normal(random_);
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      costs[tile] = work.median_ms * std::exp(options_.spread * along);
      rays[tile] = kRaysPerMs * costs[tile] * std::exp(options_.ray_spread.value_or(0) * normal(random_));
      along = options_.correlation * along + innovation * normal(random_);
    }
    for (std::uint32_t unit = tiles; unit < work.units; ++unit) {
      costs[unit] = costs[unit - tiles];
      rays[unit] = rays[unit - tiles];
    }
    plans_.push_back(row_of_tiles(tiles, work.ranges));
    happen(work.submitted, {.kind = Kind::kSubmit, .which = job});
  }
  for (std::size_t machine = 0; machine < workers_.size(); ++machine) {
    // One after another, as they are started.
    happen(options_.machines[machine].joins + std::chrono::milliseconds(machine),
           {.kind = Kind::kJoin, .which = machine});
  }
}

void SteadyFarm::run(const std::function<bool()>& enough) {
  while (!is_done() && !enough()) {
    if (events_.empty()) {
      ADD_FAILURE() << "nobody does anything any more";
      return;
    }
    const Event event = events_.top();
    events_.pop();
    count_idle(event.at);
    now_ = event.at;
    step(event);
    scheduler_.take_events();
  }
}

bool SteadyFarm::is_done() const {
  for (std::size_t job = 0; job < done_.size(); ++job) {
    if (done_[job] < options_.jobs[job].units) return false;
  }
  return true;
}

void SteadyFarm::happen(Instant after, Event event) {
  event.at = now_ + after;
  event.order = ++order_;
  events_.push(std::move(event));
}

void SteadyFarm::count_idle(Instant until) {
  const auto passed = static_cast<double>((until - now_).count());
  for (std::size_t machine = 0; machine < workers_.size(); ++machine) {
    if (!workers_[machine].joined) continue;
    const double idle = passed * (options_.machines[machine].threads - workers_[machine].running);
    thread_time_ += passed * options_.machines[machine].threads;
    idle_ += idle;
    if (waiting_ > 0) idle_in_vain_ += idle;
  }
}

double SteadyFarm::slowness_now(std::size_t machine) const {
  const SteadyFarmOptions::Machine& made = options_.machines[machine];
  return now_ < made.changes ? made.slowness : made.then;
}

double SteadyFarm::slowness(std::size_t machine) const {
  for (const WorkerView& view : scheduler_.workers()) {
    if (view.info.id == absl::StrCat(machine)) return view.slowness;
  }
  return 0;
}

void SteadyFarm::step(const Event& event) {
  const auto answer = [&] { return Instant(random_() % (2 * Instant(options_.answer).count() + 1)); };
  switch (event.kind) {
    case Kind::kSubmit:
      return submit(event.which);
    case Kind::kJoin: {
      const std::string id = absl::StrCat(event.which);
      EXPECT_TRUE(scheduler_
                      .register_worker({.id = id,
                                        .name = id,
                                        .build = "",
                                        .isa = "avx2",
                                        .supported_isas = {"avx2"},
                                        .threads = options_.machines[event.which].threads,
                                        .host = id,
                                        .tags = {}},
                                       now())
                      .ok());
      workers_[event.which].joined = true;
      return ask(event.which);
    }
    case Kind::kAsk:
      workers_[event.which].asks_again = false;
      return ask(event.which);
    case Kind::kRendered: {
      --workers_[event.which].running;
      begin(event.which);
      Event answered = event;
      answered.kind = Kind::kAnswered;
      return happen(answer(), std::move(answered));
    }
    case Kind::kAnswered: {
      const std::size_t job = std::stoul(event.token.job_id());
      const UnitRun units = units_of(event.token);
      const auto rays = static_cast<std::uint64_t>(units.count * rays_[job][units.first]);
      const auto decision =
          scheduler_.complete(absl::StrCat(event.which), event.token,
                              {.fingerprint = 1,
                               .cost = event.cost,
                               .work = options_.ray_spread ? std::max<std::uint64_t>(1, rays) : 0},
                              now());
      EXPECT_TRUE(decision.ok()) << decision.status().ToString();
      if (decision.ok() && !decision->duplicate) {
        ++results_[job];
        done_[job] += units.count;
        if (done_[job] == options_.jobs[job].units) finished_[job] = now_;
      }
      return ask(event.which);
    }
  }
}

UnitRun SteadyFarm::units_of(const v1::LeaseToken& token) const {
  return *plans_[std::stoul(token.job_id())]->run(token.unit_index(), std::max(token.ranges(), 1u));
}

void SteadyFarm::submit(std::size_t job) {
  const SteadyFarmOptions::Work& work = options_.jobs[job];
  EXPECT_TRUE(scheduler_
                  .add_job({.id = absl::StrCat(job),
                            .plan = plans_[job],
                            .scene_digest = work.scene,
                            .isa = "avx2",
                            .user = work.user,
                            .required_tags = {}})
                  .ok());
  waits_[job].assign(work.units, true);
  waiting_ += work.units;
  // Calls that wait for work are tried at once.
  for (std::size_t machine = 0; machine < workers_.size(); ++machine) {
    if (workers_[machine].joined) ask(machine);
  }
}

/// For what the threads are at, and as much again as lies in the queue.
void SteadyFarm::ask(std::size_t machine) {
  Worker& worker = workers_[machine];
  const std::uint32_t threads = options_.machines[machine].threads;
  const std::size_t full = kQueuedPerThread * threads;
  if (worker.queue.size() > full / 2) return;
  const auto decision = scheduler_.lease({.worker = absl::StrCat(machine),
                                          .max_units = static_cast<std::uint32_t>(full - worker.queue.size()),
                                          .loaded_scenes = worker.scenes},
                                         now());
  ASSERT_TRUE(decision.ok());
  for (const v1::Lease& lease : decision->leases) {
    worker.queue.push_back(lease.token());
    const std::size_t job = std::stoul(lease.token().job_id());
    const UnitRun units = units_of(lease.token());
    for (const std::uint32_t unit : units) {
      if (waits_[job][unit]) --waiting_;
      waits_[job][unit] = false;
    }
    if (results_[job] >= 8) {
      longest_lease_ =
          std::max(longest_lease_, Instant(std::llround(1000 * units.count * costs_[job][units.first])));
    }
    if (!first_lease_[job]) first_lease_[job] = now() - options_.jobs[job].submitted;
    const std::string& scene = options_.jobs[job].scene;
    if (std::find(worker.scenes.begin(), worker.scenes.end(), scene) != worker.scenes.end()) continue;
    worker.scenes.push_back(scene);
    if (worker.scenes.size() > kScenesHeld) worker.scenes.erase(worker.scenes.begin());
  }
  begin(machine);
  if (worker.running == threads || worker.asks_again) return;
  worker.asks_again = true;
  happen(kPoll, {.kind = Kind::kAsk, .which = machine});
}

void SteadyFarm::begin(std::size_t machine) {
  Worker& worker = workers_[machine];
  while (worker.running < options_.machines[machine].threads && !worker.queue.empty()) {
    const v1::LeaseToken token = worker.queue.front();
    worker.queue.pop_front();
    ++worker.running;
    const UnitRun units = units_of(token);
    const double milliseconds =
        units.count * costs_[std::stoul(token.job_id())][units.first] * slowness_now(machine);
    const Instant cost(std::max<std::int64_t>(1, std::llround(1000 * milliseconds)));
    happen(cost, {.kind = Kind::kRendered, .which = machine, .token = token, .cost = cost});
  }
}

}  // namespace tessera::server
