// The bytes of a grid of samples. Little endian, so that a mapped file can be used in place:
//
//   0   char[8]  magic "TSRVOLU1"
//   8   u32      samples along x, y and z (each 1 to 65536)
//   20  u32      channels C (1 to 4)
//   24  u32[2]   reserved, 0
//   32  f32[nx ny nz C]  samples, channels together, x fastest, then y, then z
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::wire {

/// The samples of a volume, inside a blob or elsewhere; `samples` holds nx * ny * nz * channels floats.
struct VolumeView {
  std::uint32_t nx = 0, ny = 0, nz = 0, channels = 0;
  std::span<const float> samples;
};

/// The blob of a volume whose samples fit its sizes.
std::string encode_volume(const VolumeView& volume);

/// A view into `blob`, whose data must be 4-byte aligned. InvalidArgument, with what is wrong, for a bad
/// magic, sizes that do not fit the blob, or a sample that is not finite.
absl::StatusOr<VolumeView> decode_volume(std::string_view blob);

}  // namespace tessera::wire
