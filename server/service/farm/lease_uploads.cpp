#include "service/farm/lease_uploads.h"

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

/// The grant, of all fields that the coordinator has sealed.
std::string name_of(const v1::LeaseToken& lease) {
  return absl::StrCat(lease.job_id(), " ", lease.generation(), " ", lease.unit_index(), " ", lease.attempt(),
                      " ", lease.epoch());
}

}  // namespace

absl::Status LeaseUploads::begin(const v1::LeaseToken& lease, const v1::BlobRef& blob,
                                 const std::string& identity, TimePoint now) {
  const std::string name = name_of(lease);
  const std::string& digest = blob.digest();
  if (const auto other = digest_by_lease_.find(name);
      other != digest_by_lease_.end() && other->second != digest) {
    return absl::InvalidArgumentError(absl::StrCat("the lease of unit ", lease.unit_index(), " of job ",
                                                   lease.job_id(), " calls for one blob, and has brought ",
                                                   other->second, " already"));
  }
  if (blob.size_bytes() > kMostBlobBytes) {
    return absl::InvalidArgumentError(absl::StrCat("the blob of unit ", lease.unit_index(), " of job ",
                                                   lease.job_id(), " has ", blob.size_bytes(),
                                                   " bytes; at most ", kMostBlobBytes, " are taken"));
  }
  const auto known = uploads_.find(digest);
  const bool own = known != uploads_.end() && known->second.identity == identity;
  const std::uint64_t bytes = held_by(identity) - (own ? known->second.size : 0) + blob.size_bytes();
  if (bytes > kMostIdentityBytes) {
    return absl::ResourceExhaustedError(absl::StrCat("this worker's identity would have ", bytes,
                                                     " bytes of blobs that no result names; at most ",
                                                     kMostIdentityBytes, " are taken"));
  }
  if (known != uploads_.end()) forget(known);
  held_bytes_by_identity_[identity] += blob.size_bytes();
  digest_by_lease_[name] = digest;
  uploads_[digest] = {.lease = name, .identity = identity, .size = blob.size_bytes(), .begun = now};
  return absl::OkStatus();
}

void LeaseUploads::claim(const std::string& digest) {
  if (const auto found = uploads_.find(digest); found != uploads_.end()) forget(found);
}

std::vector<std::string> LeaseUploads::take_old(TimePoint now) {
  std::vector<std::string> old;
  for (const auto& [digest, upload] : uploads_) {
    if (upload.begun + kKept <= now) old.push_back(digest);
  }
  for (const std::string& digest : old) claim(digest);
  return old;
}

std::uint64_t LeaseUploads::held_by(const std::string& identity) const {
  const auto found = held_bytes_by_identity_.find(identity);
  return found == held_bytes_by_identity_.end() ? 0 : found->second;
}

void LeaseUploads::forget(Uploads::iterator upload) {
  const auto held = held_bytes_by_identity_.find(upload->second.identity);
  if (held != held_bytes_by_identity_.end() && (held->second -= upload->second.size) == 0)
    held_bytes_by_identity_.erase(held);
  digest_by_lease_.erase(upload->second.lease);
  uploads_.erase(upload);
}

}  // namespace tessera::server
