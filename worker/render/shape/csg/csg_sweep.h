// Along one ray, from the spans of the solids to those of what they are combined to.
#pragma once

#include <cstdint>
#include <vector>

#include "render/shape/csg/csg_record.h"

namespace tessera::render::TESSERA_ISA {

/// Where a ray crosses the surface of a solid, inwards or outwards.
struct CsgCrossing {
  double s;  // ray parameter
  std::int32_t solid;
  std::int32_t primitive;  // triangle of a mesh
};

/// The crossings of a ray: in a fixed array, from the first that has no room there on in a growing one.
class CsgCrossings {
 public:
  static constexpr std::size_t kFixed = 32;

  void add(const CsgCrossing& crossing) {
    if (count_ < kFixed) {
      fixed_[count_++] = crossing;
    } else {
      add_to_rest(crossing);
    }
  }
  void add_span(double enter, double leave, std::int32_t solid) {
    add({enter, solid, 0});
    add({leave, solid, 0});
  }
  /// Sorts them, first by place.
  void sort();
  /// Takes all back from the one at `size` on.
  void cut(std::size_t size);
  const CsgCrossing* data() const { return rest_.empty() ? fixed_ : rest_.data(); }
  std::size_t size() const { return count_; }

 private:
  void add_to_rest(const CsgCrossing& crossing);

  std::size_t count_ = 0;
  CsgCrossing fixed_[kFixed];
  std::vector<CsgCrossing> rest_;  // all crossings, once they are more than kFixed
};

/// A crossing of the whole's surface.
struct CsgBorder {
  CsgCrossing at;
  bool enters;
};

/// Follows rays through a tree, one after the other; one sweep at a time in a thread. Crossings that are
/// within `width` of one another are at one place: what matters is whether the ray is inside before and
/// behind all of them, so the result is regularised [Requicha1985].
class CsgSweep {
 public:
  explicit CsgSweep(const CsgRecord& csg);

  void start(const CsgCrossings& crossings, double width);
  /// The next border; false behind the last.
  bool next(CsgBorder& border);
  /// The solid whose material the surface at the border that was found last has.
  std::int32_t material_at(const CsgBorder& border);

 private:
  struct Scratch;

  std::int32_t parent(std::int32_t node) const { return csg_.nodes[static_cast<std::size_t>(node)].parent; }
  bool inside(std::int32_t node);
  void toggle(std::int32_t node);
  bool changed_up_to_root(std::int32_t node);
  std::int32_t first_solid_inside(std::int32_t group);

  const CsgRecord& csg_;
  Scratch& scratch_;
  const CsgCrossing *here_ = nullptr, *end_ = nullptr;
  double width_ = 0;
};

}  // namespace tessera::render::TESSERA_ISA
