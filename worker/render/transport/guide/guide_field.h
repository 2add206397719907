// Where light comes from, as earlier paths have found: for every cell of space a density of directions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/film/prepared.h"
#include "render/transport/guide/guide_cell.h"
#include "render/transport/guide/guide_density.h"
#include "render/transport/guide/guide_sums.h"

namespace tessera::render::TESSERA_ISA {

/// The guide at 16 points.
struct Guided {
  Mask known;     // there is a density
  Mask followed;  // There is a density, and following it pays.
  Int density;    // number of the density in the field
};

class GuideField final : public Prepared {
 public:
  /// `sums` are those of all phases, their keys ascending. Following a density pays unless the squares of
  /// samples speak against it.
  explicit GuideField(const std::vector<GuideSum>& sums);

  /// Some density is followed.
  bool any_followed() const { return any_followed_; }

  Guided at(const GuideCells& cells, Mask lanes) const;
  /// A direction; `u` in [0, 1)^2. Lanes have to be known.
  Vec3 sample(const Guided& guided, Vec2 u, Mask lanes) const;
  /// Its density, solid angle.
  Float pdf(const Guided& guided, Vec3 w, Mask lanes) const;

 private:
  struct Entry {
    std::uint64_t cell;  // kNoCell: the place is empty
    std::int32_t density;
    bool followed;
  };
  struct Sums;

  void add_density(std::span<const GuideTally> bins);
  void enter(const Sums& sums);

  bool any_followed_ = false;
  std::vector<Entry> entries_;  // open addressing; a power of two
  // Each density's
  std::vector<float> pdf_;      // kGuideBins, 1/sr
  std::vector<float> rows_;     // upper ends of the rows in the unit interval
  std::vector<float> columns_;  // upper ends of each row's bins
};

}  // namespace tessera::render::TESSERA_ISA
