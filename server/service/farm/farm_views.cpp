// Views of jobs for people who look on; nothing here changes a job.
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/farm/farm.h"

namespace tessera::server {

absl::StatusOr<std::shared_ptr<const JobShape>> Farm::shape_of(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok()) return entry.status();
  return (*entry)->shape;
}

absl::StatusOr<std::string> Farm::result_of(const std::string& id, std::uint64_t sequence) {
  return journal_.read_result(id, sequence);
}

absl::StatusOr<std::vector<v1::UnitStats>> Farm::costs_of(const std::string& id, std::uint64_t after,
                                                          std::uint32_t most) {
  const absl::StatusOr<std::vector<std::string>> read = journal_.read_stats(id, after, most);
  if (!read.ok()) return read.status();
  std::vector<v1::UnitStats> costs(read->size());
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (!costs[i].ParseFromString((*read)[i]))
      return absl::DataLossError(absl::StrCat("journal: cost of result ", after + i + 1, " of job ", id));
  }
  return costs;
}

absl::StatusOr<std::string> Farm::last_phase_of(const std::string& id) {
  std::optional<std::string> digest;
  {
    const std::lock_guard lock(mutex_);
    const absl::StatusOr<JobEntry*> entry = find_job(id);
    if (!entry.ok()) return entry.status();
    const std::vector<std::uint32_t>& roots = (*entry)->shape->plan->phases().roots();
    if (!roots.empty()) digest = (*entry)->phase_blobs.made_by(roots.back());
  }
  if (!digest) return absl::NotFoundError(absl::StrCat("job ", id, " has no blob of a last phase"));
  const absl::StatusOr<std::unique_ptr<BlobReader>> blob = blobs_.read(*digest);
  if (!blob.ok()) return blob.status();
  return (*blob)->read(0, (*blob)->size());
}

std::vector<Farm::PixelsInWork> Farm::in_work(const std::string& id, std::size_t most) {
  const std::lock_guard lock(mutex_);
  std::vector<PixelsInWork> result;
  const absl::StatusOr<JobEntry*> entry = find_job(id);
  if (!entry.ok() || (*entry)->past) return result;
  const JobShape& shape = *(*entry)->shape;
  for (const Lease& lease : scheduler_.leases_of(id)) {
    if (result.size() == most) break;
    if (!shape.plan->is_of_picture(lease.units.first)) continue;
    const v1::TileUnit extent = extent_of(shape.plan->unit(lease.units), shape.spec);
    if (extent.view() == 0) result.push_back({.pixels = extent.pixels(), .worker = lease.worker});
  }
  return result;
}

std::chrono::milliseconds Farm::heartbeat_interval() const {
  const std::lock_guard lock(mutex_);
  return scheduler_.heartbeat_interval();
}

}  // namespace tessera::server
