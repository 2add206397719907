#include "command/report/job_table.h"

#include <google/protobuf/util/json_util.h>

#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "base/printable.h"
#include "command/jobs/job_news.h"
#include "command/report/choice_text.h"
#include "command/report/progress.h"
#include "command/report/table.h"
#include "command/report/time_spent.h"
#include "farm/farm_client.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"
#include "wire/scene_views.h"

namespace tessera::client {

namespace {

/// "view 3, pixels 0,0 to 32,32, samples 0 to 16"; of view 0 without its name.
std::string place_of(const v1::WorkUnit& unit) {
  const v1::SampleRange& samples = unit.has_tile() ? unit.tile().samples() : unit.pass().passes();
  std::string place = absl::StrCat("samples ", samples.begin(), " to ", samples.end());
  const std::uint32_t number = wire::view_of(unit);
  const std::string view = number == 0 ? "" : absl::StrCat("view ", number, ", ");
  if (!unit.has_tile()) return view + place;
  const v1::PixelRect& pixels = unit.tile().pixels();
  return absl::StrCat(view, "pixels ", pixels.x0(), ",", pixels.y0(), " to ", pixels.x1(), ",", pixels.y1(),
                      ", ", place);
}

std::string noise_text(double noise) {
  return noise == 0 ? "" : absl::StrCat(" at most, to a noise of ", noise);
}

// From this multiple of the usual time on, a worker is called slow.
constexpr double kSlow = 2;

/// Remarks on a worker that is out of the ordinary.
std::vector<std::string> remarks_on(const v1::WorkerStatus& worker) {
  std::vector<std::string> remarks;
  if (worker.slowness() >= kSlow) {
    remarks.push_back(absl::StrFormat("slow: %.1f times the usual time", worker.slowness()));
  }
  // Whose certificate it has, where that is not its host's.
  const std::string& name = worker.certificate();
  const std::string host = worker.host().substr(0, worker.host().find('@'));
  if (!name.empty() && name != host && name != worker.host())
    remarks.push_back(absl::StrCat("certificate of ", name));
  if (!worker.arithmetic().closed_jobs().empty()) {
    remarks.push_back(absl::StrCat("its arithmetic keeps it from jobs ",
                                   absl::StrJoin(worker.arithmetic().closed_jobs(), " ")));
  }
  if (!worker.quarantine().empty()) {
    remarks.push_back(absl::StrCat("host ", worker.host(), " is in quarantine: ", worker.quarantine()));
  }
  return remarks;
}

std::string state_of(const v1::WorkerStatus& worker) {
  if (!worker.quarantine().empty()) return "quarantine";
  if (worker.draining()) return "draining";
  return worker.leases() > 0 ? "working" : "idle";
}

/// The class in which it works where it may choose: "avx512/embree-3.13.5/1f3a9c0e".
std::string arithmetic_of(const v1::WorkerStatus& worker) {
  return worker.arithmetic().classes().empty() ? worker.isa() : worker.arithmetic().classes(0);
}

/// "4f0c2a11 kitchen (3), 91be07aa (1)".
std::string jobs_of(const v1::WorkerStatus& worker) {
  std::vector<std::string> jobs;
  for (const v1::WorkerJob& job : worker.jobs()) {
    const std::string name = job.job_id().empty() ? "of others" : absl::StrCat(job.job_id(), " ", job.name());
    jobs.push_back(absl::StrCat(name, " (", job.leases(), ")"));
  }
  return absl::StrJoin(jobs, ", ");
}

std::string time_text(std::int64_t milliseconds) {
  return format_duration(1e-3 * static_cast<double>(milliseconds));
}

/// Rounded down, so that 100 % means done.
std::string percent_text(const v1::JobStatus& job) {
  return absl::StrCat(job.units_total() == 0 ? 0 : std::uint64_t{100} * job.units_done() / job.units_total(),
                      " %");
}

std::string trouble_of(const v1::JobStatus& job) {
  if (job.units_set_aside() > 0) return absl::StrCat(job.units_set_aside(), " set aside");
  return job.failures() > 0 ? absl::StrCat(job.failures(), " failed") : "";
}

}  // namespace

std::string short_state(const v1::JobStatus& status) {
  return status.paused() && !has_ended(status.state()) ? "paused" : wire::word_of(status.state());
}

std::string state_text(const v1::JobStatus& status) {
  std::string text = wire::word_of(status.state());
  if (status.paused()) text += ", paused";
  if (status.units_set_aside() > 0)
    absl::StrAppend(&text, ", ", status.units_set_aside(), " units set aside");
  return text;
}

std::string jobs_table(const std::vector<v1::JobStatus>& jobs, std::size_t width) {
  if (jobs.empty()) return "there are no jobs\n";
  Table table{{{"ID"},
               {"STATE"},
               {"DONE", /*right=*/true},
               {"ELAPSED", true},
               {"LEFT", true},
               {"WORKERS", true},
               {"PRIORITY", true},
               {"TROUBLE"},
               {"USER", false, /*shrinks=*/true},
               {"NAME", false, true},
               {"AFTER"},
               {"COMMENT", false, true}}};
  for (const v1::JobStatus& job : jobs) {
    table.add({job.job_id(), short_state(job), percent_text(job), time_text(job.elapsed_ms()),
               job.left_ms() > 0 ? time_text(job.left_ms()) : "",
               job.workers() > 0 ? absl::StrCat(job.workers()) : "",
               job.priority() != 0 ? absl::StrCat(job.priority()) : "", trouble_of(job), job.user(),
               job.name(), absl::StrJoin(job.after(), ","), job.comment()});
  }
  return table.text(width);
}

std::string workers_table(const std::vector<v1::WorkerStatus>& workers, std::size_t width) {
  if (workers.empty()) return "there are no workers\n";
  Table table{{{"NAME"},
               {"STATE"},
               {"THREADS", /*right=*/true},
               {"UNITS", true},
               {"DONE", true},
               {"SEEN", true},
               {"ARITHMETIC"},
               {"TAGS", false, /*shrinks=*/true},
               {"WORKS ON", false, true}}};
  std::string below;
  for (const v1::WorkerStatus& worker : workers) {
    table.add({worker.name(), state_of(worker), absl::StrCat(worker.threads()), absl::StrCat(worker.leases()),
               absl::StrCat(worker.units_done()),
               absl::StrFormat("%.1f s", 1e-3 * static_cast<double>(worker.last_seen_ms_ago())),
               arithmetic_of(worker), absl::StrJoin(worker.tags(), ","), jobs_of(worker)});
    for (const std::string& remark : remarks_on(worker)) {
      absl::StrAppend(&below, base::printable(worker.name()), ": ", base::printable(remark), "\n");
    }
  }
  return table.text(width) + below;
}

namespace {

/// Lines with a label each.
class Lines {
 public:
  void add(const char* label, const std::string& text) {
    absl::StrAppend(&text_, absl::StrFormat("%-12s", label), base::printable(text), "\n");
  }
  void add_if_any(const char* label, const std::string& text) {
    if (!text.empty()) add(label, text);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

void add_progress(const v1::GetJobResponse& job, Lines& lines) {
  const v1::JobStatus& status = job.status();
  lines.add("done", absl::StrCat(percent_text(status), ", ", status.units_done(), " of ",
                                 status.units_total(), " units, ", status.units_leased(), " at work"));
  lines.add(
      has_ended(status.state()) ? "took" : "since",
      absl::StrCat(time_text(status.elapsed_ms()),
                   status.left_ms() > 0 ? absl::StrCat(", ", time_text(status.left_ms()), " left") : ""));
  lines.add_if_any("phase", status.phase());
  for (const v1::JobWorker& worker : job.workers()) {
    lines.add("worker", absl::StrCat(worker.name(), ", ", worker.leases(), " units"));
  }
  lines.add_if_any("requires", absl::StrJoin(job.spec().farm().required_tags(), ","));
  if (job.spec().farm().max_workers() > 0)
    lines.add("at most", absl::StrCat(job.spec().farm().max_workers(), " workers"));
  if (status.audits() > 0) {
    lines.add("audited", absl::StrCat(status.audits(), " units given to a second host too",
                                      status.audits_out() > 0
                                          ? absl::StrCat(", which is at ", status.audits_out(), " now")
                                          : ""));
  }
  if (status.units_unconfirmed() > 0) {
    lines.add("unconfirmed", absl::StrCat(status.units_unconfirmed(),
                                          " units rest on one certificate each, for no worker with "
                                          "another one could look at them"));
  }
  if (status.units_adopted() > 0) {
    lines.add("taken over", absl::StrCat(status.units_adopted(), " units of job ", status.adopted_from()));
  }
}

/// The worker's last lines before a failure. Those of a unit that was set aside are listed twice, and have
/// theirs once.
void add_log(const v1::UnitFailure& failure, std::set<std::string>& told, Lines& lines) {
  if (!told.insert(absl::StrJoin(failure.log(), "\n")).second) return;
  for (const std::string& line : failure.log()) lines.add("", absl::StrCat("  | ", line));
}

void add_trouble(const v1::GetJobResponse& job, Lines& lines) {
  const v1::JobStatus& status = job.status();
  std::set<std::string> told;
  lines.add_if_any("error", status.error());
  lines.add_if_any("waits", status.waiting_for());
  lines.add_if_any("left out", status.left_out());
  for (const v1::SlowHost& slow : job.slow_hosts()) {
    lines.add("slow", absl::StrFormat("host %s: %.1f times the usual time (%u units)", slow.host(),
                                      slow.slowness(), slow.units()));
  }
  for (const v1::SetAsideUnit& aside : status.set_aside()) {
    lines.add("set aside", absl::StrCat("unit ", aside.unit().index(), ", ", place_of(aside.unit())));
    for (const v1::UnitFailure& failure : aside.failures()) {
      lines.add("", absl::StrCat("on ", failure.host(), ": ", failure.message()));
      add_log(failure, told, lines);
    }
  }
  if (status.failures() > 0)
    lines.add("failures", absl::StrCat(status.failures(), ", of which the latest are"));
  for (const v1::FailedUnit& failed : status.latest_failures()) {
    const v1::UnitFailure& failure = failed.failure();
    lines.add("", absl::StrCat(name_of(failed), " on ", failure.host(), ": ", failure.message()));
    add_log(failure, told, lines);
  }
}

}  // namespace

std::string job_text(const v1::GetJobResponse& job) {
  const v1::JobStatus& status = job.status();
  const v1::JobSpec& spec = job.spec();
  Lines lines;
  lines.add("id", status.job_id());
  lines.add("name", status.name());
  lines.add_if_any("comment", status.comment());
  lines.add("state", state_text(status));
  lines.add_if_any("after", absl::StrJoin(spec.farm().after(), ", "));
  lines.add("user", absl::StrCat(status.user(), ", priority ", status.priority()));
  add_progress(job, lines);
  lines.add("film", absl::StrCat(spec.view().width(), "x", spec.view().height(), ", ", spec.samples().spp(),
                                 " samples a pixel", noise_text(spec.samples().noise())));
  const std::string& integrator = spec.content().algorithms().integrator();
  lines.add("integrator", absl::StrCat(integrator, " (", wire::kind_of(spec.content().algorithms()),
                                       "), depth ", spec.view().max_depth(), ", seed ", spec.view().seed()));
  if (const v1::AutoChoice& choice = spec.farm().auto_choice(); spec.farm().has_auto_choice()) {
    lines.add("chosen", choice_text(spec));
    for (const v1::AutoChoice::Candidate& candidate : choice.candidates())
      lines.add("", candidate_text(candidate));
  }
  lines.add("scene", spec.content().scene());
  if (const v1::UnitStats& stats = status.stats(); stats.fireflies() > 0) {
    lines.add("fireflies", absl::StrCat(stats.fireflies(), " samples with ",
                                        absl::StrFormat("%.3g", 100 * stats.firefly_light() / stats.light()),
                                        " % of the light"));
  }
  lines.add_if_any("isa", status.isa());
  lines.add("bits", spec.farm().bits() == v1::BITS_ANY ? "any: every machine may work" : "same");
  for (const std::string& name : status.arithmetic_classes()) lines.add("arithmetic", name);
  add_trouble(job, lines);
  const char* label = "time";
  if (const std::string spent = to_text(time_spent(status.stats())); !spent.empty()) {
    for (const std::string& line : std::vector<std::string>(absl::StrSplit(spent, '\n'))) {
      lines.add(std::exchange(label, ""), line);
    }
  }
  for (const std::string& note : status.notes()) lines.add("note", note);
  for (const std::string& note : status.stats().notes()) lines.add("scene", note);
  for (const std::string& warning : status.stats().warnings()) lines.add("warning", warning);
  return lines.text();
}

std::string to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  // Fails only for Any and for times out of range; neither is in these messages.
  static_cast<void>(google::protobuf::util::MessageToJsonString(message, &json, options));
  return json;
}

}  // namespace tessera::client
