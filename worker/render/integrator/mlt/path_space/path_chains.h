// Markov chains of paths, changed vertex by vertex [Veach & Guibas 1997; Veach 1997, chapter 11].
//
// Families, their candidates and what they bring are those of mlt/chains.h. In a step, all chains of a family
// are changed by the same strategy, whatever their paths are: where it does not apply, a chain stays.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/integrator/mlt/chain_splats.h"
#include "render/integrator/mlt/chains.h"
#include "render/integrator/mlt/path_space/grower.h"
#include "render/integrator/mlt/path_space/mutations.h"

namespace tessera::render::TESSERA_ISA {

class PathChains {
 public:
  explicit PathChains(const IntegratorContext& context);

  /// Like Chains::run().
  bool run(const FamilyName& name, float share, Film& film, std::stop_token stop);

 private:
  struct Chain {
    ExplicitPath path;
    float weight = 0;  // of its path, gathered while it stays there
  };

  Growth candidate(std::uint32_t index, ExplicitPath& path) const;
  double candidate_density(const ExplicitPath& path) const;
  double make_candidates(std::stop_token stop);
  void start_chains(double light);
  /// The family's in the step whose numbers begin at this one.
  Strategy strategy_of(std::uint32_t number) const;
  void change(Strategy strategy, int first, std::uint32_t first_number, Film& film);
  void decide(Chain& chain, const ExplicitPath& offered, float accepted, float u);
  void splat(const ExplicitPath& path, float weight) {
    splats_.add(path.film_x, path.film_y, path.light, path.luminance, weight);
  }

  const SceneTables& scene_;
  const MetropolisConfig config_;
  RenderStats& stats_;
  const Mutations mutations_;
  const DepthChoice depths_;
  const std::vector<Strategy> strategies_;
  Grower grower_;

  std::uint32_t key_ = 0;  // of the family's numbers
  std::vector<double> candidate_light_;
  std::vector<Chain> chains_;
  std::vector<ExplicitPath> offered_;
  std::vector<Growth> growths_;
  std::vector<int> changed_;  // chains that the growths belong to
  ChainSplats splats_;
};

}  // namespace tessera::render::TESSERA_ISA
