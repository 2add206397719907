#include "command/job_table.h"

#include <google/protobuf/util/json_util.h>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "command/time_spent.h"

namespace tessera::client {

namespace {

/// "pixels 0,0 to 32,32, samples 0 to 16".
std::string place_of(const v1::WorkUnit& unit) {
  const v1::SampleRange& samples = unit.has_tile() ? unit.tile().samples() : unit.pass().passes();
  std::string place = absl::StrCat("samples ", samples.begin(), " to ", samples.end());
  if (!unit.has_tile()) return place;
  const v1::PixelRect& pixels = unit.tile().pixels();
  return absl::StrCat("pixels ", pixels.x0(), ",", pixels.y0(), " to ", pixels.x1(), ",", pixels.y1(), ", ", place);
}

std::string noise_text(const v1::RenderSettings& settings) {
  return settings.noise() == 0 ? "" : absl::StrCat(" at most, to a noise of ", settings.noise());
}

// From this multiple of the usual time on, a worker is called slow.
constexpr double kSlow = 2;

/// Whose certificate a worker has, where that is not its host's.
std::string certificate_text(const v1::WorkerStatus& worker) {
  const std::string& name = worker.certificate();
  return name.empty() || name == worker.host() ? "" : absl::StrCat(", certificate of ", name);
}

/// ", avx2/embree-3.13.5/1f3a9c0e, left out of jobs 4f0c2a11 77aa01bc".
std::string arithmetic_text(const v1::WorkerStatus& worker) {
  const auto& classes = worker.arithmetic().classes();
  const auto& closed = worker.arithmetic().closed_jobs();
  return absl::StrCat(classes.empty() ? "" : ", ", absl::StrJoin(classes, " "),
                      closed.empty() ? "" : ", left out of jobs ", absl::StrJoin(closed, " "));
}

std::string slowness_text(const v1::WorkerStatus& worker) {
  return worker.slowness() < kSlow ? "" : absl::StrFormat(", slow: %.1f times the usual time", worker.slowness());
}

double seconds(const google::protobuf::Duration& time) {
  return static_cast<double>(time.seconds()) + 1e-9 * time.nanos();
}

}  // namespace

const char* state_name(v1::JobState state) {
  switch (state) {
    case v1::QUEUED:
      return "queued";
    case v1::RUNNING:
      return "running";
    case v1::DONE:
      return "done";
    case v1::FAILED:
      return "failed";
    case v1::CANCELLED:
      return "cancelled";
    case v1::INCOMPLETE:
      return "incomplete";
    default:
      return "unknown";
  }
}

std::string state_text(const v1::JobStatus& status) {
  std::string text = state_name(status.state());
  if (status.paused()) text += ", paused";
  if (status.units_set_aside() > 0) absl::StrAppend(&text, ", ", status.units_set_aside(), " units set aside");
  return text;
}

std::string jobs_table(const std::vector<v1::JobStatus>& jobs) {
  std::string table = absl::StrFormat("%-20s %-10s %15s  %-7s %8s %-10s %s\n", "ID", "STATE", "UNITS", "ISA",
                                      "PRIORITY", "USER", "NAME");
  for (const v1::JobStatus& job : jobs) {
    const std::string units = absl::StrCat(job.units_done(), "/", job.units_total());
    absl::StrAppend(&table, absl::StrFormat("%-20s %-10s %15s  %-7s %8d %-10s %s\n", job.job_id(),
                                            job.paused() ? "paused" : state_name(job.state()), units, job.isa(),
                                            job.priority(), job.user(), job.name()));
  }
  return table;
}

std::string workers_table(const std::vector<v1::WorkerStatus>& workers) {
  std::string table = absl::StrFormat("%-20s %-24s %-7s %7s %6s %10s  %s\n", "ID", "NAME", "ISA", "THREADS", "LEASES",
                                      "UNITS DONE", "LAST SEEN");
  for (const v1::WorkerStatus& worker : workers) {
    absl::StrAppend(
        &table,
        absl::StrFormat("%-20s %-24s %-7s %7u %6u %10u  %.1f s ago%s%s%s%s%s%s\n", worker.worker_id(), worker.name(),
                        worker.isa(), worker.threads(), worker.leases(), worker.units_done(),
                        1e-3 * static_cast<double>(worker.last_seen_ms_ago()), worker.draining() ? ", draining" : "",
                        slowness_text(worker), certificate_text(worker), arithmetic_text(worker),
                        worker.quarantine().empty() ? "" : ", in quarantine: ", worker.quarantine()));
  }
  return table;
}

std::string job_text(const v1::GetJobResponse& job) {
  const v1::JobStatus& status = job.status();
  const v1::JobSpec& spec = job.spec();
  std::string text =
      absl::StrCat("id          ", status.job_id(), "\n",                                  //
                   "name        ", status.name(), "\n",                                    //
                   "state       ", state_text(status), "\n",                               //
                   "user        ", status.user(), ", priority ", status.priority(), "\n",  //
                   "units       ", status.units_done(), " of ", status.units_total(), " done, ", status.units_leased(),
                   " at work\n", "film        ", spec.width(), "x", spec.height(), ", ", spec.settings().spp(),
                   " samples a pixel", noise_text(spec.settings()), "\n", "integrator  ", spec.settings().integrator(),
                   ", depth ", spec.settings().max_depth(), ", seed ", spec.settings().seed(), "\n",  //
                   "scene       ", spec.scene().digest(), "\n");
  if (status.units_adopted() > 0) {
    absl::StrAppend(&text, "taken over  ", status.units_adopted(), " units of job ", status.adopted_from(), "\n");
  }
  if (const v1::UnitStats& stats = status.stats(); stats.fireflies() > 0) {
    absl::StrAppend(&text, "fireflies   ", stats.fireflies(), " samples with ",
                    absl::StrFormat("%.3g", 100 * stats.firefly_light() / stats.light()), " % of the light\n");
  }
  if (!status.isa().empty()) absl::StrAppend(&text, "isa         ", status.isa(), "\n");
  absl::StrAppend(&text, "bits        ", spec.bits() == v1::BITS_ANY ? "any: every machine may work" : "same", "\n");
  for (const std::string& name : status.arithmetic_classes()) {
    absl::StrAppend(&text, "arithmetic  ", name, "\n");
  }
  if (!status.error().empty()) absl::StrAppend(&text, "error       ", status.error(), "\n");
  if (!status.waiting_for().empty()) absl::StrAppend(&text, "waits       ", status.waiting_for(), "\n");
  if (!status.left_out().empty()) absl::StrAppend(&text, "left out    ", status.left_out(), "\n");
  for (const v1::SlowHost& slow : job.slow_hosts()) {
    absl::StrAppend(
        &text, absl::StrFormat("slow        host %s: %.2f s a unit, where %.2f s are usual (%u units)\n", slow.host(),
                               seconds(slow.unit_time()), seconds(job.usual_unit_time()), slow.units()));
  }
  for (const v1::SetAsideUnit& aside : status.set_aside()) {
    absl::StrAppend(&text, "set aside   unit ", aside.unit().index(), ", ", place_of(aside.unit()), "\n");
    for (const v1::UnitFailure& failure : aside.failures()) {
      absl::StrAppend(&text, "            on ", failure.host(), ": ", failure.message(), "\n");
    }
  }
  if (const std::string spent = to_text(time_spent(status.stats())); !spent.empty()) {
    absl::StrAppend(&text, "time        ", absl::StrReplaceAll(spent, {{"\n", "\n            "}}), "\n");
  }
  for (const std::string& note : status.notes()) absl::StrAppend(&text, "note        ", note, "\n");
  for (const std::string& warning : status.stats().warnings()) absl::StrAppend(&text, "warning     ", warning, "\n");
  return text;
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
