#include "render/transport/mlt/chains.h"

#include <algorithm>
#include <cmath>

#include "render/color/spectrum.h"
#include "render/film/summable.h"
#include "render/integrator/stage_timer.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The least small step over the largest, as [Kelemen et al. 2002] have it.
constexpr float kLeastStep = 1.0f / 16;

// Pairs of a path's numbers that are none of the sampler's dimensions.
constexpr int kCoordinates = 1 << 29;  // the pair of place 0; the others follow
constexpr int kStep = kCoordinates - 1;
constexpr int kWay = kCoordinates - 2;
constexpr int kDepth = kCoordinates - 3;
constexpr int kPick = kCoordinates - 4;

/// Largest number below 1.
constexpr float kBelowOne = 0x1.fffffep-1f;

/// Paths of more events are sorted as one.
constexpr int kSortedEvents = 32;
int first_class(int events) { return events * (events + 3) / 2; }

int way_of(float u, int ways) { return std::min(static_cast<int>(u * static_cast<float>(ways)), ways - 1); }

/// A small step from `x`, round the ends of [0, 1): as likely as the one back.
Float step(Float x, Float u, float largest, float log_ratio) {
  const Mask up = u < 0.5f;
  const Float v = select(up, u, u - 0.5f) * 2.0f;
  const Float size = exp(v * log_ratio) * largest;
  Float y = select(up, x + size, x - size);
  y = select(y >= 1.0f, y - 1.0f, y);
  y = select(y < 0.0f, y + 1.0f, y);
  return clamp(y, 0.0f, kBelowOne);
}

/// Chains go where light is bright: by its luminance, or, where lanes are wavelengths that are sampled as the
/// sensor sees them, by their mean. Light of any colour has some, so that nothing is found too seldom.
template <int N>
Float brightness_of(Components<N> light) {
  if constexpr (N == kBands) {
    return luminance(light);
  } else {
    return light.mean();
  }
}

}  // namespace

DepthChoice::Choice DepthChoice::choose(double u) const {
  const double place = 1 / (1.0 / 3 - u / scale_) - 3;  // up_to(place) is u
  int events = std::clamp(static_cast<int>(std::min<double>(place, most_)) + 1, 1, most_);
  while (events > 1 && up_to(events - 1) > u) --events;
  while (events < most_ && up_to(events) <= u) ++events;
  const double rest = (u - up_to(events - 1)) / probability(events);
  return {events, std::clamp(static_cast<float>(rest), 0.0f, kBelowOne)};
}

Chains::Chains(PathSpace& space, const MetropolisSettings& config, RenderStats& stats)
    : space_(space),
      response_(space.response()),
      config_(config),
      stats_(stats),
      depths_(space.max_events()),
      largest_step_(config.step),
      log_ratio_(std::log(kLeastStep)),
      chains_(kChains) {
  for (int place = 0; place < kPlacesPerEvent; ++place) asks_for_[place] = space.asks_for(place);
}

bool Chains::run(const FamilyName& name, float share, Film& film, std::stop_token stop) {
  const double light = make_candidates(name, stop);
  if (stop.stop_requested()) return false;
  if (!(light > 0)) return true;  // no candidate has found any: an estimate like others
  start_chains(light);
  const double mean = light / static_cast<double>(candidates_.size());
  scale_ = static_cast<float>(mean / kChains / config_.mutations * share);
  for (std::uint32_t step = 0; step < config_.mutations; ++step) {
    if (stop.stop_requested()) return false;
    {
      const StageTimer timer(stats_.times, Stage::kCamera);
      offer(step);
      sort();
    }
    for (int first = 0; first < kChains; first += kSubpaths) {
      propose(first, kSubpaths);
      make();
      decide(first, kSubpaths, film);
    }
  }
  for (const Chain& chain : chains_) splat(chain, chain.weight);
  flush(film);
  return true;
}

double Chains::make_candidates(const FamilyName& name, std::stop_token stop) {
  family_key_ = Sampler::pixel_hash(name.seed, UInt(name.pass), UInt(name.number)).lane(0);
  const int count = kChains * static_cast<int>(config_.candidates);
  candidates_.resize(static_cast<std::size_t>(count));
  candidate_light_.resize(candidates_.size());
  batch_.coordinates_by_place.resize(static_cast<std::size_t>(places_of(space_.max_events())));
  double sum = 0;
  for (int first = 0; first < count && !stop.stop_requested(); first += kSubpaths) {
    int most = 0;
    {
      const StageTimer timer(stats_.times, Stage::kCamera);
      for (int slot = 0; slot < kSubpaths; slot += kWidth) {
        UInt(family_key_).store(batch_.keys.pixel_hash + slot);
        const UInt number = UInt::iota(static_cast<std::uint32_t>(first + slot));
        number.store(batch_.keys.reversed_sample + slot);
        alignas(64) float u[kWidth];
        Sampler(SamplerKind::kIndependent, UInt(family_key_), number).get_2d(kDepth).x.store(u);
        for (int i = 0; i < kWidth; ++i) {
          // One in each of as many strata, by depth and then by way: neighbours are alike.
          const int index = first + slot + i;
          const DepthChoice::Choice choice = depths_.choose((index + static_cast<double>(u[i])) / count);
          Path& path = candidates_[static_cast<std::size_t>(index)];
          path.events = choice.events;
          path.way = choice.rest;
          path.from_light = way_of(choice.rest, space_.ways(choice.events));
          path.number = static_cast<std::uint32_t>(index);
          batch_.events[slot + i] = choice.events;
          batch_.from_light[slot + i] = path.from_light;
          batch_.from_eye[slot + i] = choice.events + 2 - path.from_light;
          most = std::max(most, choice.events);
        }
        const Sampler numbers(SamplerKind::kIndependent, UInt(family_key_), number);
        for (int place = 0; place < places_of(most); ++place) {
          if (place >= kFirstPlaceOfEvents && !asks_for_[(place - kFirstPlaceOfEvents) % kPlacesPerEvent])
            continue;
          const Vec2 pair = numbers.get_2d(kCoordinates + place);
          PathBatch::Pair& to = batch_.coordinates_by_place[static_cast<std::size_t>(place)];
          pair.x.store(to.x + slot);
          pair.y.store(to.y + slot);
        }
      }
    }
    batch_.count = kSubpaths;
    make();
    for (int slot = 0; slot < kSubpaths; ++slot) {
      const auto index = static_cast<std::size_t>(first + slot);
      candidates_[index] = made(slot, candidates_[index]);
      candidate_light_[index] =
          static_cast<double>(candidates_[index].brightness) / depths_.probability(candidates_[index].events);
      sum += candidate_light_[index];
    }
  }
  return sum;
}

void Chains::start_chains(double light) {
  // Systematic resampling: as many chains begin at a candidate as its part of the light says, or one more or
  // less.
  const double u = static_cast<double>(
      Sampler(SamplerKind::kIndependent, UInt(family_key_), UInt(0)).get_2d(kPick).x.lane(0));
  std::size_t candidate = 0;
  double sum = candidate_light_[0];
  int deepest = 0;
  for (int chain = 0; chain < kChains; ++chain) {
    const double at = (chain + u) / kChains * light;
    while (candidate + 1 < candidates_.size() && !(sum > at)) sum += candidate_light_[++candidate];
    // Rounding may lead beyond the last that has any.
    while (candidate_light_[candidate] == 0) --candidate;
    Chain& state = chains_[static_cast<std::size_t>(chain)];
    static_cast<Path&>(state) = candidates_[candidate];
    state.weight = 0;
    deepest = std::max(deepest, state.events);
  }
  stride_ = 2 * static_cast<std::size_t>(places_of(deepest));
  chain_coordinates_.resize(stride_ * kChains);
  for (int chain = 0; chain < kChains; chain += kWidth) materialize(chain);
}

/// The coordinates of the paths that 16 chains begin with.
void Chains::materialize(int chain) {
  alignas(64) std::uint32_t number[kWidth];
  for (int i = 0; i < kWidth; ++i) number[i] = chains_[static_cast<std::size_t>(chain + i)].number;
  const Sampler numbers(SamplerKind::kIndependent, UInt(family_key_), UInt::load(number));
  const Int at = Int::iota(chain) * static_cast<std::int32_t>(stride_);
  for (std::size_t place = 0; 2 * place < stride_; ++place) {
    const Vec2 pair = numbers.get_2d(kCoordinates + static_cast<int>(place));
    scatter(pair.x, chain_coordinates_.data() + 2 * place, at, Mask::all());
    scatter(pair.y, chain_coordinates_.data() + 2 * place + 1, at, Mask::all());
  }
}

void Chains::offer(std::uint32_t step_number) {
  const std::uint32_t first_number = static_cast<std::uint32_t>(candidates_.size()) + step_number * kChains;
  for (int chain = 0; chain < kChains; chain += kWidth) {
    const UInt number = UInt::iota(first_number + static_cast<std::uint32_t>(chain));
    const Sampler numbers(SamplerKind::kIndependent, UInt(family_key_), number);
    const Vec2 u = numbers.get_2d(kStep);
    const Mask large = u.x < config_.large_steps;
    alignas(64) float old[kWidth];
    for (int i = 0; i < kWidth; ++i) old[i] = chains_[static_cast<std::size_t>(chain + i)].way;
    const Float fresh = numbers.get_2d(kWay).x;
    select(large, fresh, step(Float::load(old), fresh, largest_step_, log_ratio_)).store(offers_.way + chain);
    u.y.store(offers_.accept + chain);
    number.store(offers_.number + chain);
    select(large, Int(1), Int(0)).store(offers_.large + chain);
  }
  for (int chain = 0; chain < kChains; ++chain)
    offers_.from_light[chain] =
        way_of(offers_.way[chain], space_.ways(chains_[static_cast<std::size_t>(chain)].events));
}

/// Sorts chains by events and ways, so that packets are alike.
void Chains::sort() {
  first_of_way_.assign(static_cast<std::size_t>(first_class(kSortedEvents) + 2), 0);
  const auto class_of = [&](int chain) {
    const int events = chains_[static_cast<std::size_t>(chain)].events;
    return static_cast<std::size_t>(events < kSortedEvents ? first_class(events) + offers_.from_light[chain]
                                                           : first_class(kSortedEvents));
  };
  for (int chain = 0; chain < kChains; ++chain) ++first_of_way_[class_of(chain) + 1];
  for (std::size_t i = 1; i < first_of_way_.size(); ++i) first_of_way_[i] += first_of_way_[i - 1];
  for (int chain = 0; chain < kChains; ++chain) order_[first_of_way_[class_of(chain)]++] = chain;
}

void Chains::propose(int first, int count) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  batch_.count = count;
  for (int slot = 0; slot < count; slot += kWidth) {
    const int packet = slot / kWidth;
    const Int chain = Int::load(order_ + first + slot);
    alignas(64) std::int32_t events[kWidth], old_light[kWidth];
    alignas(64) std::uint32_t key[kWidth];
    int most = 0;
    for (int i = 0; i < kWidth; ++i) {
      const int c = order_[first + slot + i];
      const Chain& state = chains_[static_cast<std::size_t>(c)];
      events[i] = state.events;
      old_light[i] = state.from_light;
      key[i] = offers_.large[c] != 0 ? offers_.number[c] : state.number;
      most = std::max(most, state.events);
    }
    const Int from_light = gather(offers_.from_light, chain), from_eye = Int::load(events) + 2 - from_light;
    Int::load(events).store(batch_.events + slot);
    from_light.store(batch_.from_light + slot);
    from_eye.store(batch_.from_eye + slot);
    UInt(family_key_).store(batch_.keys.pixel_hash + slot);
    UInt::load(key).store(batch_.keys.reversed_sample + slot);

    // A coordinate that the path has not had before is new, too.
    const Sampler numbers(SamplerKind::kIndependent, UInt(family_key_), gather(offers_.number, chain));
    const Mask small = gather(offers_.large, chain) == 0;
    const Int had_light = select(small, Int::load(old_light), -1),
              had_eye = select(small, Int::load(events) + 2 - had_light, -1);
    for (int place = 0; place < kFirstEmission; ++place) {
      // The film and the lens are the eye's, and time is everyone's.
      const bool eyes = place != dimension::kTime;
      propose(place, packet, chain, numbers, eyes ? from_eye >= 2 : Mask::all(), eyes ? had_eye >= 2 : small);
    }
    for (int place = kFirstEmission; place < kFirstPlaceOfEvents; ++place)
      propose(place, packet, chain, numbers, from_light >= 2, had_light >= 2);
    for (int event = 0; event < points_of(most); ++event) {
      const int base = kFirstPlaceOfEvents + event * kPlacesPerEvent;
      for (int within = 0; within < kPlacesPerEvent; ++within) {
        if (!asks_for_[within]) continue;
        const bool eyes = within < kFirstLightPlace;
        const Mask lanes = (eyes ? from_eye : from_light) >= event + 2;
        if (any(lanes)) {
          propose(base + within, packet, chain, numbers, lanes, (eyes ? had_eye : had_light) >= event + 2);
        }
      }
    }
  }
}

void Chains::propose(int place, int packet, Int chain, const Sampler& numbers, Mask lanes, Mask kept) {
  Vec2 u = numbers.get_2d(kCoordinates + place);
  kept &= lanes;
  if (any(kept)) {
    const float* const old = chain_coordinates_.data() + 2 * place;
    const Int at = chain * static_cast<std::int32_t>(stride_);
    u.x = select(kept, step(gather(old, at, kept), u.x, largest_step_, log_ratio_), u.x);
    u.y = select(kept, step(gather(old + 1, at, kept), u.y, largest_step_, log_ratio_), u.y);
  }
  PathBatch::Pair& to = batch_.coordinates_by_place[static_cast<std::size_t>(place)];
  u.x.store(to.x + packet * kWidth);
  u.y.store(to.y + packet * kWidth);
}

void Chains::make() {
  space_.make(batch_);
  for (int slot = 0; slot < batch_.count; slot += kWidth) {
    Spectrum light;
    load_lanes(batch_.light, slot, light);
    Mask lit = Mask::all();
    for (int c = 0; c < kSpectrumLanes; ++c) lit &= is_summable(light.c[c]);
    select_or_zero(lit, max(brightness_of(light), 0.0f)).store(brightness_ + slot);
    const Wavelengths wavelengths = space_.wavelengths(batch_, slot / kWidth);
    const Channels channels = channels_of_light(response_, wavelengths);
    for (int channel = 0; channel < kResponseChannels; ++channel)
      channels.of(channel, [&](int lane) { return light.c[lane]; }).store(channels_[channel] + slot);
    find_bands(slot, wavelengths, channels);
  }
}

/// What 16 paths of the batch bring to the film's bands.
void Chains::find_bands(int slot, const Wavelengths& wavelengths, const Channels& channels) {
#ifdef TESSERA_SPECTRAL
  if (response_.sensitivity.bands == 0) return;
  for (int lane = 0; lane < kSpectrumLanes; ++lane) {
    const BandShare share = band_share(response_.sensitivity, wavelengths, channels, lane);
    alignas(64) std::int32_t band[kWidth];
    alignas(64) float light[kWidth];
    share.band.store(band);
    (Float::load(batch_.light.c[lane] + slot) * share.weight).store(light);
    for (int i = 0; i < kWidth; ++i) {
      bands_[slot + i].band[lane] = band[i];
      bands_[slot + i].light[lane] = light[i];
    }
  }
#else
  (void)slot, (void)wavelengths, (void)channels;
#endif
}

Chains::Path Chains::made(int slot, const Path& asked) const {
  Path path = asked;
  path.x = batch_.film_x[slot];
  path.y = batch_.film_y[slot];
  for (int c = 0; c < kResponseChannels; ++c) path.light[c] = channels_[c][slot];
  path.bands = bands_[slot];
  path.brightness = brightness_[slot];
  return path;
}

void Chains::decide(int first, int count, Film& film) {
  const StageTimer timer(stats_.times, Stage::kFilm);
  for (int slot = 0; slot < count; ++slot) {
    const int c = order_[first + slot];
    Chain& chain = chains_[static_cast<std::size_t>(c)];
    Path asked = chain;
    asked.from_light = offers_.from_light[c];
    asked.way = offers_.way[c];
    if (offers_.large[c] != 0) asked.number = offers_.number[c];
    const Path path = made(slot, asked);
    const float accepted = std::min(path.brightness / chain.brightness, 1.0f);
    // Both count, by how likely the chain is at each [Veach 1997, section 11.3.2].
    chain.weight += 1 - accepted;
    if (offers_.accept[c] < accepted) {
      splat(chain, chain.weight);
      keep(c, slot);
      static_cast<Path&>(chain) = path;
      chain.weight = accepted;
      ++stats_.accepted_mutations;
    } else {
      splat(path, accepted);
    }
  }
  stats_.mutations += static_cast<std::uint64_t>(count);
  flush(film);
}

/// The coordinates of a slot become the chain's.
void Chains::keep(int chain, int slot) {
  float* const to = chain_coordinates_.data() + static_cast<std::size_t>(chain) * stride_;
  const auto copy = [&](int place) {
    to[2 * place] = batch_.coordinates_by_place[static_cast<std::size_t>(place)].x[slot];
    to[2 * place + 1] = batch_.coordinates_by_place[static_cast<std::size_t>(place)].y[slot];
  };
  for (int place = 0; place < kFirstPlaceOfEvents; ++place) copy(place);
  const auto copy_events = [&](int count, int begin, int end) {
    for (int event = 0; event < std::min(count, kMutatedEvents); ++event) {
      for (int within = begin; within < end; ++within) {
        if (asks_for_[within]) copy(kFirstPlaceOfEvents + event * kPlacesPerEvent + within);
      }
    }
  };
  copy_events(batch_.from_eye[slot] - 1, 0, kFirstLightPlace);
  copy_events(batch_.from_light[slot] - 1, kFirstLightPlace, kPlacesPerEvent);
}

/// Adds a path to the film by how likely a chain is there.
void Chains::splat(const Path& path, float weight) {
  if (!(path.brightness > 0) || !(weight > 0)) return;
  const float scale = weight * scale_ / path.brightness;
  Splat splat{path.x, path.y, {}};
  for (int channel = 0; channel < kResponseChannels; ++channel)
    splat.value[channel] = path.light[channel] * scale;
  splats_.push_back(splat);
  splat_bands(path, scale);
}

void Chains::splat_bands(const Path& path, float scale) {
#ifdef TESSERA_SPECTRAL
  if (response_.sensitivity.bands == 0) return;
  for (int lane = 0; lane < kSpectrumLanes; ++lane) {
    if (path.bands.band[lane] >= 0)
      band_splats_.push_back({path.x, path.y, path.bands.light[lane] * scale, path.bands.band[lane]});
  }
#else
  (void)path, (void)scale;
#endif
}

void Chains::flush(Film& film) {
  film.splat(splats_);
  splats_.clear();
  if (!band_splats_.empty()) film.splat_bands(band_splats_);
  band_splats_.clear();
}

}  // namespace tessera::render::TESSERA_ISA
