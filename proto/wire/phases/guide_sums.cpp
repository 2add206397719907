#include "wire/phases/guide_sums.h"

#include <cstring>

#include "wire/phases/blob_arrays.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

namespace {

constexpr std::uint64_t kMostOfSample = static_cast<std::uint64_t>(kMostGuideValue * kGuideUnit);
constexpr int kGuideSides = 6;

bool is_sound_sum(const GuideSum& sum) {
  using namespace guide_key;
  const std::uint64_t top = cell_of(sum.key) >> (3 * kPlaceBits);
  return bin_of(sum.key) < kGuideBins + kSquareSums && (top & ((1u << kSideBits) - 1)) < kGuideSides &&
         top >> kSideBits >> kExponentBits == 0 && sum.count > 0 &&
         (sum.value == 0 || (sum.value - 1) / kMostOfSample < sum.count);
}

std::uint64_t most_guide_bytes(const PhaseBlob& blob) {
  return blob.part_count() * kMostGuideSums * sizeof(GuideSum);
}

}  // namespace

std::string guide_blob(const std::vector<GuideSum>& sorted) {
  std::string blob(sorted.size() * sizeof(GuideSum), '\0');
  if (!sorted.empty()) std::memcpy(blob.data(), sorted.data(), blob.size());
  return blob;
}

std::optional<std::string_view> read_guide_sums(std::string_view blob) {
  if (blob.size() % sizeof(GuideSum) != 0) return std::nullopt;
  std::uint64_t last = 0;
  bool first = true;
  const bool sound = all_in_bytes<GuideSum>(blob, [&](const GuideSum& sum) {
    const bool ascends = first || sum.key > last;
    first = false, last = sum.key;
    return ascends && is_sound_sum(sum);
  });
  return sound ? std::optional(blob) : std::nullopt;
}

bool append_guide_blob(std::string_view blob, std::vector<GuideSum>& sums) {
  const std::optional<std::string_view> bytes = read_guide_sums(blob);
  if (bytes) append_values(*bytes, sums);
  return bytes.has_value();
}

const PhaseBlobCheck kGuideSumsCheck{most_guide_bytes,
                                     [](std::string_view bytes, const PhaseBlob&) -> const char* {
                                       return read_guide_sums(bytes) ? nullptr : "no sums of a guide";
                                     }};

}  // namespace tessera::wire
