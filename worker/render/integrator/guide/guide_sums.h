// Sums of what paths found, in integers: added in any order, by any number of workers, they have the same
// bits.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::render::TESSERA_ISA {

/// A number of samples and the sum of their values, in units of 1 / kGuideUnit. Sums stop at the largest
/// number, so that their order does not matter there either.
struct GuideSum {
  std::uint64_t key;  // guide_cell.h
  std::uint64_t value;
  std::uint64_t count;

  bool operator==(const GuideSum&) const = default;
};

inline constexpr double kGuideUnit = 1 << 20;
/// Most of a single value: brighter samples count as this, so that one alone does not make a distribution.
inline constexpr double kMostGuideValue = 1 << 16;

/// `value`, which is not negative, as sums have it; 0 where it is not a number.
std::uint64_t guide_value(double value);

/// Sums by their keys; of keys that are new, no more than `most` are taken.
class GuideSums {
 public:
  explicit GuideSums(std::size_t most);

  void add(std::uint64_t key, std::uint64_t value, std::uint64_t count = 1);
  /// In ascending order of their keys.
  std::vector<GuideSum> sorted() const;

 private:
  void grow();
  std::size_t place_of(std::uint64_t key) const;

  const std::size_t most_;
  std::size_t size_ = 0;
  std::vector<GuideSum> table_;  // open addressing; a count of 0 is an empty place
};

std::string guide_blob(const std::vector<GuideSum>& sorted);
/// Appends the sums of a blob. False where it is none: their keys ascend, and their counts are not 0.
bool append_guide_blob(std::string_view blob, std::vector<GuideSum>& sums);
/// Adds up neighbours with the same key; ascending.
std::vector<GuideSum> added_up(std::vector<GuideSum> sums);

}  // namespace tessera::render::TESSERA_ISA
