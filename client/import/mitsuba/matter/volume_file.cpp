#include "import/mitsuba/matter/volume_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "import/input/concat.h"
#include "import/input/load_bytes.h"
#include "wire/volume_blob.h"

namespace tessera::client::mitsuba {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are read in place");

constexpr std::size_t kHeaderBytes = 48;
constexpr std::uint32_t kMaxSize = 65536;  // limit of a volume blob
constexpr std::uint32_t kMaxChannels = 4;

}  // namespace

absl::StatusOr<VolumeFile> read_volume_file(std::string_view bytes) {
  if (!bytes.starts_with("VOL"))
    return absl::InvalidArgumentError("not a volume: it does not begin with \"VOL\"");
  if (bytes.size() < kHeaderBytes) return absl::InvalidArgumentError("the volume is cut off in its header");
  const int version = bytes[3];
  if (version != 3)
    return absl::InvalidArgumentError(concat("volume format version ", version, ": expected 3"));
  const std::uint32_t encoding = load_bytes<std::uint32_t>(bytes, 4);
  if (encoding != 1)
    return absl::InvalidArgumentError(concat("volume encoding ", encoding, ": expected 1, 32-bit floats"));
  VolumeFile file;
  std::uint64_t count = 1;
  for (int a = 0; a < 3; ++a) {
    file.size[a] = load_bytes<std::uint32_t>(bytes, 8 + 4 * a);
    if (file.size[a] < 1 || file.size[a] > kMaxSize)
      return absl::InvalidArgumentError(concat("a side of ", file.size[a], " samples"));
    count *= file.size[a];
  }
  file.channels = load_bytes<std::uint32_t>(bytes, 20);
  if (file.channels < 1 || file.channels > kMaxChannels)
    return absl::InvalidArgumentError(concat(file.channels, " channels: expected 1 or 3"));
  count *= file.channels;
  for (int a = 0; a < 3; ++a) {
    file.box_min[a] = load_bytes<float>(bytes, 24 + 4 * a);
    file.box_max[a] = load_bytes<float>(bytes, 36 + 4 * a);
  }
  if (count > (bytes.size() - kHeaderBytes) / sizeof(float)) {
    return absl::InvalidArgumentError(
        concat("the volume is cut off: ", count, " samples do not fit in ", bytes.size(), " bytes"));
  }
  std::vector<float> samples(count);
  std::memcpy(samples.data(), bytes.data() + kHeaderBytes, count * sizeof(float));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!std::isfinite(samples[i])) return absl::InvalidArgumentError(concat("sample ", i, " is not finite"));
  }
  file.blob = wire::encode_volume({file.size[0], file.size[1], file.size[2], file.channels, samples});
  return file;
}

}  // namespace tessera::client::mitsuba
