// Markov chains in primary sample space, a family of short ones at a time [Kelemen et al. 2002; Hachisuka,
// Kaplanyan & Dachsbacher 2014].
//
// A family is named by a seed, a pass and a number, and knows nothing of others. It begins with candidates:
// independent paths, of which its chains' starts are picked, each as likely as it is bright. What is found on
// the way counts with the candidates' mean brightness. That is unbiased for chains of any length and any
// number of candidates: there is no start-up to be thrown away [Veach 1997, section 11.3.1].
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/film/film.h"
#include "render/film/tile_request.h"
#include "render/integrator/integrator_settings.h"
#include "render/transport/mlt/primary_space.h"

namespace tessera::render::TESSERA_ISA {

/// Chains of a family: so many that sixteen that are shaded together mostly have the same way.
inline constexpr int kChains = 256;

struct FamilyName {
  std::uint64_t seed;
  std::uint32_t pass, number;
};

/// Probabilities of how many scattering events a candidate has: of n that of 1 / ((n + 2) (n + 3)), so that
/// all depths have candidates, and few are long.
class DepthChoice {
 public:
  explicit DepthChoice(int max_events)
      : most_(max_events), scale_(1 / (1.0 / 3 - 1.0 / (max_events + 3.0))) {}

  double probability(int events) const { return scale_ / ((events + 2.0) * (events + 3.0)); }
  struct Choice {
    int events;
    float rest;  // rest of u, uniform in [0, 1)
  };
  /// `u` is in [0, 1).
  Choice choose(double u) const;

 private:
  /// Probability of as many events or fewer.
  double up_to(int events) const { return scale_ * (1.0 / 3 - 1.0 / (events + 3.0)); }

  const int most_;
  const double scale_;
};

class Chains {
 public:
  Chains(PathSpace& space, const MetropolisSettings& config, RenderStats& stats);

  /// Runs a family: adds its estimate of all light that paths of one event and more bring to the film, times
  /// `share`. False when it was stopped before the end.
  bool run(const FamilyName& name, float share, Film& film, std::stop_token stop);

 private:
  /// The bands of the film that a path brings light to, lane by lane, -1 where there is none; where lanes are
  /// wavelengths.
  struct BandLight {
#ifdef TESSERA_SPECTRAL
    std::int32_t band[kSpectrumLanes];
    float light[kSpectrumLanes];
#endif
  };
  /// A path, as far as it does not lie in its coordinates.
  struct Path {
    int events, from_light;
    float way;             // coordinate that from_light follows from
    std::uint32_t number;  // number of the chain among the random numbers of family_key_
    float x, y;
    float light[kResponseChannels];
    [[no_unique_address]] BandLight bands;
    float brightness;
  };
  struct Chain : Path {
    float weight = 0;  // weight of its path, gathered while the chain stays there
  };
  /// Offers to each chain.
  struct alignas(64) Offers {
    float way[kChains], accept[kChains];
    std::int32_t from_light[kChains], large[kChains];
    std::uint32_t number[kChains];
  };

  double make_candidates(const FamilyName& name, std::stop_token stop);
  void start_chains(double light);
  void materialize(int chain);
  void offer(std::uint32_t step);
  void sort();
  void propose(int first, int count);
  void propose(int place, int packet, Int chain, const Sampler& numbers, Mask lanes, Mask kept);
  void decide(int first, int count, Film& film);
  void keep(int chain, int slot);
  void make();
  void find_bands(int slot, const Wavelengths& wavelengths, const Channels& channels);
  Path made(int slot, const Path& asked) const;
  void splat(const Path& path, float weight);
  void splat_bands(const Path& path, float scale);
  void flush(Film& film);

  PathSpace& space_;
  const Response& response_;
  const MetropolisSettings config_;
  RenderStats& stats_;
  const DepthChoice depths_;
  bool asks_for_[kPlacesPerEvent];
  const float largest_step_, log_ratio_;  // largest small step; logarithm of the least one over the largest

  std::uint32_t family_key_ = 0;  // key of the family's random numbers
  float scale_ = 0;               // factor of the light that a chain finds in a step
  std::vector<Path> candidates_;
  std::vector<double> candidate_light_;
  std::vector<Chain> chains_;
  std::size_t stride_ = 0;                // floats of a chain's coordinates
  std::vector<float> chain_coordinates_;  // two for each place of each chain
  Offers offers_;
  alignas(64) std::int32_t order_[kChains];
  std::vector<int> first_of_way_;
  PathBatch batch_{};
  // Channels and brightness of the batch's light
  alignas(64) float channels_[kResponseChannels][kSubpaths], brightness_[kSubpaths];
  BandLight bands_[kSubpaths] = {};
  std::vector<Splat> splats_;
  std::vector<BandSplat> band_splats_;
};

}  // namespace tessera::render::TESSERA_ISA
