#include "import/mitsuba/matter/volume_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "import/input/concat.h"
#include "wire/volume_blob.h"

namespace tessera::client::mitsuba {
namespace {

static_assert(std::endian::native == std::endian::little, "samples are read in place");

constexpr std::size_t kHeaderBytes = 48;
constexpr std::uint32_t kMaxSize = 65536;  // of a volume blob
constexpr std::uint32_t kMaxChannels = 4;

template <typename T>
T load(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

absl::Status fail(std::string message) { return absl::InvalidArgumentError(std::move(message)); }

}  // namespace

absl::StatusOr<VolumeFile> read_volume_file(std::string_view bytes) {
  if (!bytes.starts_with("VOL")) return fail("not a volume: it does not begin with \"VOL\"");
  if (bytes.size() < kHeaderBytes) return fail("the volume is cut off in its header");
  const int version = bytes[3];
  if (version != 3) return fail(concat("volume format version ", version, ": expected 3"));
  const std::uint32_t encoding = load<std::uint32_t>(bytes, 4);
  if (encoding != 1) return fail(concat("volume encoding ", encoding, ": expected 1, 32-bit floats"));
  VolumeFile file;
  std::uint64_t count = 1;
  for (int a = 0; a < 3; ++a) {
    file.size[a] = load<std::uint32_t>(bytes, 8 + 4 * a);
    if (file.size[a] < 1 || file.size[a] > kMaxSize)
      return fail(concat("a side of ", file.size[a], " samples"));
    count *= file.size[a];
  }
  file.channels = load<std::uint32_t>(bytes, 20);
  if (file.channels < 1 || file.channels > kMaxChannels)
    return fail(concat(file.channels, " channels: expected 1 or 3"));
  count *= file.channels;
  for (int a = 0; a < 3; ++a) {
    file.box_min[a] = load<float>(bytes, 24 + 4 * a);
    file.box_max[a] = load<float>(bytes, 36 + 4 * a);
  }
  if (count > (bytes.size() - kHeaderBytes) / sizeof(float)) {
    return fail(concat("the volume is cut off: ", count, " samples do not fit in ", bytes.size(), " bytes"));
  }
  std::vector<float> samples(count);
  std::memcpy(samples.data(), bytes.data() + kHeaderBytes, count * sizeof(float));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!std::isfinite(samples[i])) return fail(concat("sample ", i, " is not finite"));
  }
  file.blob = wire::encode_volume({file.size[0], file.size[1], file.size[2], file.channels, samples});
  return file;
}

}  // namespace tessera::client::mitsuba
