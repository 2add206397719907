#include "render/integrator/mlt/metropolis.h"

#include <algorithm>
#include <cmath>

namespace tessera::render::TESSERA_ISA {

Metropolis::Metropolis(const IntegratorContext& context)
    : scene_(context.scene), seed_(context.seed), eye_(context, 0) {
  if (scene_.max_depth > 0) {
    if (scene_.metropolis.kind == MutationKind::kPrimary) {
      paths_ = std::make_unique<PathMaker>(context);
      chains_ = std::make_unique<Chains>(*paths_, scene_.metropolis, context.stats);
    } else {
      path_chains_ = std::make_unique<PathChains>(context);
    }
  }
  const double pixels = static_cast<double>(scene_.camera.width) * scene_.camera.height;
  const double mutations = static_cast<double>(kChains) * scene_.metropolis.mutations;
  families_ = static_cast<std::uint32_t>(std::max(std::round(pixels / mutations), 1.0));
}

bool Metropolis::run(const FamilyName& name, float share, Film& film, std::stop_token stop) {
  return chains_ ? chains_->run(name, share, film, stop) : path_chains_->run(name, share, film, stop);
}

bool Metropolis::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (!eye_.render(work, film, stop)) return false;
  if (scene_.max_depth == 0) return true;
  const float share = 1.0f / static_cast<float>(families_);
  for (std::uint32_t family = 0; family < families_; ++family) {
    if (!run({seed_, work.pass(), family}, share, film, stop)) return false;
  }
  return true;
}

}  // namespace tessera::render::TESSERA_ISA
