#include "service/farm/farm_log.h"

#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "scheduler/identity.h"
#include "scheduler/scheduler_types.h"
#include "service/farm/worker_registry.h"
#include "service/job/job_table.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

using spdlog::level::level_enum;
using telemetry::log;

std::string_view user_of(const JobEntry& job) { return job.shape->spec.farm().user(); }

telemetry::LogFields fields_of(const JobEntry& job) { return {.job = job.id, .user = user_of(job)}; }

/// A line about what a worker did with a unit.
void log_lease(level_enum level, const std::string& worker, const v1::LeaseToken& token,
               const std::string& text) {
  const std::string run = token.ranges() > 1 ? absl::StrCat("x", token.ranges()) : "";
  log(level,
      {.job = token.job_id(), .unit = token.unit_index(), .attempt = token.attempt(), .worker = worker},
      "worker {}, unit {}{} of job {}: {}", worker, token.unit_index(), run, token.job_id(), text);
}

/// Writes the line of each kind of news; other kinds have none.
struct LineWriter {
  template <class Other>
  void operator()(const Other&) const {}

  void operator()(const news::JournalFailed& news) const {
    spdlog::critical("the journal cannot be written, so nothing more is acknowledged: {}",
                     news.why.ToString());
  }
  void operator()(const news::HostDistrusted& news) const {
    log(level_enum::err, {.host = news.host}, "host {} is in quarantine: {}", short_name(news.host),
        news.why);
  }

  void operator()(const news::JobSubmitted& news) const {
    const v1::JobSpec& spec = news.job.shape->spec;
    log(level_enum::info, fields_of(news.job), "job {} \"{}\": {} x {} pixels, {} samples, {} units",
        news.job.id, spec.farm().name(), spec.view().width(), spec.view().height(), spec.samples().spp(),
        news.job.shape->plan->unit_count());
  }
  void operator()(const news::ResultsAdopted& news) const {
    log(level_enum::info, fields_of(news.job), "job {}: {} units are taken over from job {}", news.job.id,
        news.job.units, news.donor);
  }
  void operator()(const news::JobRecovered& news) const {
    log(level_enum::info, fields_of(news.job), "job {} goes on with {} of {} units done", news.job.id,
        news.units_done, news.job.shape->plan->unit_count());
  }
  void operator()(const news::ResultsLost& news) const {
    if (news.job.past) {
      log(level_enum::err, fields_of(news.job), "job {}: its result file is missing or too short; {}",
          news.job.id,
          news.job.past->state == v1::DONE ? "what is lost is rendered again when somebody fetches it"
                                           : "what is lost cannot be fetched");
      return;
    }
    log(level_enum::err, fields_of(news.job),
        "job {}: {} results are lost, for their file is too short; their units are done again", news.job.id,
        news.results);
  }
  void operator()(const news::JobEnded& news) const {
    log(level_enum::info, fields_of(news.job), "job {} {}{}{}", news.job.id, v1::JobState_Name(news.state),
        news.error.empty() ? "" : ": ", news.error);
  }
  void operator()(const news::JobNoted& news) const {
    log(level_enum::warn, fields_of(news.job), "job {}: {}", news.job.id, news.text);
  }
  void operator()(const news::ResultsDoubted& news) const {
    log(level_enum::err, {.job = news.job.id, .host = news.subject, .user = user_of(news.job)},
        "job {} is over, and {} of its units are of host {}", news.job.id, news.units,
        short_name(news.subject));
  }
  void operator()(const news::JobDeleted& news) const {
    if (news.on_request) {
      log(level_enum::info, fields_of(news.job), "job {} is deleted on request", news.job.id);
    } else {
      log(level_enum::info, {.job = news.job.id}, "job {} is deleted: its time is over", news.job.id);
    }
  }

  void operator()(const news::RegistrationRefused& news) const {
    const std::string name = news.request.name().substr(0, WorkerRegistry::kMaxNameBytes);
    log(level_enum::warn, {.worker = name, .peer = news.peer}, "worker {} refused: {}", name,
        std::string(news.why.message()));
  }
  void operator()(const news::WorkerRegistered& news) const {
    log(level_enum::info, {.worker = news.request.name(), .host = news.host, .peer = news.peer},
        "worker {} ({}, {} threads) registered as {}", news.request.name(),
        absl::StrJoin(news.request.arithmetic_classes(), " "), news.request.threads(), news.id);
  }
  void operator()(const news::WorkerLeft& news) const {
    log(level_enum::info, {.worker = news.name}, "worker {} ({}) left", news.name, news.id);
  }
  void operator()(const news::WorkerExpelled& news) const {
    const WorkerInfo& info = news.worker.info;
    log(level_enum::warn,
        {.worker = info.name, .host = info.host, .user = info.certificate, .peer = info.peer},
        "worker {} ({}) is expelled; its {} leases go to others", info.name, info.id, news.worker.leases);
  }
  void operator()(const news::WorkerLost& news) const {
    log(level_enum::warn, {.worker = news.worker.name, .host = news.worker.host}, "worker {} ({}) was lost",
        news.worker.name, news.worker.id);
  }
  void operator()(const news::LeasesLost& news) const {
    spdlog::warn("{} leases expired; their units go to other workers", news.leases);
  }
  void operator()(const news::WorkerListCut& news) const {
    spdlog::warn("the list of workers is cut: {} of them fill a message", news.workers);
  }

  void operator()(const news::ResultAccepted& news) const {
    if (spdlog::should_log(level_enum::debug))
      log_lease(level_enum::debug, news.worker, news.token, "result accepted");
  }
  void operator()(const news::ResultRefused& news) const {
    using Reason = news::ResultRefused::Reason;
    if (news.reason == Reason::kNotWanted) return;
    const bool is_fault = news.reason == Reason::kMisrendered || news.reason == Reason::kContradicted;
    log_lease(is_fault ? level_enum::err : level_enum::warn, news.worker, news.token,
              std::string(news.why.message()));
  }
  void operator()(const news::UnitFailed& news) const {
    log_lease(level_enum::warn, news.worker, news.token, absl::StrCat("failed: ", news.message));
  }
};

}  // namespace

void FarmLog::note(const FarmNews& news) { std::visit(LineWriter{}, news); }

}  // namespace tessera::server
