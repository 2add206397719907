#include "scenario/scenario_runner.h"

#include <sstream>
#include <stdexcept>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "scenario/simulated_coordinator.h"
#include "service/job/journal_events.h"
#include "support/phased_job.h"
#include "wire/arithmetic_class.h"

namespace tessera::server {
namespace {

constexpr std::uint32_t kTile = 8;
constexpr std::uint32_t kSamplesPerUnit = 4;

std::string outcome(const absl::Status& status) { return status.ok() ? "ok\n" : status.ToString() + "\n"; }

}  // namespace

std::shared_ptr<const WorkPlan> row_of_tiles(std::uint32_t tiles, std::uint32_t ranges,
                                             const std::vector<std::uint32_t>& parts) {
  v1::JobSpec spec;
  spec.mutable_view()->set_width(tiles * kTile);
  spec.mutable_view()->set_height(kTile);
  spec.mutable_cut()->mutable_crop()->set_x1(spec.view().width());
  spec.mutable_cut()->mutable_crop()->set_y1(spec.view().height());
  spec.mutable_cut()->set_tile_size(kTile);
  spec.mutable_cut()->set_samples_per_unit(kSamplesPerUnit);
  spec.mutable_samples()->set_spp(ranges * kSamplesPerUnit);
  spec.mutable_content()->set_scene(std::string(64, 'a'));
  spec.mutable_farm()->add_blobs()->set_digest(spec.content().scene());
  if (!parts.empty()) test::add_test_phases(spec, parts);
  return std::make_shared<const WorkPlan>(WorkPlan::make(spec).value());
}

ScenarioRunner::ScenarioRunner() {
  journal_.begin_epoch();
  options_ = {.audit_one_in = 0, .epoch = journal_.epoch()};
  scheduler_ = std::make_unique<Scheduler>(options_);
}

std::string ScenarioRunner::journal(std::vector<JournalEntry> entries) {
  std::string news;
  for (const FarmEvent& event : scheduler_->take_events()) {
    switch (event.kind) {
      case FarmEvent::Kind::kBound:
        absl::StrAppend(&news, "(", event.job, " is bound to ", event.text, ")\n");
        break;
      case FarmEvent::Kind::kEnded:
        absl::StrAppend(&news, "(", event.job, " is ",
                        v1::JobState_Name(static_cast<v1::JobState>(event.value)), ")\n");
        break;
      case FarmEvent::Kind::kRevoked:
        absl::StrAppend(&news, "(result ", event.value, " of ", event.job, " is revoked)\n");
        break;
      case FarmEvent::Kind::kDistrusted:
        absl::StrAppend(&news, "(", event.host, " is in quarantine: ", event.text, ")\n");
        break;
      default:
        break;
    }
    append_to_journal(event, 0, entries);
  }
  const absl::Status status = journal_.commit(entries);
  return status.ok() ? news : outcome(status);
}

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
    journal({});
    return cancelled.ok() ? (*cancelled ? "cancelled\n" : "was over\n") : outcome(cancelled.status());
  }
  if (command == "audit") {
    options_.audit_one_in = static_cast<std::uint32_t>(std::stoul(first));
    scheduler_ = std::make_unique<Scheduler>(options_);
    return "ok\n";
  }
  if (command == "settle") {
    options_.settle = Time(static_cast<std::int64_t>(std::stod(first) * 1000));
    scheduler_ = std::make_unique<Scheduler>(options_);
    return "ok\n";
  }
  if (command == "order") {
    options_.order = first == "fair" ? JobOrder::kFair : JobOrder::kFirstCome;
    scheduler_ = std::make_unique<Scheduler>(options_);
    return "ok\n";
  }
  if (command == "trust") return changed(scheduler_->trust_host(first));
  if (command == "retry") return changed(scheduler_->retry_job(first));
  if (command == "pause" || command == "resume")
    return changed(scheduler_->pause_job(first, command == "pause"));
  if (command == "priority") {
    return changed(scheduler_->set_priority(first, std::stoi(arguments.positional.at(1))));
  }
  throw std::invalid_argument("no such command: " + line);
}

std::string ScenarioRunner::changed(const absl::Status& status) { return outcome(status) + journal({}); }

std::string ScenarioRunner::submit(const Arguments& arguments) {
  const auto number = [&](const char* name, const char* otherwise) {
    return std::stoi(arguments.get(name, otherwise));
  };
  const std::string& id = arguments.positional.at(0);
  JobRequest request{.id = id,
                     .plan = row_of_tiles(number("tiles", "1"), number("ranges", "1")),
                     .scene_digest = arguments.get("scene", id),
                     .isa = arguments.get("isa", ""),
                     .priority = number("priority", "0"),
                     .user = arguments.get("user", ""),
                     .required_tags = absl::StrSplit(arguments.get("require", ""), ',', absl::SkipEmpty()),
                     .max_workers = static_cast<std::uint32_t>(number("workers", "0")),
                     .any_class = arguments.get("bits", "same") == "any"};
  const absl::Status status = scheduler_->add_job(request);
  if (!status.ok()) return outcome(status);
  jobs_[id] = std::move(request);
  return outcome(status) + journal({JobAdded{.id = id, .request_id = id, .spec = id}});
}

std::string ScenarioRunner::show_job(const std::string& id) const {
  const auto view = scheduler_->job(id);
  if (!view.ok()) return outcome(view.status());
  std::string out =
      absl::StrCat(v1::JobState_Name(view->state), " ", view->units_done, "/", view->units_total, " done, ",
                   view->units_leased, " leased", view->isa.empty() ? "" : ", " + view->isa,
                   view->paused ? ", paused" : "", view->error.empty() ? "" : ": " + view->error, "\n");
  for (const SetAsideView& aside : view->set_aside) {
    absl::StrAppend(&out, "  set aside: ", aside.unit, ", failed on ",
                    absl::StrJoin(aside.failures, " ",
                                  [](std::string* text, const UnitFailure& failure) {
                                    absl::StrAppend(text, failure.host, failure.lost ? " (lost)" : "");
                                  }),
                    "\n");
  }
  for (const std::string& note : view->notes) absl::StrAppend(&out, "  note: ", note, "\n");
  if (const std::string others = scheduler_->left_out(id); !others.empty()) {
    absl::StrAppend(&out, "  left out: ", others, "\n");
  }
  if (const std::string reason = scheduler_->waiting_for(id, now_); !reason.empty() && view->units_done > 0) {
    absl::StrAppend(&out, "  waiting: ", reason, "\n");
  }
  return out;
}

std::string ScenarioRunner::register_worker(const Arguments& arguments) {
  const std::vector<std::string> classes =
      absl::StrSplit(arguments.get("classes", ""), ',', absl::SkipEmpty());
  std::vector<std::string> isas;
  for (const std::string& name : classes) isas.emplace_back(wire::isa_of(name));
  if (isas.empty()) isas.push_back(arguments.get("isa", "avx2"));
  if (const std::string also = arguments.get("also", ""); !also.empty()) isas.push_back(also);
  const std::string& id = arguments.positional.at(0);
  return outcome(scheduler_->register_worker(
      {.id = id,
       .name = id,
       .build = "",
       .isa = isas.front(),
       .supported_isas = isas,
       .threads = static_cast<std::uint32_t>(std::stoi(arguments.get("threads", "2"))),
       .host = arguments.get("host", id),
       .tags = absl::StrSplit(arguments.get("tags", ""), ',', absl::SkipEmpty()),
       .classes = classes},
      now_));
}

std::string ScenarioRunner::show_workers() const {
  std::string out;
  for (const WorkerView& worker : scheduler_->workers()) {
    absl::StrAppend(&out, worker.info.id, ": ", worker.leases, " leases, ", worker.units_done, " done, seen ",
                    (now_ - worker.last_seen).count() / 1000.0, "s ago", worker.draining ? ", draining" : "",
                    worker.quarantine.empty() ? "" : ", in quarantine", "\n");
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
  if (out.empty()) return "nothing\n";
  std::string news = journal({});
  if (!news.empty())
    return absl::StrCat(out, absl::StrReplaceAll(news, {{"\n", " "}}).substr(0, news.size() - 1), "\n");
  out.back() = '\n';
  return out;
}

std::string ScenarioRunner::heartbeat(const Arguments& arguments) {
  std::vector<v1::LeaseToken> tokens;
  for (std::size_t i = 1; i < arguments.positional.size(); ++i)
    tokens.push_back(token(arguments.positional[i]));
  const auto decision = scheduler_->heartbeat(arguments.positional.at(0), tokens, now_);
  if (!decision.ok()) return outcome(decision.status());
  std::string out;
  for (const v1::LeaseToken& revoked : decision->revoked)
    absl::StrAppend(&out, "revoked ", text(revoked), "\n");
  if (decision->drain) out += "drain\n";
  return out.empty() ? "ok\n" : out;
}

std::string ScenarioRunner::complete(const Arguments& arguments) {
  const v1::LeaseToken lease = token(arguments.positional.at(1));
  const ResultFingerprint result = std::stoull(arguments.get("result", "7"));
  const Time took(static_cast<std::int64_t>(std::stod(arguments.get("took", "0")) * 1000));
  const std::string& worker = arguments.positional[0];
  const auto decision = scheduler_->complete(worker, lease, {.fingerprint = result, .cost = took}, now_);
  if (!decision.ok()) return outcome(decision.status()) + journal({});
  if (decision->duplicate) return "duplicate\n" + journal({});
  return absl::StrCat("result ", decision->sequence, "\n",
                      journal({UnitDone{.job = lease.job_id(),
                                        .sequence = decision->sequence,
                                        .units = covered_by(lease),
                                        .digest = digest_of(result),
                                        .payload = "",
                                        .stats = "",
                                        .host = scheduler_->host_of(worker)}}));
}

std::string ScenarioRunner::fail(const Arguments& arguments) {
  const Words& words = arguments.positional;
  const bool scene_fault = words.size() > 2 && words[2] == "scene";
  return changed(scheduler_->fail(words.at(0), token(words.at(1)),
                                  {.message = "no luck", .scene_fault = scene_fault}, now_));
}

std::string ScenarioRunner::advance(const std::string& seconds) {
  now_ += Time(static_cast<std::int64_t>(std::stod(seconds) * 1000));
  const Expiry expiry = scheduler_->advance(now_);
  std::string out;
  for (const WorkerInfo& worker : expiry.lost_workers) absl::StrAppend(&out, "lost worker ", worker.id, "\n");
  if (expiry.lost_leases > 0) absl::StrAppend(&out, "lost ", expiry.lost_leases, " leases\n");
  absl::StrAppend(&out, journal({}));
  return out.empty() ? "ok\n" : out;
}

std::string ScenarioRunner::restart() {
  journal_.begin_epoch();
  options_.epoch = journal_.epoch();
  scheduler_ = std::make_unique<Scheduler>(options_);
  absl::Status status = restore_farm(*scheduler_, journal_);
  status.Update(journal_.recover([&](const JobRecord& record) {
    absl::Status restored = restore_job(*scheduler_, jobs_.at(record.added.id), record);
    if (record.ended.state == v1::CANCELLED) static_cast<void>(scheduler_->cancel_job(record.added.id));
    return restored;
  }));
  static_cast<void>(scheduler_->take_events());
  return outcome(status);
}

v1::LeaseToken ScenarioRunner::token(const std::string& text) const {
  const std::size_t slash = text.find('/'), hash = text.find('#'), at = text.find('@');
  if (slash == std::string::npos || hash == std::string::npos)
    throw std::invalid_argument("no lease: " + text);
  v1::LeaseToken token;
  token.set_job_id(text.substr(0, slash));
  token.set_generation(1);
  const std::string unit = text.substr(slash + 1, hash - slash - 1);
  token.set_unit_index(static_cast<std::uint32_t>(std::stoul(unit)));
  if (const std::size_t run = unit.find('x'); run != std::string::npos) {
    token.set_ranges(static_cast<std::uint32_t>(std::stoul(unit.substr(run + 1))));
  }
  token.set_attempt(static_cast<std::uint32_t>(std::stoul(text.substr(hash + 1))));
  token.set_epoch(at == std::string::npos ? options_.epoch : std::stoull(text.substr(at + 1)));
  return token;
}

std::string ScenarioRunner::text(const v1::LeaseToken& token) const {
  const std::string epoch = token.epoch() == options_.epoch ? "" : absl::StrCat("@", token.epoch());
  const std::string run = token.ranges() > 1 ? absl::StrCat("x", token.ranges()) : "";
  return absl::StrCat(token.job_id(), "/", token.unit_index(), run, "#", token.attempt(), epoch);
}

}  // namespace tessera::server
