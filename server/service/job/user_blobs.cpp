#include "service/job/user_blobs.h"

#include <algorithm>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/escaping.h"

namespace tessera::server {

UserBlobs::Key UserBlobs::key_of(const std::string& digest) {
  Key key{};
  const std::string bytes = absl::HexStringToBytes(digest);
  std::copy_n(bytes.begin(), std::min(bytes.size(), key.size()), key.begin());
  return key;
}

bool UserBlobs::is_used_by(const Blob& blob, std::optional<UserNumber> user) {
  return std::ranges::any_of(blob.uses_by_user, [&](const auto& use) { return use.first == user; });
}

void UserBlobs::add(const v1::JobSpec& spec, const std::vector<std::uint64_t>& sizes) {
  const UserNumber user =
      users_.try_emplace(spec.farm().user(), static_cast<UserNumber>(users_.size())).first->second;
  bytes_by_user_.resize(users_.size());
  for (int i = 0; i < spec.farm().blobs_size(); ++i) {
    const auto [found, is_new] = blobs_.try_emplace(key_of(spec.farm().blobs(i).digest()));
    Blob& blob = found->second;
    if (is_new) blob.size = sizes[static_cast<std::size_t>(i)];
    const auto use = std::ranges::find(blob.uses_by_user, user, &std::pair<UserNumber, std::uint32_t>::first);
    if (use != blob.uses_by_user.end()) {
      ++use->second;
      continue;
    }
    blob.uses_by_user.emplace_back(user, 1);
    bytes_by_user_[user] += blob.size;
  }
}

void UserBlobs::remove(const v1::JobSpec& spec) {
  const auto user = users_.find(spec.farm().user());
  if (user == users_.end()) return;
  for (const v1::BlobRef& ref : spec.farm().blobs()) {
    const auto found = blobs_.find(key_of(ref.digest()));
    if (found == blobs_.end()) continue;
    Blob& blob = found->second;
    const auto use =
        std::ranges::find(blob.uses_by_user, user->second, &std::pair<UserNumber, std::uint32_t>::first);
    if (use == blob.uses_by_user.end() || --use->second > 0) continue;
    bytes_by_user_[user->second] -= blob.size;
    blob.uses_by_user.erase(use);
    if (blob.uses_by_user.empty()) blobs_.erase(found);
  }
}

std::uint64_t UserBlobs::bytes_of(const std::string& user) const {
  const auto found = users_.find(user);
  return found == users_.end() ? 0 : bytes_by_user_[found->second];
}

std::uint64_t UserBlobs::bytes_with(const v1::JobSpec& spec, const std::vector<std::uint64_t>& sizes) const {
  const auto known = users_.find(spec.farm().user());
  const std::optional<UserNumber> user = known == users_.end() ? std::nullopt : std::optional(known->second);
  std::uint64_t bytes = user ? bytes_by_user_[*user] : 0;
  absl::flat_hash_set<Key> added;
  for (int i = 0; i < spec.farm().blobs_size(); ++i) {
    const Key key = key_of(spec.farm().blobs(i).digest());
    const auto found = blobs_.find(key);
    if (found != blobs_.end() && is_used_by(found->second, user)) continue;
    if (added.insert(key).second) bytes += sizes[static_cast<std::size_t>(i)];
  }
  return bytes;
}

std::optional<std::uint64_t> UserBlobs::size_of(const std::string& digest) const {
  const auto found = blobs_.find(key_of(digest));
  if (found == blobs_.end()) return std::nullopt;
  return found->second.size;
}

}  // namespace tessera::server
