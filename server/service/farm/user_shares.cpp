#include "service/farm/user_shares.h"

#include "service/farm/farm_core.h"

namespace tessera::server {

UserShares::UserShares(FarmCore& core) : core_(core), uploads_(core.options().retention.blobs) {}

const Quotas& UserShares::quotas() const { return core_.options().quotas; }

UserShare UserShares::share_of(const std::string& user) const {
  UserShare share{.blob_bytes = core_.jobs().blobs().bytes_of(user) + uploads_.held_by(user)};
  for (const auto& entry : core_.jobs().all()) {
    if (entry->past || entry->shape->spec.farm().user() != user) continue;
    share.open_jobs += entry->durable_end ? 0 : 1;
    share.units += entry->shape->plan->unit_count();
  }
  return share;
}

absl::Status UserShares::begin_upload(const v1::BlobRef& blob, const Caller& by) {
  if (!by.has_quotas() || core_.blobs().query(blob.digest()).complete) return absl::OkStatus();
  const std::lock_guard lock(core_.mutex());
  const std::uint64_t bytes =
      core_.jobs().blobs().bytes_of(by.user) + uploads_.held_by(by.user, blob.digest()) + blob.size_bytes();
  if (absl::Status s = quotas().check_blob_bytes(by.user, bytes); !s.ok()) return s;
  uploads_.begin(blob.digest(), blob.size_bytes(), by.user, core_.clock().now());
  return absl::OkStatus();
}

void UserShares::note_upload(const std::string& digest, std::uint64_t bytes) {
  core_.tell(news::BlobUploaded{bytes});
  const std::lock_guard lock(core_.mutex());
  uploads_.note(digest, bytes, core_.clock().now());
}

absl::Status UserShares::check_priority(const Caller& by, std::int32_t priority) const {
  return by.has_quotas() ? quotas().check_priority(by.user, priority) : absl::OkStatus();
}

absl::Status UserShares::check_new_job(const Caller& by, const JobShape& shape,
                                       const std::vector<std::uint64_t>& blob_sizes) const {
  if (!by.has_quotas()) return absl::OkStatus();
  const std::string& user = shape.spec.farm().user();
  UserShare share = share_of(user);
  ++share.open_jobs;
  share.units += shape.plan->unit_count();
  share.blob_bytes =
      core_.jobs().blobs().bytes_with(shape.spec, blob_sizes) + uploads_.held_by(user, shape.spec);
  return quotas().check_share(user, share);
}

absl::Status UserShares::check_reopening(const Caller& by, const JobEntry& entry) const {
  if (!by.has_quotas()) return absl::OkStatus();
  if (absl::Status s = check_priority(by, core_.view_of(entry).priority); !s.ok()) return s;
  const std::string& user = entry.shape->spec.farm().user();
  UserShare share = share_of(user);
  ++share.open_jobs;
  return quotas().check_share(user, share);
}

}  // namespace tessera::server
