#include "render/transport/mlt/metropolis.h"

#include <algorithm>
#include <cmath>

#include "render/integrator/algorithm_list.h"
#include "render/transport/vertex/ghost_light.h"

namespace tessera::render::TESSERA_ISA {

Metropolis::Metropolis(const IntegratorContext& context)
    : scene_(context.scene),
      seed_(context.seed),
      eye_(context, 0),
      paths_(context),
      chains_(paths_, context.scene.metropolis, context.stats) {
  const double pixels = static_cast<double>(scene_.sensor.width) * scene_.sensor.height;
  const double mutations = static_cast<double>(kChains) * scene_.metropolis.mutations;
  families_ = static_cast<std::uint32_t>(std::max(std::round(pixels / mutations), 1.0));
}

bool Metropolis::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (!eye_.render(work, film, stop)) return false;
  if (scene_.max_depth == 0) return true;
  const float share = 1.0f / static_cast<float>(families_);
  for (std::uint32_t family = 0; family < families_; ++family) {
    if (!chains_.run({seed_, work.pass(), family}, share, film, stop)) return false;
  }
  return true;
}

const ListedAlgorithm mlt{{"mlt", &make_with_ghost_light<Metropolis>}};

}  // namespace tessera::render::TESSERA_ISA
