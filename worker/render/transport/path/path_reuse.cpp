// Paths on their way: what their surfaces share.
#include "render/transport/path/path_reuse.h"

#include <algorithm>

#include "render/light/area/interpolated_normal.h"
#include "render/light/light_access.h"
#include "render/sensor/sensor.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// In first_event_: no surface yet that can be joined to others.
constexpr std::int32_t kNone = -3;

/// Lanes whose vertex is one that neighbours can be joined to: the density of what is found from it is known,
/// and it leaves a path its wavelengths.
TESSERA_INLINE Mask shareable(const SceneTables& scene, const Vertex& v, Mask lanes) {
  const Mask joined = and_not(joinable(v, lanes), disperses_roughly(scene, v, lanes));
  return and_not(joined, estimates_density(v.at, joined));
}

}  // namespace

PathReuse::PathReuse(const IntegratorContext& context, SampleBatch& batch, int group,
                     const Steering* steering, Transit& transit, HitState& room)
    : scene_(context.scene),
      rays_(context.rays),
      stats_(context.stats),
      batch_(batch),
      group_(group),
      steering_(steering),
      transit_(transit),
      room_(room) {
  const std::size_t pairs = pair(group, 0);
  for (Pairs* one : {&pdf_, &pdf_light_, &pdf_on_}) one->resize(pairs);
  for (SpectrumPairs* each : {&weight_, &of_light_, &of_on_}) {
    for (Pairs& one : each->c) one.resize(pairs);
  }
}

void PathReuse::begun(const PathState& paths, const HitState& hits, int n) {
  size_ = n;
  any_shared_ = false;
  last_first_ = last_mirror_ = -1;
  const auto copy = [n](const auto& from, auto& to) { std::copy_n(from, n, to); };
  for_each_component(copy, paths.origin, origin_[0]);
  for_each_component(copy, paths.direction, direction_[0]);
  HitState::for_each(copy, hits, hits_[0]);
  if (scene_.any_motion) copy(paths.time, time_);
  std::fill_n(first_event_, kPadded, kNone);
  std::fill_n(shared_, kPadded, 0);
  for (auto& lanes : own_.c) std::fill_n(lanes, n, 0.0f);
}

void PathReuse::met(Encounter& e) {
  if (!follows(e.depth)) return;
  const Mask lanes = e.on_surface;
  const Int event = gather(first_event_, e.path.slot, lanes);
  if (const Mask now = lanes & (event == Int(kNone)); any(now)) at_first(e, now);
  if (const Mask now = lanes & (event == Int(e.depth - 1)); any(now)) at_second(e, now);
  if (const Mask now = lanes & (event == Int(e.depth - 2)); any(now)) at_third(e, now);
}

void PathReuse::at_first(const Encounter& e, Mask lanes) {
  const Mask joined = shareable(scene_, e.vertex, lanes);
  if (any(and_not(lanes, joined))) last_mirror_ = e.depth;
  if (none(joined)) return;
  last_first_ = e.depth;
  const Int slot = e.path.slot;
  scatter(Int(e.depth), first_event_, slot, joined);
  scatter_lanes(e.vertex.surface.p, first_, slot, joined);
  if (disperses(scene_)) scatter(e.path.dispersed, dispersed_, slot, joined);
  if (steering_ != nullptr) scatter(e.steered, steered_, slot, joined);
  if (e.depth > 0 || weighs_rays(scene_.sensor)) scatter_lanes(e.path.beta, before_, slot, joined);
  if (e.depth > 0) return keep(0, e, joined);
  // begun() has the rest.
  if (scene_.any_mix) scatter(e.roulette.y, mix_[0], slot, joined);
}

void PathReuse::keep(int event, const Encounter& e, Mask lanes) {
  const Int slot = e.path.slot;
  scatter_lanes(e.path.origin, origin_[event], slot, lanes);
  scatter_lanes(e.path.direction, direction_[event], slot, lanes);
  HitState::for_each([&](const auto& from, auto& to) { scatter(from, to, slot, lanes); }, e.hit,
                     hits_[event]);
  if (scene_.any_mix) scatter(e.roulette.y, mix_[event], slot, lanes);
}

/// Sets aside the light that the samples have found so far, which is theirs alone.
void PathReuse::set_apart(Int slot, Mask lanes) {
  const Spectrum before = gather_lanes<Spectrum>(own_, slot, lanes);
  scatter_lanes(before + batch_.take_radiance(slot, lanes), own_, slot, lanes);
}

namespace {

/// The path begins anew: what it finds is to be weighted later. Roulette knows what it has lost so far.
TESSERA_INLINE void begin_anew(const SceneTables& scene, WidePath& path, Mask lanes) {
  const Float left = path.beta.max_component() * scene.shared_caution;
  path.roulette_scale = select(lanes, path.roulette_scale * left, path.roulette_scale);
  path.beta = select(lanes, Spectrum(1.0f), path.beta);
  if (disperses(scene)) path.beta = first_alone(lanes & (path.dispersed != 0), path.beta);
}

}  // namespace

void PathReuse::at_second(Encounter& e, Mask lanes) {
  const Vertex& v = e.vertex;
  WidePath& path = e.path;
  const Mask found = shareable(scene_, v, lanes) & (path.pdf > 0.0f);
  const Mask lambertian =
      reflects_only(v.at) & ((v.at.traits & kLambertian) != 0) & ((v.at.flags & kHasBump) == 0);
  const Mask even = found & lambertian;
  // Most of the black ones are lamps.
  const Mask bright = and_not(even, is_black(v.at.params.spectra[slot::kReflectance]));
  const Mask glossy = and_not(found, even), kept = glossy | bright;
  if (none(kept)) return;
  scatter_lanes(v.surface.p, p_, path.slot, kept);
  scatter_lanes(face_forward(v.surface.ng, v.wo), ng_, path.slot, kept);
  scatter_lanes(face_forward(v.at.frame.z, v.wo), ns_, path.slot, kept);
  scatter(v.surface.error, error_, path.slot, kept);
  scatter(select(bright, Int(kEven), Int(kGlossy)), shared_, path.slot, kept);
  if (any(glossy)) keep(1, e, glossy);
  if (none(bright)) return;
  any_shared_ = true;
  set_apart(path.slot, bright);
  begin_anew(scene_, path, bright);
}

void PathReuse::at_third(Encounter& e, Mask lanes) {
  WidePath& path = e.path;
  const Int shared = gather(shared_, path.slot, lanes);
  Mask taken = lanes & has(shared, kGlossy) & (path.pdf > 0.0f);
  // Light found behind glass is weighed against light samples from here, which pass the glass.
  if (scene_.straight_shadows)
    taken = and_not(taken, clear_glass_at(scene_, e.vertex.surface, path.direction, taken));
  if (none(taken)) return;
  any_shared_ = true;
  scatter(shared | Int(kBeyond), shared_, path.slot, taken);
  scatter_lanes(path.direction, on_, path.slot, taken);
  set_apart(path.slot, taken);
  begin_anew(scene_, path, taken);
}

/// Shared light is neither scattered at the second surface nor weighed.
void PathReuse::lit(const Encounter& e, SampledLight& light) {
  if (!shares_lamps() || !follows(e.depth)) return;
  Mask lanes = and_not(light.lanes, has_interpolated_normals(scene_.lights, light.light, light.lanes));
  if (!shares_sky()) lanes = and_not(lanes, environment_lanes(scene_.lights, light.light, light.lanes));
  const Int slot = e.path.slot, shared = gather(shared_, slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy) & (gather(first_event_, slot, lanes) == Int(e.depth - 1));
  if (none(taken)) return;
  any_shared_ = true;
  scatter(shared | select(light.sample.delta, Int(kLight | kDelta), Int(kLight)), shared_, slot, taken);
  scatter_lanes(light.sample.wi, to_light_, slot, taken);
  scatter(light.pdf, light_pdf_, slot, taken);
  set_apart(slot, taken);
  light.ray.contribution = select(taken, light.radiance, light.ray.contribution);
}

/// Shared light is not the sample's own.
void PathReuse::emitted(const Encounter& e, MetLight& light) {
  if (none(light.weighed) || !follows(e.depth)) return;
  if (!(light.at_infinity ? shares_sky() : shares_lamps())) return;
  Mask lanes = light.weighed;
  if (!light.at_infinity) lanes = and_not(lanes, has_interpolated_normals(scene_.lights, light.light, lanes));
  const Int slot = e.path.slot, shared = gather(shared_, slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy) & (e.path.pdf > 0.0f) &
                     (gather(first_event_, slot, lanes) == Int(e.depth - 2));
  if (none(taken)) return;
  any_shared_ = true;
  scatter(shared | Int(kFound), shared_, slot, taken);
  scatter_lanes(e.path.direction, on_, slot, taken);
  scatter_lanes(light.radiance, found_, slot, taken);
  scatter(light.by_lights, found_pdf_, slot, taken);
  light.arriving = select(taken, Spectrum(0.0f), light.arriving);
}

void PathReuse::all_lit(int depth, const PathState&, int) {
  if (!any_shared_ || !follows(depth)) return;
  for (int first = 0; first < size_; first += kWidth) {
    const Mask lanes =
        has(Int::load(shared_ + first), kLight) & (Int::load(first_event_ + first) == Int(depth - 1));
    if (none(lanes)) continue;
    const Int slot = Int::iota(first);
    scatter_lanes(batch_.take_radiance(slot, lanes), light_, slot, lanes);
  }
}

/// Whether paths go on from a first or a second surface would be part of the density with which neighbours
/// find what comes next.
void PathReuse::scattered(const Encounter& e, Scattering& s) {
  if (e.depth <= kRouletteStart || !follows(e.depth)) return;
  const Int event = gather(first_event_, e.path.slot, s.lanes);
  s.spared |= s.lanes & ((event == Int(e.depth)) | (event == Int(e.depth - 1)));
}

}  // namespace tessera::render::TESSERA_ISA
