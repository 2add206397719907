// Which blobs the units of a job's phases made.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "scheduler/phase_plan.h"
#include "store/blobs/blob_store.h"

namespace tessera::server {

/// By unit; about 50 bytes each, whatever is in the blobs.
class PhaseBlobs {
 public:
  struct Made {
    std::uint32_t unit = 0;
    std::string digest;
    std::uint64_t sequence = 0;  // number of the result that names it
  };

  /// `digest` satisfies wire::is_digest. Later results of a unit replace earlier ones.
  void note(std::uint32_t unit, const std::string& digest, std::uint64_t sequence);
  /// Blobs that the unit reads, in the order in which it reads them; units that made none are left out.
  std::vector<Made> inputs(const PhasePlan& phases, std::uint32_t unit) const;
  /// Digest of the blob that the unit made.
  std::optional<std::string> made_by(std::uint32_t unit) const;
  /// Whether some unit made the blob.
  bool has(const std::string& digest) const;
  void for_each_digest(const std::function<void(std::string digest)>& visit) const;
  /// Forgets all but those of these units.
  void keep(const std::vector<std::uint32_t>& units);

 private:
  struct Entry {
    std::array<char, 32> digest;
    std::uint64_t sequence;
  };
  absl::flat_hash_map<std::uint32_t, Entry> made_;
};

/// Digest of the blob that the result of a part or a merge names. InvalidArgument where the payload names
/// none that the store has, of that size.
absl::StatusOr<std::string> check_blob_result(std::string_view payload, std::uint32_t unit,
                                              const BlobStore& blobs);

/// InvalidArgument, with what is wrong, where the blob that the part or the merge is said to have made is
/// none that a renderer makes of it. Reads it whole, into memory, unless it is larger than any of these.
absl::Status check_made_blob(const std::string& digest, const v1::WorkUnit& unit, const v1::JobSpec& spec,
                             const BlobStore& blobs);

}  // namespace tessera::server
