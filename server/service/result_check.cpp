#include "service/result_check.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

template <typename T>
std::string_view bytes_of(const std::vector<T>& words) {
  return {reinterpret_cast<const char*>(words.data()), words.size() * sizeof(T)};
}

}  // namespace

absl::StatusOr<std::string> check_result(std::string_view payload, std::uint32_t index, const v1::TileUnit& extent,
                                         const std::vector<wire::ChannelDesc>& channels) {
  const v1::PixelRect& pixels = extent.pixels();
  const v1::SampleRange& samples = extent.samples();
  const std::size_t pixel_count = std::size_t{pixels.x1() - pixels.x0()} * (pixels.y1() - pixels.y0());
  const absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(payload, pixel_count, channels.size());
  if (!result.ok()) return result.status();

  const auto unfit = [&](const char* what) {
    return absl::InvalidArgumentError(absl::StrCat("result of unit ", index, ": ", what));
  };
  if (result->x0 != pixels.x0() || result->y0 != pixels.y0() || result->x1 != pixels.x1() ||
      result->y1 != pixels.y1()) {
    return unfit("its rectangle is not the unit's");
  }
  if (result->sample_begin != samples.begin() || result->sample_end != samples.end()) {
    return unfit("its sample range is not the unit's");
  }
  if (result->channels != channels) return unfit("its channels are not the job's");
  const std::uint32_t most = samples.end() - samples.begin();
  if (std::any_of(result->counts.begin(), result->counts.end(), [&](std::uint32_t n) { return n > most; })) {
    return unfit("a pixel counts more samples than the range has");
  }

  // The renderer drops samples that are no numbers, and counts them: one that gets this far was made by a fault.
  for (std::size_t c = 0; c < result->channels.size(); ++c) {
    if (result->channels[c].kind != wire::ChannelKind::kSum) continue;
    const auto plane = result->values.begin() + static_cast<std::ptrdiff_t>(c * pixel_count);
    if (std::any_of(plane, plane + static_cast<std::ptrdiff_t>(pixel_count), [](float x) { return std::isnan(x); })) {
      return unfit(absl::StrCat("channel ", result->channels[c].name, " holds a NaN").c_str());
    }
  }

  wire::Sha256 sha;
  sha.update(bytes_of(result->counts));
  sha.update(bytes_of(result->values));
  return sha.finish_hex();
}

ResultFingerprint fingerprint_of(const std::string& digest) { return std::stoull(digest.substr(0, 16), nullptr, 16); }

}  // namespace tessera::server
