// Light between two scattering events in volumetric scenes: media that it flies through,
// surfaces that it passes without being scattered.
#include "render/integrator/path/wavefront.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/passing.h"
#include "render/medium/medium.h"

namespace tessera::render::TESSERA_ISA {

namespace {

using dimension::kMostCrossings;

/// Length of rays that meet nothing.
constexpr float kEndless = 1e18f;

NumberStream stream_of(const SampleBatch& batch, Int slot, dimension::Stream use, int depth, int round,
                       Mask active) {
  return NumberStream(hash(batch.key(slot, active), UInt(dimension::stream_key(use, depth, round))));
}

Hit gather_hit(const HitState& hits, Int index, Mask active) {
  Hit hit;
  HitState::for_each([&](auto& to, const auto& from) { to = gather(&from[0], index, active); }, hit, hits);
  return hit;
}

}  // namespace

void Wavefront::transit(int depth) {
  int n = alive_;
  for (int round = 0; n > 0; ++round) {
    int crossed = 0;
    for (int i = 0; i < n; i += kWidth) {
      const Mask active = Mask::first(n - i);
      const Int path = round == 0 ? Int::iota(i) : Int::load(transit_.path + i);
      const Mask goes_on = fly(path, depth, round, active);
      crossed += compress_store(path, goes_on, transit_.path + crossed);
    }
    n = crossed;
    if (round == kMostCrossings) {
      end_stuck_paths(n);
      return;
    }
    retrace(n);
  }
}

Mask Wavefront::fly(Int path, int depth, int round, Mask active) {
  const Int slot = gather(paths_.slot, path, active);
  const Vec3 o = gather_lanes<Vec3>(paths_.origin, path, active),
             d = gather_lanes<Vec3>(paths_.direction, path, active);
  Hit hit = gather_hit(hits_, path, active);
  if (scene_.any_motion) hit.time = gather(paths_.time, path, active);
  Int medium = gather(paths_.medium, path, active);
  Spectrum beta = gather_lanes<Spectrum>(paths_.beta, path, active);
  NumberStream numbers = stream_of(batch_, slot, dimension::Stream::kTransit, depth, round, active);

  Mask met = active & (hit.shape >= 0);
  const Mask inside = active & (medium >= 0);
  if (any(inside)) {
    const Float distance = select(met, hit.t, kEndless);
    Vec2 u{numbers.next(), numbers.next()};
    if (round == 0) {
      u = batch_.sampler(slot, active).get_2d(dimension::kFlight + depth);
    }
    const Flight flight = sample_flight(scene_.media, {medium, o, d, distance}, beta, u, numbers, inside);
    const Mask lit = and_not(inside, is_black(flight.emission));
    if (any(lit)) batch_.add_radiance(beta * flight.emission, slot, lit);
    beta = select(inside, beta * flight.weight, beta);
    scatter_lanes(beta, paths_.beta, path, inside);
    const Mask scattered = flight.scattered & inside;
    scatter(flight.t, hits_.t, path, scattered);
    scatter(Int(kScatteredByMedium), hits_.shape, path, scattered);
    met = and_not(met, scattered);
  }

  const Mask candidates = met & may_pass(scene_, hit.shape, met);
  if (none(candidates)) return Mask::none();
  const Surface surface = surface_at(scene_.shapes, hit, o, d, candidates, false);
  const Passing passing = passing_at(scene_, surface, d, candidates);
  const Mask passes = candidates & (numbers.next() < passing.probability);
  scatter_lanes(beta * passing.weight, paths_.beta, path, passes);
  scatter_lanes(offset_origin(surface, d), paths_.origin, path, passes);
  scatter(medium_behind(scene_.shapes, surface, d, medium, passes), paths_.medium, path, passes);
  return passes;
}

void Wavefront::retrace(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(transit_.path + i);
    copy_lanes(paths_.origin, path, active, transit_.origin, i);
    copy_lanes(paths_.direction, path, active, transit_.direction, i);
    if (scene_.any_motion) copy_lanes(paths_.time, path, active, transit_.time, i);
  }
  rays_.nearest(arrays_of(transit_.origin, transit_.direction, times_of(transit_.time)), count, false,
                transit_.hits.arrays());
  stats_.bounce_rays += static_cast<std::uint64_t>(count);
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(transit_.path + i);
    const Hit hit = load_hit(transit_.hits, i);
    HitState::for_each([&](const auto& from, auto& to) { scatter_lanes(from, to, path, active); }, hit,
                       hits_);
  }
}

void Wavefront::end_stuck_paths(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(transit_.path + i);
    scatter_lanes(Spectrum(0.0f), paths_.beta, path, active);
    scatter(Int(-1), hits_.shape, path, active);
  }
}

void Wavefront::march_shadow_rays(int depth) {
  // The nearest hits of the paths are no longer needed: their arrays serve the shadow rays.
  int n = shadows_.size;
  for (int round = 0; n > 0 && round <= kMostCrossings; ++round) {
    rays_.nearest(arrays_of(shadows_.origin, shadows_.direction, times_of(shadows_.time)), n, false,
                  hits_.arrays());
    stats_.shadow_rays += static_cast<std::uint64_t>(n);
    int kept = 0;
    for (int i = 0; i < n; i += kWidth) kept = march(depth, round, i, Mask::first(n - i), kept);
    n = kept;
  }
  shadows_.size = 0;
}

int Wavefront::march(int depth, int round, int i, Mask active, int kept) {
  WideConnection ray = load(scene_, static_cast<const ConnectionFields<InMemory>&>(shadows_), i);
  Hit hit = load_hit(hits_, i);
  if (scene_.any_motion) hit.time = ray.time;

  const Mask met = active & (hit.shape >= 0) & (hit.t < ray.distance);
  const Mask inside = active & (ray.medium >= 0);
  if (any(inside)) {
    NumberStream numbers = stream_of(batch_, ray.slot, dimension::Stream::kShadow, depth, round, active);
    const MediumRays rays{ray.medium, ray.origin, ray.direction, select(met, hit.t, ray.distance)};
    ray.contribution =
        select(inside, ray.contribution * sample_transmittance(scene_.media, rays, numbers, inside),
               ray.contribution);
  }
  const Mask arrived = and_not(active, met);
  if (any(arrived)) batch_.add_radiance(ray.contribution, ray.slot, arrived);

  const Mask candidates = and_not(met & may_pass(scene_, hit.shape, met), is_black(ray.contribution));
  if (none(candidates)) return kept;
  const Surface surface = surface_at(scene_.shapes, hit, ray.origin, ray.direction, candidates, false);
  const Passing passing = passing_at(scene_, surface, ray.direction, candidates);
  ray.contribution = ray.contribution * passing.weight * passing.probability;
  const Mask passes = and_not(candidates, is_black(ray.contribution));
  const Vec3 origin = offset_origin(surface, ray.direction);
  ray.medium = medium_behind(scene_.shapes, surface, ray.direction, ray.medium, passes);
  ray.distance = ray.distance - dot(origin - ray.origin, ray.direction);
  ray.origin = origin;
  return kept + append(scene_, ray, passes, shadows_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
