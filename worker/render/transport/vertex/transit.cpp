#include "render/transport/vertex/transit.h"

#include "render/transport/vertex/layers.h"

namespace tessera::render::TESSERA_ISA {

namespace {

using dimension::kMostCrossings;

/// Length of rays that meet nothing.
constexpr float kEndless = 1e18f;

NumberStream stream_of(UInt key, dimension::Stream use, int event, int round) {
  return NumberStream(hash(key, UInt(dimension::stream_key(use, event, round))));
}

Hit gather_hit(const HitState& hits, Int index, Mask active) {
  Hit hit;
  HitState::for_each([&](auto& to, const auto& from) { to = gather(&from[0], index, active); }, hit, hits);
  return hit;
}

}  // namespace

void Transit::move(PathState& paths, HitState& hits, int count, int event, const TransitNumbers& numbers,
                   SampleBatch* emission) {
  const Flying flying{paths, hits, event, numbers, emission};
  int n = count;
  for (int round = 0; n > 0; ++round) {
    int crossed = 0;
    for (int i = 0; i < n; i += kWidth) {
      const Mask active = Mask::first(n - i);
      const Int path = round == 0 ? Int::iota(i) : Int::load(passed_.path + i);
      const Mask goes_on = fly(flying, path, round, active);
      crossed += compress_store(path, goes_on, passed_.path + crossed);
    }
    n = crossed;
    if (round == kMostCrossings) {
      end_stuck_paths(paths, hits, n);
      return;
    }
    retrace(paths, hits, n);
  }
}

Mask Transit::fly(const Flying& flying, Int path, int round, Mask active) {
  PathState& paths = flying.paths;
  HitState& hits = flying.hits;
  const Int slot = gather(paths.slot, path, active);
  const Vec3 o = gather_lanes<Vec3>(paths.origin, path, active),
             d = gather_lanes<Vec3>(paths.direction, path, active);
  Hit hit = gather_hit(hits, path, active);
  if (scene_.any_motion) hit.time = gather(paths.time, path, active);
  Int medium = gather(paths.medium, path, active);
  Spectrum beta = gather_lanes<Spectrum>(paths.beta, path, active);
  const Spectra spectra(scene_.spectral, gather_lanes<Wavelengths>(paths.wavelengths, path, active));
  NumberStream numbers =
      stream_of(flying.numbers.key(slot, active), dimension::Stream::kTransit, flying.event, round);

  Mask met = active & (hit.shape >= 0);
  const Mask inside = active & (medium >= 0);
  if (any(inside)) {
    const Float distance = select(met, hit.t, kEndless);
    Vec2 u{numbers.next(), numbers.next()};
    if (round == 0 && flying.numbers.distance_x) {
      u = {gather(flying.numbers.distance_x, slot, active), gather(flying.numbers.distance_y, slot, active)};
    } else if (round == 0) {
      const SampleKeys& keys = flying.numbers.keys;
      u = keys.sampler(scene_.sampler.kind, slot, active).get_2d(flying.numbers.flight + flying.event);
    }
    const Flight flight =
        sample_flight(scene_.media, {medium, o, d, distance, spectra}, beta, u, numbers, inside);
    const Mask lit = and_not(inside, is_black(flight.emission));
    if (flying.emission && any(lit)) {
      flying.emission->add_radiance(beta * flight.emission, slot, lit);
      if (tells_layers(scene_)) {
        const Int layers = layers_at_source(scene_.layers, gather(paths.layer_state, path, lit),
                                            Int(scene_.layers.source_of_media), lit);
        // It is met by chance, as lights are that paths run into.
        const std::int32_t found = layers_of_strategy(scene_.layers, 0, flying.event + 2);
        flying.emission->add_to_layers(beta * flight.emission, layers & Int(found), slot, lit);
      }
    }
    beta = select(inside, beta * flight.weight, beta);
    scatter_lanes(beta, paths.beta, path, inside);
    const Mask scattered = flight.scattered & inside;
    scatter(flight.t, hits.t, path, scattered);
    scatter(Int(kScatteredByMedium), hits.shape, path, scattered);
    met = and_not(met, scattered);
  }

  const Mask candidates = met & may_pass(scene_, Passenger::kPath, hit.shape, met);
  if (none(candidates)) return Mask::none();
  const Surface surface = surface_at(scene_.shapes, hit, o, d, candidates, false);
  const Passing passing = passing_at(scene_, Passenger::kPath, surface, d, spectra, candidates);
  const Mask passes = candidates & (numbers.next() < passing.probability);
  scatter_lanes(beta * passing.weight, paths.beta, path, passes);
  scatter_lanes(offset_origin(surface, d), paths.origin, path, passes);
  scatter(medium_behind(scene_.shapes, surface, d, medium, passes), paths.medium, path, passes);
  return passes;
}

void Transit::retrace(PathState& paths, HitState& hits, int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(passed_.path + i);
    copy_lanes(paths.origin, path, active, passed_.origin, i);
    copy_lanes(paths.direction, path, active, passed_.direction, i);
    if (scene_.any_motion) copy_lanes(paths.time, path, active, passed_.time, i);
  }
  rays_.nearest(arrays_of(passed_.origin, passed_.direction, times_of(passed_.time)), count, false,
                passed_.hits.arrays());
  stats_.bounce_rays += static_cast<std::uint64_t>(count);
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(passed_.path + i);
    const Hit hit = load_hit(passed_.hits, i);
    HitState::for_each([&](const auto& from, auto& to) { scatter_lanes(from, to, path, active); }, hit, hits);
  }
}

void Transit::end_stuck_paths(PathState& paths, HitState& hits, int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(passed_.path + i);
    scatter_lanes(Spectrum(0.0f), paths.beta, path, active);
    scatter(Int(-1), hits.shape, path, active);
  }
}

Mask Transit::cross(Passenger who, WideConnection& ray, Hit hit, int event, int round, Mask active,
                    Mask& arrived) {
  if (scene_.any_motion) hit.time = ray.time;
  const Mask met = active & (hit.shape >= 0) & (hit.t < ray.distance);
  const Spectra spectra(scene_.spectral, ray.wavelengths);
  const Mask inside = active & (ray.medium >= 0);
  if (any(inside)) {
    NumberStream numbers =
        stream_of(bit_cast<std::uint32_t>(ray.key), dimension::Stream::kShadow, event, round);
    const MediumRays rays{ray.medium, ray.origin, ray.direction, select(met, hit.t, ray.distance), spectra};
    ray.contribution =
        select(inside, ray.contribution * sample_transmittance(scene_.media, rays, numbers, inside),
               ray.contribution);
  }
  arrived = and_not(active, met);
  const Mask candidates = and_not(met & may_pass(scene_, who, hit.shape, met), is_black(ray.contribution));
  if (none(candidates)) return candidates;
  const Surface surface = surface_at(scene_.shapes, hit, ray.origin, ray.direction, candidates, false);
  const Passing passing = passing_at(scene_, who, surface, ray.direction, spectra, candidates);
  const Spectrum left = ray.contribution * passing.weight * passing.probability;
  ray.contribution = select(candidates, left, ray.contribution);
  const Mask passes = and_not(candidates, is_black(left));
  const Vec3 origin = offset_origin(surface, ray.direction);
  ray.medium =
      select(passes, medium_behind(scene_.shapes, surface, ray.direction, ray.medium, passes), ray.medium);
  // To the same end as before: beside it, by the offset of a large surface, the light would shadow itself.
  const Vec3 rest = fma(ray.direction, ray.distance, ray.origin) - origin;
  const Float distance = length(rest);
  ray.direction = select(passes, rest * (1.0f / max(distance, 1e-30f)), ray.direction);
  ray.distance = select(passes, distance, ray.distance);
  ray.origin = select(passes, origin, ray.origin);
  return passes;
}

}  // namespace tessera::render::TESSERA_ISA
