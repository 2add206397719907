// What happens to light between two scattering events in volumetric scenes: media that it flies through, surfaces that
// it passes without being scattered.
#include "render/accel/replay.h"
#include "render/accel/trace.h"
#include "render/integrator/passing.h"
#include "render/integrator/path/wavefront.h"
#include "render/medium/medium.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Surfaces that one ray may pass. Beyond that it is stuck between surfaces that coincide, and ends.
constexpr int kMostCrossings = 1000;
/// Length of rays that meet nothing.
constexpr float kEndless = 1e18f;

Vec3 gather_vec(const Vec3Lanes& from, Int index, Mask active) {
  return {gather(from.x, index, active), gather(from.y, index, active), gather(from.z, index, active)};
}
void scatter_vec(Vec3 v, Vec3Lanes& to, Int index, Mask active) {
  scatter(v.x, to.x, index, active);
  scatter(v.y, to.y, index, active);
  scatter(v.z, to.z, index, active);
}
Spectrum gather_spectrum(const SpectrumLanes& from, Int index, Mask active) {
  Spectrum s;
  for (int c = 0; c < kSpectrumLanes; ++c) s.c[c] = gather(from.c[c], index, active);
  return s;
}
void scatter_spectrum(Spectrum s, SpectrumLanes& to, Int index, Mask active) {
  for (int c = 0; c < kSpectrumLanes; ++c) scatter(s.c[c], to.c[c], index, active);
}
Hit gather_hit(const HitState& hits, Int index, Mask active) {
  return {gather(hits.t, index, active),     gather(hits.u, index, active),
          gather(hits.v, index, active),     gather(hits.primitive, index, active),
          gather(hits.shape, index, active), gather(hits.instance, index, active)};
}
void scatter_hit(const Hit& hit, HitState& hits, Int index, Mask active) {
  scatter(hit.t, hits.t, index, active);
  scatter(hit.u, hits.u, index, active);
  scatter(hit.v, hits.v, index, active);
  scatter(hit.primitive, hits.primitive, index, active);
  scatter(hit.shape, hits.shape, index, active);
  scatter(hit.instance, hits.instance, index, active);
}

/// Keys of number streams: each use of one has its own.
enum class StreamUse : std::uint32_t { kTransit = 1, kShadow = 2 };

NumberStream stream_of(const SampleState& samples, Int slot, StreamUse use, int depth, int round, Mask active) {
  const UInt sample = hash(gather(samples.pixel_hash, slot, active), gather(samples.reversed_sample, slot, active));
  const auto where = (static_cast<std::uint32_t>(depth) << 16 | static_cast<std::uint32_t>(round)) * 2 +
                     static_cast<std::uint32_t>(use);
  return NumberStream(hash(sample, UInt(where)));
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
  const Vec3 o = gather_vec(paths_.origin, path, active), d = gather_vec(paths_.direction, path, active);
  Hit hit = gather_hit(hits_, path, active);
  if (scene_.any_motion) hit.time = gather(paths_.time, path, active);
  Int medium = gather(paths_.medium, path, active);
  Spectrum beta = gather_spectrum(paths_.beta, path, active);
  NumberStream numbers = stream_of(samples_, slot, StreamUse::kTransit, depth, round, active);

  Mask met = active & (hit.shape >= 0);
  const Mask inside = active & (medium >= 0);
  if (any(inside)) {
    const Float distance = select(met, hit.t, kEndless);
    Vec2 u{numbers.next(), numbers.next()};
    if (round == 0) {
      const Sampler sampler(scene_.sampler.kind, gather(samples_.pixel_hash, slot, active),
                            gather(samples_.reversed_sample, slot, active));
      u = sampler.get_2d(dimension::kFlight + depth);
    }
    const Flight flight = sample_flight(scene_.media, {medium, o, d, distance}, beta, u, numbers, inside);
    const Mask lit = and_not(inside, is_black(flight.emission));
    if (any(lit)) add_radiance(beta * flight.emission, slot, lit);
    beta = select(inside, beta * flight.weight, beta);
    scatter_spectrum(beta, paths_.beta, path, inside);
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
  scatter_spectrum(beta * passing.weight, paths_.beta, path, passes);
  scatter_vec(offset_origin(surface, d), paths_.origin, path, passes);
  scatter(medium_behind(scene_.shapes, surface, d, medium, passes), paths_.medium, path, passes);
  return passes;
}

void Wavefront::retrace(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(transit_.path + i);
    transit_.origin.append(gather_vec(paths_.origin, path, active), active, i);
    transit_.direction.append(gather_vec(paths_.direction, path, active), active, i);
    if (scene_.any_motion) gather(paths_.time, path, active).store(transit_.time + i);
  }
  const RayArrays rays = arrays_of(transit_.origin, transit_.direction, times_of(transit_.time));
  if (log_) record_rays(rays, nullptr, count, RayLog::Kind::kBounce, false, *log_);
  trace_nearest(scene_.accel, rays, count, scene_.traversal(), static_cast<std::int32_t>(scene_.shapes.shapes.size()),
                arrays_of(transit_.hits));
  stats_.bounce_rays += static_cast<std::uint64_t>(count);
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    scatter_hit(gather_hit(transit_.hits, Int::iota(i), active), hits_, Int::load(transit_.path + i), active);
  }
}

void Wavefront::end_stuck_paths(int count) {
  for (int i = 0; i < count; i += kWidth) {
    const Mask active = Mask::first(count - i);
    const Int path = Int::load(transit_.path + i);
    scatter_spectrum(Spectrum(0.0f), paths_.beta, path, active);
    scatter(Int(-1), hits_.shape, path, active);
  }
}

void Wavefront::march_shadow_rays(int depth) {
  // The nearest hits of the paths are no longer needed: their arrays serve the shadow rays.
  int n = shadows_.size;
  for (int round = 0; n > 0 && round <= kMostCrossings; ++round) {
    const RayArrays rays = arrays_of(shadows_.origin, shadows_.direction, times_of(shadows_.time));
    if (log_) record_rays(rays, nullptr, n, RayLog::Kind::kBounce, false, *log_);
    trace_nearest(scene_.accel, rays, n, scene_.traversal(), static_cast<std::int32_t>(scene_.shapes.shapes.size()),
                  arrays_of(hits_));
    stats_.shadow_rays += static_cast<std::uint64_t>(n);
    int kept = 0;
    for (int i = 0; i < n; i += kWidth) kept = march(depth, round, i, Mask::first(n - i), kept);
    n = kept;
  }
  shadows_.size = 0;
}

int Wavefront::march(int depth, int round, int i, Mask active, int kept) {
  const Vec3 o = shadows_.origin.load(i), d = shadows_.direction.load(i);
  const Float distance = Float::load(shadows_.distance + i);
  const Int slot = Int::load(shadows_.slot + i);
  Int medium = Int::load(shadows_.medium + i);
  Spectrum contribution = shadows_.contribution.load(i);
  Hit hit = gather_hit(hits_, Int::iota(i), active);
  if (scene_.any_motion) hit.time = Float::load(shadows_.time + i);

  const Mask met = active & (hit.shape >= 0) & (hit.t < distance);
  const Mask inside = active & (medium >= 0);
  if (any(inside)) {
    NumberStream numbers = stream_of(samples_, slot, StreamUse::kShadow, depth, round, active);
    const MediumRays rays{medium, o, d, select(met, hit.t, distance)};
    contribution =
        select(inside, contribution * sample_transmittance(scene_.media, rays, numbers, inside), contribution);
  }
  const Mask arrived = and_not(active, met);
  if (any(arrived)) add_radiance(contribution, slot, arrived);

  const Mask candidates = and_not(met & may_pass(scene_, hit.shape, met), is_black(contribution));
  if (none(candidates)) return kept;
  const Surface surface = surface_at(scene_.shapes, hit, o, d, candidates, false);
  const Passing passing = passing_at(scene_, surface, d, candidates);
  contribution = contribution * passing.weight * passing.probability;
  const Mask passes = and_not(candidates, is_black(contribution));
  const Vec3 origin = offset_origin(surface, d);
  medium = medium_behind(scene_.shapes, surface, d, medium, passes);
  shadows_.origin.append(origin, passes, kept);
  shadows_.direction.append(d, passes, kept);
  compress_store(distance - dot(origin - o, d), passes, shadows_.distance + kept);
  compress_store(slot, passes, shadows_.slot + kept);
  if (scene_.any_motion) compress_store(hit.time, passes, shadows_.time + kept);
  compress_store(medium, passes, shadows_.medium + kept);
  shadows_.contribution.append(contribution, passes, kept);
  return kept + count(passes);
}

}  // namespace tessera::render::TESSERA_ISA
