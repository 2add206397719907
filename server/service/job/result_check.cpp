#include "service/job/result_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "absl/strings/str_cat.h"
#include "scheduler/work_plan.h"
#include "wire/algorithm.h"
#include "wire/digest.h"
#include "wire/job_check.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

template <typename T>
std::string_view bytes_of(const std::vector<T>& words) {
  return {reinterpret_cast<const char*>(words.data()), words.size() * sizeof(T)};
}

// A renderer drops samples beyond 1e15, and filters weigh them by 4 at most (worker/render/film/summable.h);
// the rest is for the rounding of sums.
constexpr double kLargestSample = 1.01 * 4e15;

/// Names what is wrong with the numbers of samples of a unit of `samples` samples a pixel; null when nothing
/// is.
const char* check_counts(const std::vector<std::uint32_t>& counts, std::uint32_t samples, bool adaptive) {
  const std::uint32_t least = adaptive ? std::min(wire::kLeastNoiseSamples, samples) : samples;
  for (const std::uint32_t count : counts) {
    if (count > samples) return "a pixel counts more samples than the range has";
    if (count < least) return "a pixel counts fewer samples than the job asks for";
  }
  return nullptr;
}

/// Names what is wrong with the values of one channel; null when nothing is.
const char* check_values(std::span<const float> values, wire::ChannelKind kind, double most) {
  for (const float value : values) {
    if (!std::isfinite(value)) return "a value that is not finite";
    if (kind == wire::ChannelKind::kSquaredDeviation ? value < 0 : std::abs(double{value}) > most) {
      return "a value that no samples add up to";
    }
  }
  return nullptr;
}

absl::StatusOr<wire::TileResult> checked_result(std::string_view payload, const v1::WorkUnit& unit,
                                                const v1::JobSpec& spec,
                                                const std::vector<wire::ChannelDesc>& channels) {
  const v1::TileUnit extent = extent_of(unit, spec);
  const v1::PixelRect& pixels = extent.pixels();
  const v1::SampleRange& samples = extent.samples();
  const std::size_t pixel_count = std::size_t{pixels.x1() - pixels.x0()} * (pixels.y1() - pixels.y0());
  const absl::StatusOr<wire::TileResult> result =
      wire::decode_tile_result(payload, pixel_count, channels.size());
  if (!result.ok()) return result.status();

  const auto unfit = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("result of unit ", unit.index(), ": ", what));
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
  if (const char* const what = check_counts(result->counts, most, spec.samples().noise() > 0))
    return unfit(what);

  // Any number of samples of a pass may land on one pixel.
  const double largest_sum = wire::works_in_passes(spec) ? std::numeric_limits<float>::max()
                                                         : kLargestSample * static_cast<double>(most);
  for (std::size_t c = 0; c < result->channels.size(); ++c) {
    const std::span plane = std::span(result->values).subspan(c * pixel_count, pixel_count);
    if (const char* const what = check_values(plane, result->channels[c].kind, largest_sum)) {
      return unfit(absl::StrCat("channel ", result->channels[c].name, " holds ", what));
    }
  }

  return result;
}

std::string digest_of(const wire::TileResult& result) {
  wire::Sha256 sha;
  sha.update(bytes_of(result.counts));
  sha.update(bytes_of(result.values));
  return sha.finish_hex();
}

/// Digest of the result that these of its pixels are.
std::string digest_of_part(const wire::TileResult& result, const v1::PixelRect& part) {
  const std::size_t width = result.x1 - result.x0, pixels = width * (result.y1 - result.y0);
  const std::size_t left = part.x0() - result.x0, columns = part.x1() - part.x0();
  wire::Sha256 sha;
  const auto add_rows = [&](const auto& values, std::size_t plane) {
    using Value = std::decay_t<decltype(values[0])>;
    for (std::size_t y = part.y0() - result.y0; y < part.y1() - result.y0; ++y) {
      const Value* const row = values.data() + plane * pixels + y * width + left;
      sha.update({reinterpret_cast<const char*>(row), columns * sizeof(Value)});
    }
  };
  add_rows(result.counts, 0);
  for (std::size_t plane = 0; plane < result.channels.size(); ++plane) add_rows(result.values, plane);
  return sha.finish_hex();
}

}  // namespace

absl::StatusOr<std::string> check_result(std::string_view payload, const v1::WorkUnit& unit,
                                         const v1::JobSpec& spec,
                                         const std::vector<wire::ChannelDesc>& channels) {
  const absl::StatusOr<wire::TileResult> result = checked_result(payload, unit, spec, channels);
  if (!result.ok()) return result.status();
  return digest_of(*result);
}

absl::StatusOr<CheckedResult> check_result_and_part(std::string_view payload, const v1::WorkUnit& unit,
                                                    const v1::JobSpec& spec,
                                                    const std::vector<wire::ChannelDesc>& channels,
                                                    const v1::PixelRect& part) {
  const absl::StatusOr<wire::TileResult> result = checked_result(payload, unit, spec, channels);
  if (!result.ok()) return result.status();
  return CheckedResult{.digest = digest_of(*result), .part = digest_of_part(*result, part)};
}

ResultFingerprint fingerprint_of(const std::string& digest) {
  return std::stoull(digest.substr(0, 16), nullptr, 16);
}

}  // namespace tessera::server
