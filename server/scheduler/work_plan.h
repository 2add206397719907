// How a job is cut into units.
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "scheduler/phase_plan.h"
#include "scheduler/tile_order.h"
#include "scheduler/unit_run.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// The pixels and samples that a unit's result covers: those of its tile, or the whole crop for a pass.
v1::TileUnit extent_of(const v1::WorkUnit& unit, const v1::JobSpec& spec);

/// The units of one job: those of its phases, then those of its picture, which are the tiles of its crop (one
/// for all of it, when it works in passes) in each of its views, times its sample ranges. Units are made when
/// asked for, so a plan takes no memory for them. Unit indices ascend in the order in which units are best
/// handed out: of the picture the first sample range of all tiles, view by view and from the middle outwards,
/// then the next range; so a first picture appears early.
class WorkPlan {
 public:
  /// InvalidArgument, by field, for a spec that is unsound or exceeds the caps of wire/limits.h.
  static absl::StatusOr<WorkPlan> make(const v1::JobSpec& spec);

  std::uint32_t unit_count() const { return phases_.unit_count() + tile_count() * range_count_; }
  const PhasePlan& phases() const { return phases_; }
  bool is_of_picture(std::uint32_t unit) const { return unit >= phases_.unit_count(); }

  /// Tiles of all views together.
  std::uint32_t tile_count() const { return tile_order_.count() * views_; }
  /// Tile of a unit of the picture, in the order in which they are handed out.
  std::uint32_t tile_of(std::uint32_t unit) const { return (unit - phases_.unit_count()) % tile_count(); }

  /// Units from `first` on, which is the first of a step, that may be leased together with it.
  std::uint32_t step_end(std::uint32_t first) const {
    return is_of_picture(first) ? unit_count() : phases_.step_end(first);
  }

  /// Same spec and index, same unit. `index` must be below unit_count().
  v1::WorkUnit unit(std::uint32_t index) const { return unit({.first = index}); }

  /// The units of the run as one: its index is that of the first.
  v1::WorkUnit unit(const UnitRun& run) const;

  /// So many units of one tile from `first` on, or none where they are not one node of the sum tree: more
  /// than one are a power of two, begin at a multiple of it, and have whole sample ranges.
  std::optional<UnitRun> run(std::uint32_t first, std::uint32_t count) const;

  /// The longest run that begins with this unit.
  UnitRun longest_run(std::uint32_t first) const;

  /// Whether the unit has the first samples of its tile; units of phases have no tile.
  bool begins_tile(std::uint32_t index) const {
    return is_of_picture(index) && index - phases_.unit_count() < tile_count();
  }

 private:
  WorkPlan() = default;

  PhasePlan phases_;
  v1::PixelRect crop_;
  std::uint32_t views_ = 1;
  bool passes_ = false;
  std::uint32_t tile_size_ = 0;
  std::uint32_t samples_ = 0;
  std::uint32_t samples_per_unit_ = 0;
  std::uint32_t range_count_ = 0;
  TileOrder tile_order_;  // order of the tiles that the crop touches
  std::uint32_t first_column_ = 0, first_row_ = 0;
};

}  // namespace tessera::server
