// Loads a coordinator with thousands of workers that render nothing, and prints what it did and what it took:
//
//   farm_load --workers 10000 --jobs 100 --units 2000
//
// Run by hand (docs/decisions/0015-load.md); tests/load/load_test.cpp asserts what must hold on any machine.
#include <algorithm>
#include <cstdio>
#include <thread>

#include "options/program.h"
#include "soak/load/farm_under_load.h"
#include "soak/load/wait_for.h"
#include "wire/version.h"

namespace {

using namespace tessera::load;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

double seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }
double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / (1 << 20); }
double ms(LatencyHistogram::Duration duration) { return static_cast<double>(duration.count()) / 1e3; }

void print(const char* what, const LatencyHistogram& times) {
  std::printf("%-10s %9llu calls   p50 %8.2f ms   p99 %8.2f ms   p99.9 %8.2f ms\n", what,
              static_cast<unsigned long long>(times.count()), ms(times.quantile(0.5)),
              ms(times.quantile(0.99)), ms(times.quantile(0.999)));
}

void print(const ProcessUse& use, const char* when) {
  std::printf("coordinator %s: %.0f MiB resident, %.0f MiB at most\n", when, mebibytes(use.resident_bytes),
              mebibytes(use.peak_resident_bytes));
}

/// Until all jobs are done, or time is up; prints what was measured until the first of them was.
int measure(FarmUnderLoad& farm, const Progress& progress, StubFleet& fleet, Clock::duration warm_up,
            Clock::duration patience) {
  std::this_thread::sleep_for(warm_up);
  fleet.clear_latencies();
  const ProcessUse before = farm.use();
  const std::uint64_t done_before = progress.done();
  const std::uint64_t heartbeats_before = fleet.tally().heartbeats, leased_before = fleet.tally().leased;
  const auto begin = Clock::now();
  wait_for([&] { return progress.one_is_done(); }, patience);
  const double took = seconds(Clock::now() - begin);
  const ProcessUse after = farm.use();
  const auto done = static_cast<double>(progress.done() - done_before);
  const double cpu_us = static_cast<double>((after.cpu - before.cpu).count()) * 1e3;

  std::printf("%.0f durable completions in %.1f s: %.0f a second, with %.0f heartbeats a second\n", done,
              took, done / took, static_cast<double>(fleet.tally().heartbeats - heartbeats_before) / took);
  std::printf("coordinator: %.0f us of CPU a completion, %.2f cores\n", cpu_us / done, cpu_us / 1e6 / took);
  std::printf("%llu units leased; \"lease\" are those that a worker with nothing to do waited for\n",
              static_cast<unsigned long long>(fleet.tally().leased - leased_before));
  print("lease", fleet.tally().lease);
  print("complete", fleet.tally().complete);
  print("heartbeat", fleet.tally().heartbeat);
  print(after, "under load");
  const std::vector<std::uint64_t> shares = progress.shares();
  const auto [least, most] = std::minmax_element(shares.begin(), shares.end());
  std::printf("shares of %zu jobs: %llu to %llu units\n", shares.size(),
              static_cast<unsigned long long>(*least), static_cast<unsigned long long>(*most));

  const bool ended = wait_for([&] { return progress.all_done(); }, patience);
  std::printf("%s: %llu of %llu units, %.1f s; %llu refused, %llu revoked, %llu calls tried again\n",
              ended ? "all done" : "time is up", static_cast<unsigned long long>(progress.done()),
              static_cast<unsigned long long>(progress.wanted()), seconds(Clock::now() - begin),
              static_cast<unsigned long long>(fleet.tally().refused),
              static_cast<unsigned long long>(fleet.tally().revoked),
              static_cast<unsigned long long>(fleet.tally().retries));
  return ended ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  FleetOptions fleet_options{.workers = 1000};
  JobsOptions jobs{.jobs = 100, .users = 5, .scenes = 100, .units = 1000};
  std::string server = TESSERA_SERVER_PROGRAM;
  std::uint32_t unit_ms = 0, warm_up_s = 0, patience_s = 120;
  bool restart = false;
  tessera::options::Program program{"farm_load", "Loads a coordinator with workers that render nothing.",
                                    tessera::wire::build_version()};
  tessera::options::Command command = program.root();
  command.add("--server", server, "the coordinator's program").type_name("FILE").with_default();
  command.add("--workers", fleet_options.workers).with_default();
  command.add("--workers-per-connection", fleet_options.workers_per_connection).with_default();
  command.add("--threads", fleet_options.threads_per_worker, "of each worker").with_default();
  command.add("--unit-ms", unit_ms, "what a unit takes on a thread, on average").with_default();
  command.add("--jobs", jobs.jobs).with_default();
  command.add("--users", jobs.users).with_default();
  command.add("--scenes", jobs.scenes).with_default();
  command.add("--units", jobs.units, "of each job").with_default();
  command.add("--tile", jobs.tile_size, "pixels").with_default();
  command.add("--warm-up", warm_up_s, "seconds of work before anything is measured: all workers come at once")
      .with_default();
  command.add("--patience", patience_s, "seconds after which it gives up").with_default();
  command.add_flag("--restart", restart, "at the end, kill the coordinator and start it again");
  if (const auto ended = program.parse(argc, argv)) return *ended;
  fleet_options.unit_time = milliseconds(unit_ms);
  const std::chrono::seconds patience(patience_s);

  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  FarmUnderLoad farm(server, {"--log-level", "warning"});
  std::printf("coordinator at %s, process %d\n", farm.address().c_str(), static_cast<int>(farm.process_id()));
  Progress progress;
  const auto submitting = Clock::now();
  if (const auto ids = farm.submit(jobs, progress); !ids.ok()) {
    std::fprintf(stderr, "%s\n", ids.status().ToString().c_str());
    return 1;
  }
  std::printf("%zu jobs of %llu units submitted in %.2f s\n", jobs.jobs,
              static_cast<unsigned long long>(progress.wanted() / jobs.jobs),
              seconds(Clock::now() - submitting));
  print(farm.use(), "with the jobs");
  int result;
  {
    StubFleet fleet(farm.address(), fleet_options,
                    [&](const std::string& job, std::uint32_t unit) { progress.completed(job, unit); });
    const auto registering = Clock::now();
    fleet.start();
    wait_for([&] { return fleet.registered() == fleet_options.workers; }, patience);
    std::printf("%zu workers registered in %.2f s\n", fleet.registered(),
                seconds(Clock::now() - registering));
    result = measure(farm, progress, fleet, std::chrono::seconds(warm_up_s), patience);
  }
  print(farm.use(), "at the end");
  if (!restart) return result;
  std::printf("ready %.2f s after kill -9\n", seconds(farm.kill_and_restart()));
  print(farm.use(), "after the restart");
  return result;
}
