// Counts of the renderer: declared here once, and as a field of the same name of UnitStats (job.proto).
// Sums, messages, the journal and the tables of statistics follow.
#pragma once

#include <array>
#include <cstdint>
#include <variant>

namespace tessera::wire {

/// Counts of one unit or more; all add up.
struct RenderCounts {
  std::uint64_t samples = 0;
  std::uint64_t camera_rays = 0;
  std::uint64_t bounce_rays = 0;
  std::uint64_t shadow_rays = 0;
  // Not finite or beyond what a pixel can sum (render/film/summable.h); counted as black.
  std::uint64_t dropped_samples = 0;
  // Samples far brighter than those around them (render/integrator/fireflies.h), and luminance summed over
  // them and over all.
  std::uint64_t fireflies = 0;
  double firefly_light = 0;
  double light = 0;
  // Paths that Markov chains were offered, and those of them that became their next state.
  std::uint64_t mutations = 0;
  std::uint64_t accepted_mutations = 0;

  std::uint64_t rays() const { return camera_rays + bounce_rays + shadow_rays; }
  inline RenderCounts& operator+=(const RenderCounts& other);
};

struct RenderCount {
  const char* name;  // name of the field of UnitStats
  std::variant<std::uint64_t RenderCounts::*, double RenderCounts::*> member;
  bool of_image = false;  // describes the image; else what it cost
};

inline constexpr std::array kRenderCounts{
    RenderCount{"samples", &RenderCounts::samples},
    RenderCount{"camera_rays", &RenderCounts::camera_rays},
    RenderCount{"bounce_rays", &RenderCounts::bounce_rays},
    RenderCount{"shadow_rays", &RenderCounts::shadow_rays},
    RenderCount{"dropped_samples", &RenderCounts::dropped_samples, true},
    RenderCount{"fireflies", &RenderCounts::fireflies, true},
    RenderCount{"firefly_light", &RenderCounts::firefly_light, true},
    RenderCount{"light", &RenderCounts::light, true},
    RenderCount{"mutations", &RenderCounts::mutations},
    RenderCount{"accepted_mutations", &RenderCounts::accepted_mutations},
};
static_assert(sizeof(RenderCounts) == 8 * kRenderCounts.size(), "every member has its row");

inline RenderCounts& RenderCounts::operator+=(const RenderCounts& other) {
  for (const RenderCount& count : kRenderCounts) {
    std::visit([&](auto member) { this->*member += other.*member; }, count.member);
  }
  return *this;
}

/// Returns the counts that describe the image; the others are 0.
inline RenderCounts of_image(const RenderCounts& counts) {
  RenderCounts image;
  for (const RenderCount& count : kRenderCounts) {
    if (count.of_image) std::visit([&](auto member) { image.*member = counts.*member; }, count.member);
  }
  return image;
}

}  // namespace tessera::wire
