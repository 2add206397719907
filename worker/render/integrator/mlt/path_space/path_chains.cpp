#include "render/integrator/mlt/path_space/path_chains.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

namespace {

// Pairs of a proposal's numbers that are none of the sampler's dimensions.
constexpr int kStrategy = 1 << 29;
constexpr int kPick = kStrategy + 1;
constexpr int kDepth = kStrategy + 2;
constexpr int kKeptAndAdded = kStrategy + 3;
constexpr int kWayAndAcceptance = kStrategy + 4;

/// One proposal's numbers.
class Numbers {
 public:
  Numbers(std::uint32_t key, std::uint32_t number)
      : sampler_(SamplerKind::kIndependent, UInt(key), UInt(number)) {}

  struct Pair {
    float x, y;
  };
  Pair operator()(int pair) const {
    const Vec2 u = sampler_.get_2d(pair);
    return {u.x.lane(0), u.y.lane(0)};
  }
  ProposalNumbers of_proposal() const {
    const Pair lengths = (*this)(kKeptAndAdded), film = (*this)(dimension::kFilm),
               lens = (*this)(dimension::kLens);
    return {lengths.x, lengths.y, (*this)(kWayAndAcceptance).x, film.x, film.y, lens.x, lens.y};
  }

 private:
  const Sampler sampler_;
};

}  // namespace

PathChains::PathChains(const IntegratorContext& context)
    : scene_(context.scene),
      config_(context.scene.metropolis),
      stats_(context.stats),
      mutations_(context.scene),
      depths_(mutations_.max_events()),
      strategies_(Mutations::strategies_of(config_.kind)),
      grower_(context),
      chains_(kChains),
      offered_(kSubpaths) {}

bool PathChains::run(const FamilyName& name, float share, Film& film, std::stop_token stop) {
  key_ = Sampler::pixel_hash(name.seed, UInt(name.pass), UInt(name.number)).lane(0);
  const double light = make_candidates(stop);
  if (stop.stop_requested()) return false;
  if (!(light > 0)) return true;  // no candidate has found any: an estimate like others
  start_chains(light);
  const double mean = light / static_cast<double>(candidate_light_.size());
  splats_.set_scale(static_cast<float>(mean / kChains / config_.mutations * share));
  for (std::uint32_t step = 0; step < config_.mutations; ++step) {
    if (stop.stop_requested()) return false;
    const std::uint32_t first_number =
        static_cast<std::uint32_t>(candidate_light_.size()) + step * static_cast<std::uint32_t>(kChains);
    const Strategy strategy = strategy_of(first_number);
    for (int first = 0; first < kChains; first += kSubpaths) change(strategy, first, first_number, film);
  }
  for (const Chain& chain : chains_) splat(chain.path, chain.weight);
  splats_.flush(film);
  return true;
}

/// One half are paths from the camera that go on until they meet a light: one of them is a sample of all
/// lengths at once. Others are one in each of as many strata, by depth and then by way.
Growth PathChains::candidate(std::uint32_t index, ExplicitPath& path) const {
  const Numbers numbers(key_, index);
  path.time = scene_.any_motion ? numbers(dimension::kTime).x : 0;
  Growth growth{.path = &path, .number = index};
  const auto half = static_cast<std::uint32_t>(candidate_light_.size() / 2);
  if (index < half) {
    growth.until_light = true;
    path.events = mutations_.max_events();
    growth.from_eye = path.events + 1;
  } else {
    const DepthChoice::Choice choice =
        depths_.choose((index - half + static_cast<double>(numbers(kDepth).x)) / half);
    path.events = choice.events;
    const int ways = choice.events + 2;
    growth.from_light = std::min(static_cast<int>(choice.rest * static_cast<float>(ways)), ways - 1);
    growth.from_eye = choice.events + 1 - growth.from_light;
  }
  mutations_.place_on_film(numbers.of_proposal(), growth);
  return growth;
}

/// Over the density of all ways together: the balance heuristic [Veach 1997, section 9.2.2].
double PathChains::candidate_density(const ExplicitPath& path) const {
  const double of_ways = density_of_ways(path, {}) / (path.events + 2) * depths_.probability(path.events);
  return 0.5 * (density_until_light(path) + of_ways);
}

/// Returns the sum of all candidates' light.
double PathChains::make_candidates(std::stop_token stop) {
  candidate_light_.assign(static_cast<std::size_t>(kChains) * config_.candidates, 0.0);
  double sum = 0;
  for (std::size_t first = 0; first < candidate_light_.size() && !stop.stop_requested(); first += kSubpaths) {
    growths_.clear();
    {
      const StageTimer timer(stats_.times, Stage::kCamera);
      for (std::size_t i = 0; i < kSubpaths; ++i)
        growths_.push_back(candidate(static_cast<std::uint32_t>(first + i), offered_[i]));
    }
    grower_.grow(growths_, key_);
    for (std::size_t i = 0; i < kSubpaths; ++i) {
      const ExplicitPath& path = offered_[i];
      if (!(path.brightness > 0)) continue;
      const double light = path.brightness / candidate_density(path);
      if (std::isfinite(light)) sum += candidate_light_[first + i] = light;
    }
  }
  return sum;
}

void PathChains::start_chains(double light) {
  // Systematic resampling: as many chains begin at a candidate as its part of the light says, or one more or
  // less.
  const double u = static_cast<double>(Numbers(key_, 0)(kPick).x);
  std::size_t candidate_index = 0;
  double sum = candidate_light_[0];
  growths_.clear();
  for (int i = 0; i < kChains; ++i) {
    const double at = (i + u) / kChains * light;
    while (candidate_index + 1 < candidate_light_.size() && !(sum > at))
      sum += candidate_light_[++candidate_index];
    // Rounding may lead beyond the last that has any.
    while (candidate_light_[candidate_index] == 0) --candidate_index;
    Chain& chain = chains_[static_cast<std::size_t>(i)];
    chain.weight = 0;
    // The same numbers make the same path once more.
    growths_.push_back(candidate(static_cast<std::uint32_t>(candidate_index), chain.path));
  }
  for (std::size_t first = 0; first < kChains; first += kSubpaths)
    grower_.grow(std::span(growths_).subspan(first, kSubpaths), key_);
}

Strategy PathChains::strategy_of(std::uint32_t number) const {
  const Numbers::Pair u = Numbers(key_, number)(kStrategy);
  if (u.x < config_.large_steps) return Strategy::kAllNew;
  const auto count = strategies_.size();
  return strategies_[std::min(static_cast<std::size_t>(u.y * static_cast<float>(count)), count - 1)];
}

void PathChains::change(Strategy strategy, int first, std::uint32_t first_number, Film& film) {
  growths_.clear();
  changed_.clear();
  {
    const StageTimer timer(stats_.times, Stage::kCamera);
    for (int i = first; i < first + kSubpaths; ++i) {
      const std::uint32_t number = first_number + static_cast<std::uint32_t>(i);
      Chain& chain = chains_[static_cast<std::size_t>(i)];
      Growth growth = mutations_.propose(strategy, chain.path, Numbers(key_, number).of_proposal(),
                                         offered_[growths_.size()]);
      growth.number = number;
      if (growth.alive) {
        growths_.push_back(growth);
        changed_.push_back(i);
      } else {
        chain.weight += 1;
      }
    }
  }
  grower_.grow(growths_, key_);
  const StageTimer timer(stats_.times, Stage::kFilm);
  for (std::size_t i = 0; i < growths_.size(); ++i) {
    Chain& chain = chains_[static_cast<std::size_t>(changed_[i])];
    const float accepted =
        static_cast<float>(mutations_.acceptance(strategy, chain.path, *growths_[i].path, growths_[i].kept));
    decide(chain, *growths_[i].path, accepted, Numbers(key_, growths_[i].number)(kWayAndAcceptance).y);
  }
  stats_.mutations += kSubpaths;
  splats_.flush(film);
}

/// Both count, by how likely the chain is at each [Veach 1997, section 11.3.2].
void PathChains::decide(Chain& chain, const ExplicitPath& offered, float accepted, float u) {
  chain.weight += 1 - accepted;
  if (u < accepted) {
    splat(chain.path, chain.weight);
    chain.path.take(offered);
    chain.weight = accepted;
    ++stats_.accepted_mutations;
  } else {
    splat(offered, accepted);
  }
}

}  // namespace tessera::render::TESSERA_ISA
