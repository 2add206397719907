#include "service/job/adoption.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

#include "service/job/journal_events.h"
#include "service/job/result_check.h"
#include "wire/arithmetic_class.h"
#include "wire/message_digest.h"
#include "wire/unit_counts.h"

namespace tessera::server {
namespace {

using google::protobuf::util::MessageDifferencer;

/// Where noise decides, the cap is part of the decision.
bool results_depend_on_samples(const v1::JobSpec& spec) { return spec.samples().noise() != 0; }

/// The parts of a spec on which the result of a unit depends.
v1::JobSpec content_of(const v1::JobSpec& spec) {
  v1::JobSpec content;
  *content.mutable_content() = spec.content();
  *content.mutable_view() = spec.view();
  *content.mutable_cut() = spec.cut();
  if (results_depend_on_samples(spec)) *content.mutable_samples() = spec.samples();
  return content;
}

/// Drops costs, for they are not spent again, and keeps what describes the image.
std::string without_cost(const std::string& serialized) {
  v1::UnitStats all, kept;
  if (!all.ParseFromString(serialized)) return "";
  wire::set_counts(wire::of_image(wire::counts_of(all)), kept);
  *kept.mutable_warnings() = all.warnings();
  *kept.mutable_notes() = all.notes();
  return kept.SerializeAsString();
}

struct Fitting {
  std::size_t index;  // of the donor's results
  std::string arithmetic_class;
  UnitRun units;  // of the job
};

/// Results that are of a unit of the job's, and rendered as it asks for by a host that is trusted.
std::vector<Fitting> fitting_results(const Scheduler& scheduler, const JobRequest& job, const Donor& donor) {
  const std::vector<std::uint64_t> revoked = revoked_results(donor.record);
  const ClassHistory classes = classes_of(donor.record);
  std::vector<Fitting> fitting;
  for (std::size_t i = 0; i < donor.record.results.size(); ++i) {
    const JobRecord::Result& result = donor.record.results[i];
    const std::string& name = classes.of(result.host, static_cast<std::uint32_t>(i + 1));
    // Both plans number the tiles of a range, and the ranges, in the same order; the last range may be cut.
    const std::optional<UnitRun> units = job.plan->run(result.units.first, result.units.ranges);
    const std::optional<UnitRun> of_donor = donor.plan->run(result.units.first, result.units.ranges);
    if (!units || !of_donor || std::binary_search(revoked.begin(), revoked.end(), i + 1) ||
        !scheduler.trusts(result.host) || (!job.isa.empty() && wire::isa_of(name) != job.isa) ||
        !MessageDifferencer::Equals(job.plan->unit(*units), donor.plan->unit(*of_donor))) {
      continue;
    }
    fitting.push_back({.index = i, .arithmetic_class = name, .units = *units});
  }
  return fitting;
}

std::string most_common_class(const std::vector<Fitting>& fitting) {
  std::map<std::string, std::uint64_t> units;
  for (const Fitting& result : fitting) units[result.arithmetic_class] += result.units.count;
  const auto most = std::max_element(units.begin(), units.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == units.end() ? "" : most->first;
}

/// Whether all units of the phases are among the results, and what the picture is made of is there.
bool has_phases(const WorkPlan& plan, const std::vector<JournalEntry>& results,
                const absl::flat_hash_set<std::string>& blobs) {
  const std::vector<std::uint32_t>& roots = plan.phases().roots();
  std::uint32_t units = 0;
  for (const JournalEntry& entry : results) {
    const auto& result = std::get<UnitDone>(entry);
    if (plan.is_of_picture(result.units.first)) continue;
    ++units;
    if (std::binary_search(roots.begin(), roots.end(), result.units.first) && !blobs.contains(result.digest))
      return false;
  }
  return units == plan.phases().unit_count();
}

}  // namespace

std::string result_key(const v1::JobSpec& spec) {
  const v1::JobSpec::Samples none;
  return wire::digest_of({&spec.content(), &spec.view(), &spec.cut(),
                          results_depend_on_samples(spec) ? &spec.samples() : &none});
}

std::string difference_in_content(const v1::JobSpec& a, const v1::JobSpec& b) {
  std::string report;
  MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&report);
  if (differencer.Compare(content_of(a), content_of(b))) return "";
  return report.substr(0, report.find('\n'));
}

absl::Status adopt_results(Scheduler& scheduler, const JobRequest& job, const Donor& donor,
                           std::vector<JournalEntry>& entries) {
  const std::vector<Fitting> fitting = fitting_results(scheduler, job, donor);
  std::optional<std::string> chosen;
  if (!job.any_class) chosen = most_common_class(fitting);
  std::vector<AdoptedResult> adopted;
  std::vector<JournalEntry> done;
  std::uint64_t adopted_units = 0;
  for (const auto& [index, name, units] : fitting) {
    if (chosen && name != *chosen) continue;
    const JobRecord::Result& result = donor.record.results[index];
    adopted.push_back({.units = units,
                       .fingerprint = fingerprint_of(result.digest),
                       .host = result.host,
                       .arithmetic_class = name});
    done.push_back(UnitDone{.job = job.id,
                            .sequence = adopted.size(),
                            .units = result.units,
                            .digest = result.digest,
                            .payload = "",
                            .stats = without_cost(result.stats),
                            .host = result.host,
                            .from_job = donor.record.added.id,
                            .from_sequence = index + 1});
    adopted_units += units.count;
  }
  if (!has_phases(*job.plan, done, donor.blobs)) return absl::OkStatus();
  if (chosen && adopted_units < job.plan->unit_count()) {
    // Results from before classes were told of do not say whose arithmetic the rest should have.
    if (!wire::is_whole_class(*chosen)) return absl::OkStatus();
    if (!donor.named && scheduler.worker_count() > 0 && !scheduler.has_class(*chosen))
      return absl::OkStatus();
  }
  if (absl::Status status = scheduler.adopt(job.id, donor.record.added.id, adopted); !status.ok())
    return status;
  entries.insert(entries.end(), std::make_move_iterator(done.begin()), std::make_move_iterator(done.end()));
  return absl::OkStatus();
}

}  // namespace tessera::server
