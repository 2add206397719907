// Request of a render call, and the counts that it returns.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/film/prepared.h"
#include "render/film/stage_times.h"
#include "wire/render_counts.h"

namespace tessera::render {

/// Pixels [x0, x1) x [y0, y1) of the film, sample indices [sample_begin, sample_end) of each.
struct TileRequest {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  std::uint32_t sample_begin = 0, sample_end = 0;
  /// Added to the job's seed: independent images of one scene, for measuring.
  std::uint64_t seed_offset = 0;
  /// Results of the algorithm's phases (RenderScene::prepare); null where it has none.
  const Prepared* prepared = nullptr;
};

/// One of `parts` parts of a phase.
struct PartRequest {
  std::uint32_t phase = 0, part = 0, parts = 1;
  const Prepared* prepared = nullptr;  // made by the phases before; null for the first
  /// Added to the job's seed, as in TileRequest.
  std::uint64_t seed_offset = 0;
};

/// Counts and times of one or more tiles; all add up.
struct RenderStats : wire::RenderCounts {
  std::vector<std::string> warnings;  // 8 a tile at most: which pixel, which sample
  StageTimes times;

  RenderStats& operator+=(const RenderStats& other);
};

}  // namespace tessera::render
