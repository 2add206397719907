// Sums of what paths found, as they are collected and added up.
#pragma once

#include <cstdint>
#include <vector>

#include "wire/phases/guide_sums.h"

namespace tessera::render::TESSERA_ISA {

using wire::append_guide_blob;
using wire::guide_blob;
using wire::GuideSum;
using wire::kGuideUnit;
using wire::kMostGuideValue;

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

/// Adds up neighbours with the same key; ascending.
std::vector<GuideSum> added_up(std::vector<GuideSum> sums);

}  // namespace tessera::render::TESSERA_ISA
