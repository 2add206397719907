// Sums of what paths found of where light comes from: of the phases of path guiding. They are integers: added
// in any order, by any number of workers, they have the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::wire {

/// Directions are told apart in so many rows of as many.
inline constexpr int kGuideRows = 16;
inline constexpr int kGuideBins = kGuideRows * kGuideRows;
namespace guide_key {
// From the least bit on: bin, z, y, x, side, exponent.
inline constexpr int kBinBits = 12, kPlaceBits = 12, kSideBits = 3, kExponentBits = 9;
inline constexpr std::int32_t kMiddle = 1 << (kPlaceBits - 1), kExponentMiddle = 1 << (kExponentBits - 1);

/// The bins of a cell are followed by two sums of squares of samples: as they would be if the BSDF alone were
/// sampled, and if the guide were followed with kGuideFraction.
inline constexpr std::uint64_t kSquares = kGuideBins;
inline constexpr int kSquareSums = 2;
static_assert(kGuideBins + kSquareSums <= 1 << kBinBits);

inline std::uint64_t cell(std::int32_t exponent, std::int32_t x, std::int32_t y, std::int32_t z,
                          std::int32_t side) {
  const auto part = [](std::int32_t i) { return static_cast<std::uint64_t>(i + kMiddle); };
  std::uint64_t key =
      static_cast<std::uint64_t>(exponent + kExponentMiddle) << kSideBits | static_cast<std::uint64_t>(side);
  key = (key << kPlaceBits | part(x)) << kPlaceBits | part(y);
  return key << kPlaceBits | part(z);
}
inline std::uint64_t with_bin(std::uint64_t cell, std::uint64_t bin) { return cell << kBinBits | bin; }
inline std::uint64_t cell_of(std::uint64_t key) { return key >> kBinBits; }
inline int bin_of(std::uint64_t key) { return static_cast<int>(key & ((1u << kBinBits) - 1)); }
/// The cell of twice the side that holds this one.
inline std::uint64_t parent(std::uint64_t key) {
  const auto part = [&](int shift) {
    return (static_cast<std::int32_t>(key >> shift & ((1u << kPlaceBits) - 1)) - kMiddle) >> 1;
  };
  const std::uint64_t top = key >> (3 * kPlaceBits);
  const auto side = static_cast<std::int32_t>(top & ((1u << kSideBits) - 1));
  const auto exponent = static_cast<std::int32_t>(top >> kSideBits) - kExponentMiddle;
  return cell(exponent + 1, part(2 * kPlaceBits), part(kPlaceBits), part(0), side);
}
}  // namespace guide_key

/// A number of samples and the sum of their values, in units of 1 / kGuideUnit. Sums stop at the largest
/// number, so that their order does not matter there either.
struct GuideSum {
  std::uint64_t key;  // key of a bin of a cell
  std::uint64_t value;
  std::uint64_t count;

  bool operator==(const GuideSum&) const = default;
};

inline constexpr double kGuideUnit = 1 << 20;
/// Most of a single value: brighter samples count as this, so that one alone does not make a distribution.
inline constexpr double kMostGuideValue = 1 << 16;
/// Most sums of a part: 24 MiB.
inline constexpr std::size_t kMostGuideSums = std::size_t{1} << 20;

std::string guide_blob(const std::vector<GuideSum>& sorted);
/// The bytes of a blob's sums. Absent where it is none: keys are those of bins and ascend, counts are not 0,
/// and no value is larger than so many samples add up to.
std::optional<std::string_view> read_guide_sums(std::string_view blob);
/// Appends the sums of a blob. False, and nothing appended, where it is none.
bool append_guide_blob(std::string_view blob, std::vector<GuideSum>& sums);

}  // namespace tessera::wire
