// Whether a payload is the result of a unit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "scheduler/unit_ledger.h"
#include "tessera/v1/job.pb.h"
#include "wire/tile_result.h"

namespace tessera::server {

/// The SHA-256 of the decoded contents, which is the same whatever version of zstd compressed them.
/// InvalidArgument, with what is wrong, when the bytes are damaged, do not have the rectangle, sample range
/// and channels of the unit, or hold what no renderer returns: numbers of samples that the job does not
/// allow, values that are not finite or larger than so many samples can sum up to, negative squares. Sums may
/// be negative, for pixel filters may be.
absl::StatusOr<std::string> check_result(std::string_view payload, const v1::WorkUnit& unit,
                                         const v1::JobSpec& spec,
                                         const std::vector<wire::ChannelDesc>& channels);

/// The same, with the digest that `part` of its pixels would have as a result of their own.
struct CheckedResult {
  std::string digest, part;
};
absl::StatusOr<CheckedResult> check_result_and_part(std::string_view payload, const v1::WorkUnit& unit,
                                                    const v1::JobSpec& spec,
                                                    const std::vector<wire::ChannelDesc>& channels,
                                                    const v1::PixelRect& part);

/// Fingerprint of a digest, which the scheduler keeps.
ResultFingerprint fingerprint_of(const std::string& digest);

}  // namespace tessera::server
