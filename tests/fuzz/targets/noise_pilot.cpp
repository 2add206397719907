// Blobs of pilots, which workers give to others: what is accepted can be planned with, and is written again
// as it was read.
#include <algorithm>

#include "fuzz/target.h"
#include "render/film/noise_pilot.h"
#include "render/film/noise_plan.h"

namespace tessera::fuzz {
namespace {

bool accepts_noise_pilot(std::string_view bytes) {
  const std::vector<char> blob = exact(bytes);
  render::Pilot pilot;
  if (!render::append_pilot_blob({blob.data(), blob.size()}, pilot)) return false;
  require(render::pilot_blob(pilot) == bytes, "a blob that is written otherwise than it was read");
  if (pilot.values.empty()) return true;
  constexpr std::uint32_t kMost = 256;
  const render::SampleCounts plan = render::plan_samples({0.05, kMost}, pilot);
  require(plan.counts.size() == pilot.blocks.pixel_count(), "blocks without counts");
  require(std::ranges::all_of(plan.counts, [](std::uint32_t n) { return n > 0 && n <= kMost; }),
          "a count beyond its bounds");
  return true;
}

}  // namespace

const Target kNoisePilot = {"noise_pilot", accepts_noise_pilot};

}  // namespace tessera::fuzz
