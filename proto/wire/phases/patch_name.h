// Names of what gives or takes light in radiosity.
#pragma once

#include <cstdint>

namespace tessera::wire {

/// A side of a triangle: twice the triangle's number, plus 1 for the side that its normal points away from.
using TriangleSide = std::uint32_t;

/// Name of a side or a part of it, or of a cluster of sides. Every machine gives the same names.
class PatchName {
 public:
  static constexpr int kDeepest = 14;  // splits

  PatchName() = default;
  static PatchName of_side(TriangleSide side) { return PatchName(std::uint64_t{side} << 32); }
  static PatchName of_cluster(std::uint32_t cluster) { return PatchName(kCluster | cluster); }
  /// One of a patch's four parts: at its corners, and in the middle.
  PatchName part(unsigned i) const {
    return PatchName((bits_ + (std::uint64_t{1} << 28)) | std::uint64_t{i} << (2 * level()));
  }

  bool is_cluster() const { return (bits_ & kCluster) != 0; }
  std::uint32_t cluster() const { return static_cast<std::uint32_t>(bits_); }
  TriangleSide side() const { return static_cast<TriangleSide>(bits_ >> 32); }
  int level() const { return static_cast<int>(bits_ >> 28 & 15); }  // splits that led to it
  /// Which part was taken by the split that led from `level` on.
  unsigned part_at(int level) const { return static_cast<unsigned>(bits_ >> (2 * level) & 3); }
  std::uint64_t bits() const { return bits_; }

 private:
  static constexpr std::uint64_t kCluster = std::uint64_t{1} << 63;
  explicit PatchName(std::uint64_t bits) : bits_(bits) {}

  std::uint64_t bits_ = 0;
};

}  // namespace tessera::wire
