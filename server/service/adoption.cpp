#include "service/adoption.h"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>

#include "service/journal_events.h"
#include "service/result_check.h"

namespace tessera::server {
namespace {

using google::protobuf::util::MessageDifferencer;

/// The part of a spec on which the result of a unit depends. A scene names its blobs by digest, so its own stands for
/// all.
v1::JobSpec content_of(const v1::JobSpec& spec) {
  v1::JobSpec content;
  content.mutable_scene()->set_digest(spec.scene().digest());
  *content.mutable_settings() = spec.settings();
  // Where noise decides, the cap is part of the decision.
  if (spec.settings().noise() == 0) content.mutable_settings()->clear_spp();
  content.set_width(spec.width());
  content.set_height(spec.height());
  *content.mutable_crop() = spec.crop();
  content.set_tile_size(spec.tile_size());
  content.set_samples_per_unit(spec.samples_per_unit());
  content.set_build(spec.build());
  *content.mutable_aovs() = spec.aovs();
  std::sort(content.mutable_aovs()->begin(), content.mutable_aovs()->end());
  return content;
}

/// What is said of the image stays; what was spent is not spent again.
std::string without_cost(const std::string& serialized) {
  v1::UnitStats all, kept;
  if (!all.ParseFromString(serialized)) return "";
  kept.set_dropped_samples(all.dropped_samples());
  kept.set_fireflies(all.fireflies());
  kept.set_firefly_light(all.firefly_light());
  kept.set_light(all.light());
  *kept.mutable_warnings() = all.warnings();
  return kept.SerializeAsString();
}

}  // namespace

std::string difference_in_content(const v1::JobSpec& a, const v1::JobSpec& b) {
  std::string report;
  MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&report);
  if (differencer.Compare(content_of(a), content_of(b))) return "";
  return report.substr(0, report.find('\n'));
}

absl::Status adopt_results(Scheduler& scheduler, const std::string& job, const WorkPlan& plan, const Donor& donor,
                           std::vector<JournalEntry>& entries) {
  const std::vector<std::uint64_t> revoked = revoked_results(donor.record);
  std::vector<AdoptedResult> adopted;
  for (std::size_t i = 0; i < donor.record.results.size(); ++i) {
    const JobRecord::Result& result = donor.record.results[i];
    // Both plans number the tiles of a range, and the ranges, in the same order; the last range may be cut.
    if (result.unit >= plan.unit_count() || std::binary_search(revoked.begin(), revoked.end(), i + 1) ||
        !scheduler.trusts(result.host) ||
        !MessageDifferencer::Equals(plan.unit(result.unit), donor.plan->unit(result.unit))) {
      continue;
    }
    adopted.push_back({.unit = result.unit, .fingerprint = fingerprint_of(result.digest), .host = result.host});
    entries.push_back(UnitDone{.job = job,
                               .sequence = adopted.size(),
                               .unit = result.unit,
                               .digest = result.digest,
                               .payload = "",
                               .stats = without_cost(result.stats),
                               .host = result.host,
                               .from_job = donor.record.added.id,
                               .from_sequence = i + 1});
  }
  return scheduler.adopt(job, donor.record.added.id, donor.isa, adopted);
}

}  // namespace tessera::server
