// The contract on pixel filters: their usual sizes, and how samples become pixels with them.
#pragma once

#include "absl/status/status.h"
#include "tessera/v1/camera.pb.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

struct FilterRadius {
  float x, y;  // pixels
};

/// The filter's radius, which is its kind's usual one where it says none.
FilterRadius radius_of(const v1::PixelFilter& filter);

/// Whether samples that go into all pixels around bring a picture of less error than those that go into one
/// [docs/decisions/0046-pixel-reconstruction.md]. Never for boxes.
bool gains_by_scattering(const v1::PixelFilter& filter);

/// InvalidArgument where samples would reach further than kMaxScatterRadius.
absl::Status check_scattering(const v1::PixelFilter& filter);

/// Whether the job's algorithm and samples allow that samples go into several pixels; the reason where not.
absl::Status allows_scattering(const v1::JobSpec& spec);

}  // namespace tessera::wire
