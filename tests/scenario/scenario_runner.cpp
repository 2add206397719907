#include "scenario/scenario_runner.h"

#include <sstream>
#include <stdexcept>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace tessera::server {
namespace {

constexpr std::uint32_t kTile = 8;
constexpr std::uint32_t kSamplesPerUnit = 4;

std::string outcome(const absl::Status& status) { return status.ok() ? "ok\n" : status.ToString() + "\n"; }

}  // namespace

std::shared_ptr<const WorkPlan> row_of_tiles(std::uint32_t tiles, std::uint32_t ranges) {
  v1::JobSpec spec;
  spec.set_width(tiles * kTile);
  spec.set_height(kTile);
  spec.mutable_crop()->set_x1(spec.width());
  spec.mutable_crop()->set_y1(spec.height());
  spec.set_tile_size(kTile);
  spec.set_samples_per_unit(kSamplesPerUnit);
  spec.mutable_settings()->set_spp(ranges * kSamplesPerUnit);
  spec.mutable_scene()->set_digest(std::string(64, 'a'));
  return std::make_shared<const WorkPlan>(WorkPlan::make(spec).value());
}

ScenarioRunner::ScenarioRunner() : scheduler_(std::make_unique<Scheduler>(SchedulerOptions{})) {}

std::string ScenarioRunner::Arguments::get(const std::string& name, const std::string& otherwise) const {
  const auto found = named.find(name);
  return found == named.end() ? otherwise : found->second;
}

std::string ScenarioRunner::run(const std::string& line) {
  std::istringstream words(line);
  std::string command, word;
  words >> command;
  Arguments arguments;
  while (words >> word) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) {
      arguments.positional.push_back(word);
    } else {
      arguments.named[word.substr(0, equals)] = word.substr(equals + 1);
    }
  }
  const std::string first = arguments.positional.empty() ? "" : arguments.positional[0];
  if (command == "submit") return submit(arguments);
  if (command == "job") return show_job(first);
  if (command == "register") return register_worker(arguments);
  if (command == "deregister") return outcome(scheduler_->deregister_worker(first));
  if (command == "drain") return outcome(scheduler_->drain_worker(first));
  if (command == "workers") return show_workers();
  if (command == "lease") return lease(arguments);
  if (command == "heartbeat") return heartbeat(arguments);
  if (command == "complete") return complete(arguments);
  if (command == "fail") return fail(arguments);
  if (command == "advance") return advance(first);
  if (command == "restart") return restart();
  if (command == "cancel") {
    const auto cancelled = scheduler_->cancel_job(first);
    return cancelled.ok() ? (*cancelled ? "cancelled\n" : "was over\n") : outcome(cancelled.status());
  }
  throw std::invalid_argument("no such command: " + line);
}

std::string ScenarioRunner::submit(const Arguments& arguments) {
  const auto number = [&](const char* name, const char* otherwise) {
    return std::stoi(arguments.get(name, otherwise));
  };
  const std::string& id = arguments.positional.at(0);
  JobRequest request{.id = id,
                     .plan = row_of_tiles(number("tiles", "1"), number("ranges", "1")),
                     .scene_digest = arguments.get("scene", id),
                     .isa = arguments.get("isa", ""),
                     .priority = number("priority", "0")};
  const absl::Status status = scheduler_->add_job(request);
  if (status.ok()) journal_.push_back({.request = std::move(request), .done = {}});
  return outcome(status);
}

std::string ScenarioRunner::show_job(const std::string& id) const {
  const auto view = scheduler_->job(id);
  if (!view.ok()) return outcome(view.status());
  return absl::StrCat(v1::JobState_Name(view->state), " ", view->units_done, "/", view->units_total, " done, ",
                      view->units_leased, " leased", view->isa.empty() ? "" : ", " + view->isa,
                      view->error.empty() ? "" : ": " + view->error, "\n");
}

std::string ScenarioRunner::register_worker(const Arguments& arguments) {
  const std::string isa = arguments.get("isa", "avx2");
  std::vector<std::string> isas = {isa};
  if (const std::string also = arguments.get("also", ""); !also.empty()) isas.push_back(also);
  const std::string& id = arguments.positional.at(0);
  return outcome(
      scheduler_->register_worker({.id = id,
                                   .name = id,
                                   .build = "",
                                   .isa = isa,
                                   .supported_isas = isas,
                                   .threads = static_cast<std::uint32_t>(std::stoi(arguments.get("threads", "2")))},
                                  now_));
}

std::string ScenarioRunner::show_workers() const {
  std::string out;
  for (const WorkerView& worker : scheduler_->workers()) {
    absl::StrAppend(&out, worker.info.id, ": ", worker.leases, " leases, ", worker.units_done, " done, seen ",
                    (now_ - worker.last_seen).count() / 1000.0, "s ago", worker.draining ? ", draining" : "", "\n");
  }
  return out.empty() ? "none\n" : out;
}

std::string ScenarioRunner::lease(const Arguments& arguments) {
  const std::string scenes = arguments.get("scenes", "");
  const auto decision =
      scheduler_->lease({.worker = arguments.positional.at(0),
                         .max_units = static_cast<std::uint32_t>(std::stoi(arguments.positional.at(1))),
                         .loaded_scenes = absl::StrSplit(scenes, ',', absl::SkipEmpty())},
                        now_);
  if (!decision.ok()) return outcome(decision.status());
  std::string out;
  for (const v1::Lease& lease : decision->leases) absl::StrAppend(&out, text(lease.token()), " ");
  for (const std::string& id : decision->bound_jobs) {
    const std::string isa = scheduler_->job(id)->isa;
    absl::StrAppend(&out, "(", id, " is bound to ", isa, ") ");
    for (Record& record : journal_) {
      if (record.request.id == id) record.request.isa = isa;
    }
  }
  if (out.empty()) return "nothing\n";
  out.back() = '\n';
  return out;
}

std::string ScenarioRunner::heartbeat(const Arguments& arguments) {
  std::vector<v1::LeaseToken> tokens;
  for (std::size_t i = 1; i < arguments.positional.size(); ++i) tokens.push_back(token(arguments.positional[i]));
  const auto decision = scheduler_->heartbeat(arguments.positional.at(0), tokens, now_);
  if (!decision.ok()) return outcome(decision.status());
  std::string out;
  for (const v1::LeaseToken& revoked : decision->revoked) absl::StrAppend(&out, "revoked ", text(revoked), "\n");
  if (decision->drain) out += "drain\n";
  return out.empty() ? "ok\n" : out;
}

std::string ScenarioRunner::complete(const Arguments& arguments) {
  const v1::LeaseToken lease = token(arguments.positional.at(1));
  const ResultFingerprint result = std::stoull(arguments.get("result", "7"));
  const auto decision = scheduler_->complete(arguments.positional[0], lease, result, now_);
  if (!decision.ok()) return outcome(decision.status());
  if (decision->duplicate) return "duplicate\n";
  for (Record& record : journal_) {
    if (record.request.id == lease.job_id()) record.done.emplace_back(lease.unit_index(), result);
  }
  return absl::StrCat("result ", decision->sequence, decision->job_done ? ", the last\n" : "\n");
}

std::string ScenarioRunner::fail(const Arguments& arguments) {
  const Words& words = arguments.positional;
  const bool scene_fault = words.size() > 2 && words[2] == "scene";
  const auto decision = scheduler_->fail(words.at(0), token(words.at(1)), "no luck", scene_fault, now_);
  if (!decision.ok()) return outcome(decision.status());
  return decision->job_failed ? "the job failed\n" : "ok\n";
}

std::string ScenarioRunner::advance(const std::string& seconds) {
  now_ += Time(static_cast<std::int64_t>(std::stod(seconds) * 1000));
  const Expiry expiry = scheduler_->advance(now_);
  std::string out;
  for (const WorkerInfo& worker : expiry.lost_workers) absl::StrAppend(&out, "lost worker ", worker.id, "\n");
  if (expiry.lost_leases > 0) absl::StrAppend(&out, "lost ", expiry.lost_leases, " leases\n");
  return out.empty() ? "ok\n" : out;
}

std::string ScenarioRunner::restart() {
  scheduler_ = std::make_unique<Scheduler>(SchedulerOptions{.epoch = ++epoch_});
  absl::Status status;
  for (const Record& record : journal_) {
    status.Update(scheduler_->add_job(record.request));
    for (const auto& [unit, result] : record.done)
      status.Update(scheduler_->restore_done(record.request.id, unit, result));
  }
  return outcome(status);
}

v1::LeaseToken ScenarioRunner::token(const std::string& text) const {
  const std::size_t slash = text.find('/'), hash = text.find('#'), at = text.find('@');
  if (slash == std::string::npos || hash == std::string::npos) throw std::invalid_argument("no lease: " + text);
  v1::LeaseToken token;
  token.set_job_id(text.substr(0, slash));
  token.set_generation(1);
  token.set_unit_index(static_cast<std::uint32_t>(std::stoul(text.substr(slash + 1, hash - slash - 1))));
  token.set_attempt(static_cast<std::uint32_t>(std::stoul(text.substr(hash + 1))));
  token.set_epoch(at == std::string::npos ? epoch_ : std::stoull(text.substr(at + 1)));
  return token;
}

std::string ScenarioRunner::text(const v1::LeaseToken& token) const {
  const std::string epoch = token.epoch() == epoch_ ? "" : absl::StrCat("@", token.epoch());
  return absl::StrCat(token.job_id(), "/", token.unit_index(), "#", token.attempt(), epoch);
}

}  // namespace tessera::server
