// Paths on their way: what their surfaces share.
#include "render/integrator/path/path_reuse.h"

#include <algorithm>

#include "render/integrator/guide/guided_event.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// In first_event_: no surface yet that can be joined to others.
constexpr std::int32_t kNone = -3;

/// Lanes whose vertex is one that neighbours can be joined to: the density of what is found from it is known.
TESSERA_INLINE Mask shareable(const Vertex& v, Mask lanes) {
  const Mask joined = joinable(v, lanes);
  return and_not(joined, estimates_density(v.at, joined));
}

}  // namespace

PathReuse::PathReuse(const IntegratorContext& context, int group, const GuideField* guide, Transit& transit,
                     HitState& room)
    : scene_(context.scene),
      rays_(context.rays),
      stats_(context.stats),
      group_(group),
      guide_(guide),
      transit_(transit),
      room_(room) {
  const std::size_t pairs = pair(group, 0);
  for (Pairs* one : {&pdf_, &pdf_light_, &pdf_on_}) one->resize(pairs);
  for (SpectrumPairs* each : {&weight_, &of_light_, &of_on_}) {
    for (Pairs& one : each->c) one.resize(pairs);
  }
}

void PathReuse::begin(const PathState& paths, const HitState& hits, int n) {
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

void PathReuse::at_surface(const Vertex& v, const Hit& hit, Float mix, const Guided& guided, WidePath& path,
                           Mask lanes, int depth, SampleBatch& batch) {
  const Int event = gather(first_event_, path.slot, lanes);
  if (const Mask now = lanes & (event == Int(kNone)); any(now))
    at_first(v, hit, mix, guided, path, now, depth);
  if (const Mask now = lanes & (event == Int(depth - 1)); any(now)) at_second(v, hit, mix, path, now, batch);
  if (const Mask now = lanes & (event == Int(depth - 2)); any(now)) at_third(v, path, now, batch);
}

void PathReuse::at_first(const Vertex& v, const Hit& hit, Float mix, const Guided& guided,
                         const WidePath& path, Mask lanes, int depth) {
  const Mask joined = shareable(v, lanes);
  if (any(and_not(lanes, joined))) last_mirror_ = depth;
  if (none(joined)) return;
  last_first_ = depth;
  scatter(Int(depth), first_event_, path.slot, joined);
  scatter_lanes(v.surface.p, first_, path.slot, joined);
  if (guide_ != nullptr)
    scatter(select(guided.followed, guided.density, Int(-1)), density_, path.slot, joined);
  if (depth == 0) {  // begin() has the rest
    if (scene_.any_mix) scatter(mix, mix_[0], path.slot, joined);
    return;
  }
  keep(0, path, hit, mix, joined);
  scatter_lanes(path.beta, before_, path.slot, joined);
}

void PathReuse::keep(int event, const WidePath& path, const Hit& hit, Float mix, Mask lanes) {
  scatter_lanes(path.origin, origin_[event], path.slot, lanes);
  scatter_lanes(path.direction, direction_[event], path.slot, lanes);
  HitState::for_each([&](const auto& from, auto& to) { scatter(from, to, path.slot, lanes); }, hit,
                     hits_[event]);
  if (scene_.any_mix) scatter(mix, mix_[event], path.slot, lanes);
}

void PathReuse::set_apart(Int slot, Mask lanes, SampleBatch& batch) {
  const Spectrum before = gather_lanes<Spectrum>(own_, slot, lanes);
  scatter_lanes(before + batch.take_radiance(slot, lanes), own_, slot, lanes);
}

namespace {

/// The path begins anew: what it finds is to be weighted later. Roulette knows what it has lost so far.
TESSERA_INLINE void begin_anew(float caution, WidePath& path, Mask lanes) {
  const Float left = path.beta.max_component() * caution;
  path.roulette_scale = select(lanes, path.roulette_scale * left, path.roulette_scale);
  path.beta = select(lanes, Spectrum(1.0f), path.beta);
}

}  // namespace

void PathReuse::at_second(const Vertex& v, const Hit& hit, Float mix, WidePath& path, Mask lanes,
                          SampleBatch& batch) {
  const Mask found = shareable(v, lanes) & (path.pdf > 0.0f);
  const Mask lambertian =
      reflects_only(v.at) & ((v.at.flags & kLambertian) != 0) & ((v.at.flags & kHasBump) == 0);
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
  if (any(glossy)) keep(1, path, hit, mix, glossy);
  if (none(bright)) return;
  any_shared_ = true;
  set_apart(path.slot, bright, batch);
  begin_anew(scene_.shared_caution, path, bright);
}

void PathReuse::at_third(const Vertex& v, WidePath& path, Mask lanes, SampleBatch& batch) {
  const Int shared = gather(shared_, path.slot, lanes);
  Mask taken = lanes & has(shared, kGlossy) & (path.pdf > 0.0f);
  // Light found behind glass is weighed against light samples from here, which pass the glass.
  if (scene_.straight_shadows)
    taken = and_not(taken, clear_glass_at(scene_, v.surface, path.direction, taken));
  if (none(taken)) return;
  any_shared_ = true;
  scatter(shared | Int(kBeyond), shared_, path.slot, taken);
  scatter_lanes(path.direction, on_, path.slot, taken);
  set_apart(path.slot, taken, batch);
  begin_anew(scene_.shared_caution, path, taken);
}

Mask PathReuse::share_light(Int slot, Vec3 wi, Float pdf, Mask delta, Mask lanes, int depth,
                            SampleBatch& batch) {
  const Int shared = gather(shared_, slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy) & (gather(first_event_, slot, lanes) == Int(depth - 1));
  if (none(taken)) return taken;
  any_shared_ = true;
  scatter(shared | select(delta, Int(kLight | kDelta), Int(kLight)), shared_, slot, taken);
  scatter_lanes(wi, to_light_, slot, taken);
  scatter(pdf, light_pdf_, slot, taken);
  set_apart(slot, taken, batch);
  return taken;
}

Mask PathReuse::share_emission(const WidePath& path, Spectrum radiance, Float by_lights, Mask lanes,
                               int depth) {
  const Int shared = gather(shared_, path.slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy) & (path.pdf > 0.0f) &
                     (gather(first_event_, path.slot, lanes) == Int(depth - 2));
  if (none(taken)) return taken;
  any_shared_ = true;
  scatter(shared | Int(kFound), shared_, path.slot, taken);
  scatter_lanes(path.direction, on_, path.slot, taken);
  scatter_lanes(radiance, found_, path.slot, taken);
  scatter(by_lights, found_pdf_, path.slot, taken);
  return taken;
}

void PathReuse::lights_traced(int depth, SampleBatch& batch) {
  if (!any_shared_) return;
  for (int first = 0; first < size_; first += kWidth) {
    const Mask lanes =
        has(Int::load(shared_ + first), kLight) & (Int::load(first_event_ + first) == Int(depth - 1));
    if (none(lanes)) continue;
    const Int slot = Int::iota(first);
    scatter_lanes(batch.take_radiance(slot, lanes), light_, slot, lanes);
  }
}

Mask PathReuse::spared(Int slot, Mask lanes, int depth) const {
  const Int event = gather(first_event_, slot, lanes);
  return lanes & ((event == Int(depth)) | (event == Int(depth - 1)));
}

}  // namespace tessera::render::TESSERA_ISA
