#include "wire/volume_blob.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace tessera::wire {

namespace {

constexpr std::string_view kVolumeMagic = "TSRVOLU1";
constexpr std::size_t kHeaderSize = 32;
constexpr std::uint32_t kMaxSide = 65536, kMaxVolumeChannels = 4;

absl::Status invalid(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("volume blob: ", what));
}

}  // namespace

std::string encode_volume(const VolumeView& volume) {
  std::string blob(kHeaderSize + volume.samples.size_bytes(), '\0');
  const std::uint32_t sizes[] = {volume.nx, volume.ny, volume.nz, volume.channels};
  std::memcpy(blob.data(), kVolumeMagic.data(), kVolumeMagic.size());
  std::memcpy(blob.data() + 8, sizes, sizeof(sizes));
  if (!volume.samples.empty())
    std::memcpy(blob.data() + kHeaderSize, volume.samples.data(), volume.samples.size_bytes());
  return blob;
}

absl::StatusOr<VolumeView> decode_volume(std::string_view blob) {
  if (blob.size() < kHeaderSize || blob.substr(0, kVolumeMagic.size()) != kVolumeMagic)
    return invalid("it does not begin with TSRVOLU1");
  std::uint32_t sizes[4];
  std::memcpy(sizes, blob.data() + 8, sizeof(sizes));
  VolumeView volume{sizes[0], sizes[1], sizes[2], sizes[3], {}};
  if (std::min({sizes[0], sizes[1], sizes[2], sizes[3]}) == 0 ||
      std::max({sizes[0], sizes[1], sizes[2]}) > kMaxSide || volume.channels > kMaxVolumeChannels) {
    return invalid(absl::StrCat("a grid of ", sizes[0], " x ", sizes[1], " x ", sizes[2], " samples with ",
                                sizes[3], " channels"));
  }
  // At most 2^50, so no overflow.
  const std::uint64_t count = std::uint64_t{sizes[0]} * sizes[1] * sizes[2] * sizes[3];
  if (blob.size() - kHeaderSize != count * sizeof(float)) {
    return invalid(absl::StrCat("it has ", blob.size() - kHeaderSize, " bytes of samples instead of ",
                                count * sizeof(float)));
  }
  volume.samples = {reinterpret_cast<const float*>(blob.data() + kHeaderSize),
                    static_cast<std::size_t>(count)};
  if (!std::all_of(volume.samples.begin(), volume.samples.end(), [](float x) { return std::isfinite(x); })) {
    return invalid("a sample is not finite");
  }
  return volume;
}

}  // namespace tessera::wire
