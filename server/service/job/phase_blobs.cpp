#include "service/job/phase_blobs.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "tessera/v1/blob_ref.pb.h"
#include "wire/digest.h"
#include "wire/job_check.h"

namespace tessera::server {
namespace {

std::string hex_of(const std::array<char, 32>& digest) {
  return absl::BytesToHexString({digest.data(), digest.size()});
}

std::array<char, 32> bytes_of(const std::string& digest) {
  std::array<char, 32> bytes{};
  const std::string read = absl::HexStringToBytes(digest);
  std::copy_n(read.begin(), std::min(read.size(), bytes.size()), bytes.begin());
  return bytes;
}

}  // namespace

void PhaseBlobs::note(std::uint32_t unit, const std::string& digest, std::uint64_t sequence) {
  made_[unit] = {.digest = bytes_of(digest), .sequence = sequence};
}

bool PhaseBlobs::has(const std::string& digest) const {
  const std::array<char, 32> bytes = bytes_of(digest);
  return std::ranges::any_of(made_, [&](const auto& made) { return made.second.digest == bytes; });
}

std::vector<PhaseBlobs::Made> PhaseBlobs::inputs(const PhasePlan& phases, std::uint32_t unit) const {
  std::vector<Made> inputs;
  for (const std::uint32_t source : phases.inputs(unit)) {
    const auto found = made_.find(source);
    if (found == made_.end()) continue;
    const Entry& entry = found->second;
    inputs.push_back({.unit = source, .digest = hex_of(entry.digest), .sequence = entry.sequence});
  }
  return inputs;
}

void PhaseBlobs::for_each_digest(const std::function<void(std::string)>& visit) const {
  for (const auto& [unit, entry] : made_) visit(hex_of(entry.digest));
}

std::optional<std::string> PhaseBlobs::made_by(std::uint32_t unit) const {
  const auto found = made_.find(unit);
  if (found == made_.end()) return std::nullopt;
  return hex_of(found->second.digest);
}

void PhaseBlobs::keep(const std::vector<std::uint32_t>& units) {
  absl::flat_hash_map<std::uint32_t, Entry> kept;
  for (const std::uint32_t unit : units) {
    if (const auto found = made_.find(unit); found != made_.end()) kept.insert(*found);
  }
  made_ = std::move(kept);
}

absl::StatusOr<std::string> check_blob_result(std::string_view payload, std::uint32_t unit,
                                              const BlobStore& blobs) {
  const auto unfit = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("result of unit ", unit, ": ", what));
  };
  v1::BlobRef blob;
  if (!blob.ParseFromArray(payload.data(), static_cast<int>(payload.size())) ||
      !wire::is_digest(blob.digest())) {
    return unfit("it names no blob by SHA-256 digest");
  }
  const UploadState stored = blobs.query(blob.digest());
  if (!stored.complete || stored.stored_bytes != blob.size_bytes()) {
    return unfit(absl::StrCat("there is no blob ", blob.digest(), " of ", blob.size_bytes(), " bytes"));
  }
  return blob.digest();
}

absl::Status check_made_blob(const std::string& digest, const v1::WorkUnit& unit, const v1::JobSpec& spec,
                             const BlobStore& blobs) {
  const std::optional<wire::ExpectedBlob> expected = wire::expected_blob(spec, unit);
  if (!expected) return absl::OkStatus();
  const auto unfit = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("result of unit ", unit.index(), ": ", what));
  };
  const absl::StatusOr<std::unique_ptr<BlobReader>> reader = blobs.read(digest);
  if (!reader.ok()) return reader.status();
  const std::uint64_t size = (*reader)->size(), most = expected->check->most_bytes(expected->blob);
  if (size > most)
    return unfit(absl::StrCat("its blob has ", size, " bytes; at most ", most, " were expected"));
  const absl::StatusOr<std::string> bytes = (*reader)->read(0, size);
  if (!bytes.ok()) return bytes.status();
  const char* const fault = expected->check->fault(*bytes, expected->blob);
  return fault == nullptr ? absl::OkStatus() : unfit(absl::StrCat("its blob is ", fault));
}

}  // namespace tessera::server
