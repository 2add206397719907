// Mitsuba's .vol files: samples on a grid.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::client::mitsuba {

struct VolumeFile {
  std::array<std::uint32_t, 3> size;  // samples along x, y and z
  std::uint32_t channels = 1;
  std::array<double, 3> box_min, box_max;
  std::string blob;  // proto/wire/volume_blob.h
};

/// Format version 3 with float samples. InvalidArgument for anything else: damaged or cut off, sizes that the
/// file cannot hold, samples that are not finite.
absl::StatusOr<VolumeFile> read_volume_file(std::string_view bytes);

}  // namespace tessera::client::mitsuba
