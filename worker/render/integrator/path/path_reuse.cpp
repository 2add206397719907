#include "render/integrator/path/path_reuse.h"

#include <algorithm>

#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A direction to a point and its squared distance.
struct Way {
  Vec3 w;
  Float squared;
};
TESSERA_INLINE Way way(Vec3 from, Vec3 to) {
  const Vec3 whole = to - from;
  const Float squared = length_squared(whole);
  return {whole * (1.0f / sqrt(select(squared > 0.0f, squared, 1.0f))), squared};
}

TESSERA_INLINE Mask has(Int bits, std::int32_t some) { return (bits & Int(some)) != 0; }

}  // namespace

PathReuse::PathReuse(const IntegratorContext& context, int group)
    : scene_(context.scene), rays_(context.rays), stats_(context.stats), group_(group) {
  const std::size_t pairs = pair(group, 0);
  for (Pairs* one : {&pdf_, &pdf_light_, &pdf_on_}) one->resize(pairs);
  for (SpectrumPairs* each : {&weight_, &of_light_, &of_on_}) {
    for (Pairs& one : each->c) one.resize(pairs);
  }
}

// ---------------------------------------------------------------- while paths are followed

void PathReuse::begin(const PathState& paths, const HitState& hits, int n) {
  size_ = n;
  any_shared_ = false;
  for_each_component([n](const auto& from, auto& to) { std::copy_n(from, n, to); }, paths.origin, origin_[0]);
  for_each_component([n](const auto& from, auto& to) { std::copy_n(from, n, to); }, paths.direction,
                     direction_[0]);
  HitState::for_each([n](const auto& from, auto& to) { std::copy_n(from, n, to); }, hits, hits_[0]);
  std::fill_n(shared_, kPadded, 0);
  for (auto& lanes : own_.c) std::fill_n(lanes, n, 0.0f);
}

void PathReuse::keep_second(const PathState& paths, const HitState& hits, int n) {
  for (int i = 0; i < n; i += kWidth) {
    const Mask active = Mask::first(n - i);
    const Int slot = Int::load(paths.slot + i);
    const auto keep = [&](const auto& from, auto& to) {
      for_each_component(
          [&](const auto& source, auto& lanes) {
            using Value = std::remove_cvref_t<decltype(lanes[0])>;
            if constexpr (std::is_same_v<Value, float>) {
              scatter(Float::load(source + i), lanes, slot, active);
            } else {
              scatter(Int::load(source + i), lanes, slot, active);
            }
          },
          from, to);
    };
    keep(paths.origin, origin_[1]);
    keep(paths.direction, direction_[1]);
    HitState::for_each(keep, hits, hits_[1]);
  }
}

void PathReuse::at_first(const Vertex& v, Int slot, Mask hit) {
  scatter_lanes(v.surface.p, first_, slot, hit);
}

void PathReuse::set_apart(Int slot, Mask lanes, SampleBatch& batch) {
  const Spectrum before = gather_lanes<Spectrum>(own_, slot, lanes);
  scatter_lanes(before + batch.take_radiance(slot, lanes), own_, slot, lanes);
}

namespace {

/// The path begins anew: what it finds is to be weighted later. Roulette goes on as before.
TESSERA_INLINE void begin_anew(WidePath& path, Mask lanes) {
  path.roulette_scale = select(lanes, path.roulette_scale * path.beta.max_component(), path.roulette_scale);
  path.beta = select(lanes, Spectrum(1.0f), path.beta);
}

}  // namespace

void PathReuse::at_second(const Vertex& v, WidePath& path, Mask hit, SampleBatch& batch) {
  const Mask found = joinable(v, hit) & (path.pdf > 0.0f);
  const Mask lambertian =
      reflects_only(v.at) & ((v.at.flags & kLambertian) != 0) & ((v.at.flags & kHasBump) == 0);
  const Mask even = found & lambertian;
  // Most of the black ones are lamps.
  const Mask bright = and_not(even, is_black(v.at.params.spectra[slot::kReflectance]));
  const Mask kept = and_not(found, even) | bright;
  if (none(kept)) return;
  scatter_lanes(v.surface.p, p_, path.slot, kept);
  scatter_lanes(face_forward(v.surface.ng, v.wo), ng_, path.slot, kept);
  scatter_lanes(face_forward(v.at.frame.z, v.wo), ns_, path.slot, kept);
  scatter(v.surface.error, error_, path.slot, kept);
  scatter(select(bright, Int(kEven), Int(kGlossy)), shared_, path.slot, kept);
  if (none(bright)) return;
  any_shared_ = true;
  set_apart(path.slot, bright, batch);
  begin_anew(path, bright);
}

void PathReuse::at_third(WidePath& path, Mask hit, SampleBatch& batch) {
  const Int shared = gather(shared_, path.slot, hit);
  const Mask lanes = hit & has(shared, kGlossy) & (path.pdf > 0.0f);
  if (none(lanes)) return;
  any_shared_ = true;
  scatter(shared | Int(kBeyond), shared_, path.slot, lanes);
  scatter_lanes(path.direction, on_, path.slot, lanes);
  set_apart(path.slot, lanes, batch);
  begin_anew(path, lanes);
}

Mask PathReuse::share_light(Int slot, Vec3 wi, Float pdf, Mask delta, Mask lanes, SampleBatch& batch) {
  const Int shared = gather(shared_, slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy);
  if (none(taken)) return taken;
  any_shared_ = true;
  scatter(shared | select(delta, Int(kLight | kDelta), Int(kLight)), shared_, slot, taken);
  scatter_lanes(wi, to_light_, slot, taken);
  scatter(pdf, light_pdf_, slot, taken);
  set_apart(slot, taken, batch);
  return taken;
}

Mask PathReuse::share_emission(const WidePath& path, Spectrum radiance, Float by_lights, Mask lanes) {
  const Int shared = gather(shared_, path.slot, lanes);
  const Mask taken = lanes & has(shared, kGlossy) & (path.pdf > 0.0f);
  if (none(taken)) return taken;
  any_shared_ = true;
  scatter(shared | Int(kFound), shared_, path.slot, taken);
  scatter_lanes(path.direction, on_, path.slot, taken);
  scatter_lanes(radiance, found_, path.slot, taken);
  scatter(by_lights, found_pdf_, path.slot, taken);
  return taken;
}

void PathReuse::lights_traced(SampleBatch& batch) {
  if (!any_shared_) return;
  for (int first = 0; first < size_; first += kWidth) {
    const Mask lanes = has(Int::load(shared_ + first), kLight);
    if (none(lanes)) continue;
    store_lanes(batch.radiance(first), light_, first);
    batch.set_radiance(select(lanes, Spectrum(0.0f), batch.radiance(first)), first);
  }
}

// ---------------------------------------------------------------- once they have ended

void PathReuse::finish(SampleBatch& batch, ConnectionQueue& queue) {
  if (!any_shared_) return;
  const StageTimer timer(stats_.times, Stage::kShadow);
  for (int first = 0; first < size_; first += kWidth) collect(first, batch);
  for (int first = 0; first < size_; first += kWidth) {
    if (any(Int::load(shared_ + first) != 0)) join(first, batch, queue);
  }
  trace(queue);
  for (int first = 0; first < size_; first += kWidth) {
    if (any(Int::load(shared_ + first) != 0)) hand_out(first, batch);
  }
}

/// Leaves the sample with what is its own, and shared_ with what has brought any light.
void PathReuse::collect(int first, SampleBatch& batch) {
  const Mask active = Mask::first(size_ - first);
  const Int shared = select(active, Int::load(shared_ + first), Int(0));
  const Spectrum rest = batch.radiance(first);
  Spectrum own, light, found;
  load_lanes(own_, first, own);
  load_lanes(light_, first, light);
  load_lanes(found_, first, found);
  const Mask suffix = has(shared, kEven | kBeyond), sampled = has(shared, kLight), met = has(shared, kFound);
  store_lanes(select(suffix, rest, Spectrum(0.0f)), suffix_, first);
  store_lanes(select(sampled, light, Spectrum(0.0f)), light_, first);
  batch.set_radiance(own + select(suffix, Spectrum(0.0f), rest), first);
  const Int bits = select(and_not(suffix, is_black(rest)), shared & Int(kEven | kBeyond), Int(0)) |
                   select(and_not(sampled, is_black(light)), shared & Int(kLight | kDelta), Int(0)) |
                   select(and_not(met, is_black(found)), Int(kFound), Int(0));
  bits.store(shared_ + first);
}

Vertex PathReuse::vertex_at(const Vec3Lanes& origin, const Vec3Lanes& direction, const HitState& hits,
                            int event, int first, const SampleBatch& batch, Mask lanes) const {
  Vertex v;
  Vec3 o, d;
  load_lanes(origin, first, o);
  load_lanes(direction, first, d);
  v.wo = -d;
  v.time = Float(0.0f);
  v.surface = surface_at(scene_.shapes, load_hit(hits, first), o, d, lanes, scene_.any_tangents);
  const int pair = dimension::kFirstEvent + event * dimension::kPairsPerEvent + dimension::kRoulette;
  const Float mix = scene_.any_mix ? batch.sampler(Int::iota(first), lanes).get_2d(pair).y : Float(0.0f);
  interact(scene_, v.surface, v.wo, mix, lanes, v.at);
  return v;
}

void PathReuse::join(int first, const SampleBatch& batch, ConnectionQueue& queue) {
  const Int slot = Int::iota(first), shared = Int::load(shared_ + first);
  const Mask seen = Mask::first(size_ - first) & (Int::load(hits_[0].shape + first) >= 0);
  const Vertex v = vertex_at(origin_[0], direction_[0], hits_[0], 0, first, batch, seen);
  const Mask wanted = joinable(v, seen);
  for (int step = 0; step < group_; ++step) {
    const Int partner = slot ^ Int(step);
    Mask lanes = wanted & (gather(shared_, partner) != 0);
    Float pdf(0.0f);
    Spectrum weight(0.0f);
    if (any(lanes)) {
      const Vec3 p = gather_lanes<Vec3>(p_, partner, lanes), ng = gather_lanes<Vec3>(ng_, partner, lanes),
                 ns = gather_lanes<Vec3>(ns_, partner, lanes);
      const Way to = way(v.surface.p, p);
      const Float cosine = -dot(ng, to.w);
      lanes &= (to.squared > 0.0f) & (cosine > 0.0f) & (dot(ns, to.w) < 0.0f);
      const BsdfEval bsdf = eval_scattering(scene_, v, to.w, lanes);
      // Where nothing is scattered, paths end.
      lanes = and_not(lanes & (bsdf.pdf > 0.0f), is_black(bsdf.f_cos));
      const Float by_area = cosine / select(lanes, to.squared, 1.0f);
      pdf = select_or_zero(lanes, bsdf.pdf * by_area);
      weight = select(lanes, bsdf.f_cos * by_area, Spectrum(0.0f));
      if (step > 0 && any(lanes)) {
        // From offset to offset.
        WideConnection ray = connect(scene_, v, to.w, fma(ng, gather(error_, partner, lanes), p), lanes);
        ray.slot = slot + step * kPadded;
        if (queue.size + kWidth > kBatch) trace(queue);
        queue.size += append(scene_, ray, lanes, queue, queue.size);
      }
    }
    pdf.store_unaligned(pdf_.data() + pair(step, first));
    for (int c = 0; c < kSpectrumLanes; ++c)
      weight.c[c].store_unaligned(weight_.c[c].data() + pair(step, first));
  }
  const Mask glossy = has(shared, kLight | kFound | kBeyond);
  if (none(glossy)) return;
  const Vertex second = vertex_at(origin_[1], direction_[1], hits_[1], 1, first, batch, glossy);
  if (any(has(shared, kLight))) scatter_back(first, second, to_light_, Int(kLight), of_light_, pdf_light_);
  if (any(has(shared, kFound | kBeyond)))
    scatter_back(first, second, on_, Int(kFound | kBeyond), of_on_, pdf_on_);
}

/// From second surfaces that share `which` to the first ones of all of their group, of light along `wi`.
void PathReuse::scatter_back(int first, const Vertex& second, const Vec3Lanes& wi, Int which,
                             SpectrumPairs& value, Pairs& pdf) const {
  const Int slot = Int::iota(first);
  const Mask lanes = (Int::load(shared_ + first) & which) != 0;
  Vec3 along, ng, ns;
  load_lanes(wi, first, along);
  load_lanes(ng_, first, ng);
  load_lanes(ns_, first, ns);
  for (int step = 0; step < group_; ++step) {
    const Int to = slot ^ Int(step);
    const Vec3 wo = way(second.surface.p, gather_lanes<Vec3>(first_, to, lanes)).w;
    const Mask seen = lanes & (dot(wo, ng) > 0.0f) & (dot(wo, ns) > 0.0f);
    const BsdfEval bsdf = eval_scattering(scene_, second, wo, along, seen);
    const Int at = to + step * kPadded;
    for (int c = 0; c < kSpectrumLanes; ++c)
      scatter(select_or_zero(seen, bsdf.f_cos.c[c]), value.c[c].data(), at, lanes);
    scatter(select_or_zero(seen, bsdf.pdf), pdf.data(), at, lanes);
  }
}

void PathReuse::trace(ConnectionQueue& queue) {
  rays_.occluded(arrays_of(queue.origin, queue.direction, nullptr), queue.size, queue.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(queue.size);
  for (int i = 0; i < queue.size; ++i) {
    if (queue.distance[i] < 0) pdf_[static_cast<std::size_t>(queue.slot[i])] = 0;
  }
  queue.size = 0;
}

/// The density with which BSDF samples of any of the group find what these samples have found in a direction
/// at their second surface, of which `value` and `pdf` are.
Float PathReuse::density_along(int first, Mask lanes, const SpectrumPairs& value, const Pairs& pdf) const {
  Float sum(0.0f);
  if (none(lanes)) return sum;
  for (int step = 0; step < group_; ++step) {
    const Int from = Int::iota(first) ^ Int(step);
    // A path ends, too, where its two surfaces have no band in common.
    Mask goes_on = Mask::none();
    for (int c = 0; c < kSpectrumLanes; ++c)
      goes_on |= load(weight_.c[c], step, from) * load(value.c[c], step, from) > 0.0f;
    sum = fma(load(pdf_, step, from), select_or_zero(lanes & goes_on, load(pdf, step, from)), sum);
  }
  return sum;
}

void PathReuse::hand_out(int first, SampleBatch& batch) const {
  const Int slot = Int::iota(first), shared = Int::load(shared_ + first);
  // Densities with which any of the group finds what these samples have found.
  Float point(0.0f);
  for (int step = 0; step < group_; ++step) point = point + load(pdf_, step, slot ^ Int(step));
  const Mask beyond = has(shared, kBeyond), sampled = has(shared, kLight);
  const Float on = density_along(first, beyond | has(shared, kFound), of_on_, pdf_on_);
  const Float along = density_along(first, and_not(sampled, has(shared, kDelta)), of_light_, pdf_light_);
  const auto inverse = [](Float density) {
    return select_or_zero(density > 0.0f, 1.0f / max(density, 1e-37f));
  };
  alignas(64) float of_suffix[kWidth], of_light[kWidth], of_found[kWidth];
  inverse(select(beyond, on, point)).store(of_suffix);
  inverse(fma(point, Float::load(light_pdf_ + first), along)).store(of_light);
  inverse(fma(point, Float::load(found_pdf_ + first), on)).store(of_found);

  // All partners are of this packet.
  Spectrum sum = batch.radiance(first);
  for (int step = 0; step < group_; ++step) {
    const Int partner = slot ^ Int(step), lane = partner - first;
    const Mask seen = load(pdf_, step, slot) > 0.0f;
    const Int what = gather(shared_, partner, seen);
    const Mask suffix = seen & has(what, kEven | kBeyond), light = seen & has(what, kLight),
               found = seen & has(what, kFound), on_lanes = seen & has(what, kBeyond);
    const Float f_suffix = gather(of_suffix, lane), f_light = gather(of_light, lane),
                f_found = gather(of_found, lane);
    for (int c = 0; c < kSpectrumLanes; ++c) {
      Float back = gather(suffix_.c[c], partner, suffix) * f_suffix;
      if (any(on_lanes)) back = select(on_lanes, back * load(of_on_.c[c], step, slot), back);
      back = select_or_zero(suffix, back);
      const auto add = [&](const Lanes<float>& radiance, Float factor, const SpectrumPairs& value,
                           Mask lanes) {
        if (none(lanes)) return;
        const Float more = gather(radiance, partner, lanes) * factor * load(value.c[c], step, slot);
        back = back + select_or_zero(lanes, more);
      };
      add(light_.c[c], f_light, of_light_, light);
      add(found_.c[c], f_found, of_on_, found);
      sum.c[c] = sum.c[c] + select_or_zero(seen, load(weight_.c[c], step, slot) * back);
    }
  }
  batch.set_radiance(sum, first);
}

}  // namespace tessera::render::TESSERA_ISA
