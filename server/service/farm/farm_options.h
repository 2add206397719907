// Settings of a farm.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "scheduler/turn_order.h"
#include "service/farm/quotas.h"
#include "service/farm/retention.h"
#include "service/identifier.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

class EndListener;
class FarmObserver;
class LeaseSeal;

struct FarmOptions {
  std::chrono::milliseconds heartbeat_interval;
  std::chrono::milliseconds lease_timeout;
  std::chrono::milliseconds late_results;  // time after a job's end for which its units are kept in memory
  Retention retention;
  std::uint64_t max_open_units = std::uint64_t{1} << 27;  // units of all jobs in memory together
  Quotas quotas = {};
  std::chrono::milliseconds longest_run{10'000};  // SchedulerOptions::longest_run
  JobOrder order = JobOrder::kFirstCome;
  bool share_results = false;             // jobs take over those of other users' jobs too
  std::shared_ptr<const LeaseSeal> seal;  // seal of this data directory
  std::filesystem::path lived_time = {};  // the file of LivedTime; empty: none
  // Defaults of jobs that do not say: JobSpec.bits and JobSpec.isa.
  v1::Bits bits = v1::BITS_SAME;
  std::string isa = {};
  std::chrono::milliseconds settle{0};  // SchedulerOptions::settle
  // The same of SchedulerOptions.
  double unconfirmed_share = 0.05;
  std::vector<std::string> classes = {};
  std::chrono::milliseconds class_patience{600'000};
  EndListener* listener = nullptr;              // outlives the farm; null: nobody is told
  base::Clock* clock = &base::machine_clock();  // outlives the farm
  // Makes names of jobs and registrations, of so many digits.
  std::function<std::string(int digits)> make_identifier = random_identifier;
  std::vector<FarmObserver*> observers = {};  // told what happens; they outlive the farm
};

}  // namespace tessera::server
