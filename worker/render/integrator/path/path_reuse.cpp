#include "render/integrator/path/path_reuse.h"

#include <algorithm>

#include "render/integrator/guide/guided_event.h"
#include "render/integrator/path/packing.h"
#include "render/integrator/stage_timer.h"

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

// ---------------------------------------------------------------- while paths are followed

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

/// The path begins anew: what it finds is to be weighted later. Roulette goes on as before.
TESSERA_INLINE void begin_anew(WidePath& path, Mask lanes) {
  path.roulette_scale = select(lanes, path.roulette_scale * path.beta.max_component(), path.roulette_scale);
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
  begin_anew(path, bright);
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
  begin_anew(path, taken);
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

// ---------------------------------------------------------------- once they have ended

template <class F>
void PathReuse::for_each_packet(const Samples& samples, F&& f) {
  for (int i = 0; i < samples.size; i += kWidth)
    f(i, Packet{Int::load(samples.slot + i), Mask::first(samples.size - i)});
}

void PathReuse::finish(SampleBatch& batch, ConnectionQueue& queue) {
  if (!any_shared_) return;
  const StageTimer timer(stats_.times, Stage::kShadow);
  for (int first = 0; first < size_; first += kWidth) collect(first, batch);
  list_samples();
  for_each_packet(firsts_, [&](int place, const Packet& firsts) { join(place, firsts, queue); });
  trace(queue);
  if (scene_.paths_pass)
    for_each_packet(firsts_, [&](int place, const Packet& firsts) { see_own(place, firsts); });
  for_each_packet(glossies_, [&](int, const Packet& seconds) { scatter_back(seconds); });
  for (const Samples* seconds : {&glossies_, &evens_})
    for_each_packet(*seconds, [&](int, const Packet& packet) { weigh(packet); });
  for_each_packet(firsts_, [&](int place, const Packet& firsts) { hand_out(place, firsts, batch); });
}

/// Leaves the sample with what is its own, and shared_ with what has brought any light.
void PathReuse::collect(int first, SampleBatch& batch) {
  const Int shared = Int::load(shared_ + first);
  if (none(shared != 0)) return;
  const Spectrum rest = batch.radiance(first);
  Spectrum own, light, found;
  load_lanes(own_, first, own);
  load_lanes(light_, first, light);
  load_lanes(found_, first, found);
  const Mask suffix = has(shared, kEven | kBeyond), sampled = has(shared, kLight), met = has(shared, kFound);
  store_lanes(select(suffix, rest, Spectrum(0.0f)), suffix_, first);
  batch.set_radiance(own + select(suffix, Spectrum(0.0f), rest), first);
  const Int bits = select(and_not(suffix, is_black(rest)), shared & Int(kEven | kBeyond), Int(0)) |
                   select(and_not(sampled, is_black(light)), shared & Int(kLight | kDelta), Int(0)) |
                   select(and_not(met, is_black(found)), Int(kFound), Int(0));
  bits.store(shared_ + first);
}

/// Few share in some scenes: packets are of those that do.
void PathReuse::list_samples() {
  const std::uint32_t whole_group = (1u << group_) - 1;
  firsts_.size = evens_.size = glossies_.size = 0;
  for (int first = 0; first < size_; first += kWidth) {
    const Int slot = Int::iota(first), shared = Int::load(shared_ + first);
    const std::uint32_t bits = (shared != 0).bits();
    std::uint32_t of_groups = 0;
    for (int i = 0; i < kWidth; i += group_)
      of_groups |= (bits >> i & whole_group) != 0 ? whole_group << i : 0;
    firsts_.append(slot, Mask::from_bits(of_groups) & (Int::load(first_event_ + first) >= 0));
    evens_.append(slot, has(shared, kEven));
    glossies_.append(slot, has(shared, kLight | kFound | kBeyond));
  }
  std::fill_n(place_, kPadded, -1);
  for (Samples* samples : {&firsts_, &evens_, &glossies_})
    Int(0).store_unaligned(samples->slot + samples->size);
  for_each_packet(firsts_, [&](int place, const Packet& firsts) {
    scatter(Int::iota(place), place_, firsts.slot, firsts.lanes);
  });
}

/// Event 0 or 1 of `samples`, counted from their first surfaces.
Vertex PathReuse::vertex_at(int event, const Packet& samples) const {
  const auto load = [&](const auto& lanes) { return gather(lanes, samples.slot, samples.lanes); };
  const Vec3 origin = gather_lanes<Vec3>(origin_[event], samples.slot, samples.lanes),
             direction = gather_lanes<Vec3>(direction_[event], samples.slot, samples.lanes);
  Hit hit;
  HitState::for_each([&](const auto& from, auto& to) { to = load(from); }, hits_[event], hit);
  hit.time = scene_.any_motion ? load(time_) : Float(0.0f);
  Vertex v;
  v.wo = -direction;
  v.time = hit.time;
  v.surface = surface_at(scene_.shapes, hit, origin, direction, samples.lanes, scene_.any_tangents);
  const Float mix = scene_.any_mix ? load(mix_[event]) : Float(0.0f);
  interact(scene_, v.surface, v.wo, mix, samples.lanes, v.at);
  return v;
}

void PathReuse::join(int place, const Packet& firsts, ConnectionQueue& queue) {
  const Int slot = firsts.slot, group = group_of(slot), event = gather(first_event_, slot);
  const Vertex v = vertex_at(0, firsts);
  Guided guided;
  if (guide_ != nullptr) {
    guided.density = gather(density_, slot, firsts.lanes);
    guided.followed = guided.known = firsts.lanes & (guided.density >= 0);
  }
  // One second surface of each group after the other: rays to one point are followed together.
  for (int member = 0; member < group_; ++member) {
    const Int partner = group + Int(member);
    // Paths of one length in front: all have the same number of events to go.
    Mask lanes = firsts.lanes & (gather(shared_, partner) != 0) & (gather(first_event_, partner) == event);
    Float pdf(0.0f);
    Spectrum weight(0.0f);
    if (any(lanes)) {
      const Vec3 p = gather_lanes<Vec3>(p_, partner, lanes), ng = gather_lanes<Vec3>(ng_, partner, lanes),
                 ns = gather_lanes<Vec3>(ns_, partner, lanes);
      const Way to = way(v.surface.p, p);
      const Float cosine = -dot(ng, to.w);
      lanes &= (to.squared > 0.0f) & (cosine > 0.0f) & (dot(ns, to.w) < 0.0f);
      BsdfEval bsdf = eval_scattering(scene_, v, to.w, lanes);
      if (guide_ != nullptr) bsdf.pdf = mixed_pdf(*guide_, guided, to.w, bsdf.pdf, lanes);
      // Where nothing is scattered, paths end.
      lanes = and_not(lanes & (bsdf.pdf > 0.0f), is_black(bsdf.f_cos));
      const Float by_area = cosine / select(lanes, to.squared, 1.0f);
      pdf = select_or_zero(lanes, bsdf.pdf * by_area);
      if (scene_.paths_pass) pdf = -pdf;
      weight = select(lanes, bsdf.f_cos * by_area, Spectrum(0.0f));
      // How much gets through counts for the sample's own second surface as well.
      if (const Mask asked = scene_.paths_pass ? lanes : lanes & (partner != slot); any(asked)) {
        // From offset to offset.
        WideConnection ray = connect(scene_, v, to.w, fma(ng, gather(error_, partner, lanes), p), asked);
        ray.slot = Int::iota(place) + Int(member * kPadded);
        if (scene_.paths_pass) ray.key = Int(0), ray.contribution = Spectrum(1.0f);
        if (queue.size + kWidth > kBatch) trace(queue);
        queue.size += append_at_end(scene_, ray, asked, queue, queue.size);
      }
    }
    const std::size_t at = pair(member, place);
    pdf.store_unaligned(pdf_.data() + at);
    for (int c = 0; c < kSpectrumLanes; ++c) weight.c[c].store_unaligned(weight_.c[c].data() + at);
  }
}

void PathReuse::trace(ConnectionQueue& queue) {
  if (scene_.paths_pass) {
    march(queue);
    return;
  }
  const float* times = scene_.any_motion ? queue.time : nullptr;
  rays_.occluded(arrays_of(queue.origin, queue.direction, times), queue.size, queue.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(queue.size);
  for (int i = 0; i < queue.size; ++i) {
    if (queue.distance[i] < 0) pdf_[static_cast<std::size_t>(queue.slot[i])] = 0;
  }
  queue.size = 0;
}

/// Multiplies the density and the weight of each pair by the transmittance of its ray, which is also the
/// probability with which a path gets there. Pairs whose ray is blocked keep their negative density.
void PathReuse::march(ConnectionQueue& queue) {
  transit_.march(Passenger::kPath, queue, room_, 0, [&](const WideConnection& ray, Mask arrived) {
    const Float through = ray.contribution.c[0];
    scatter(gather(pdf_.data(), ray.slot, arrived) * -through, pdf_.data(), ray.slot, arrived);
    for (Pairs& weight : weight_.c)
      scatter(gather(weight.data(), ray.slot, arrived) * through, weight.data(), ray.slot, arrived);
  });
}

/// Makes the densities of samples' own second surfaces positive: a path has been there, even if rounding
/// blocks the ray that was traced again.
void PathReuse::see_own(int place, const Packet& firsts) {
  const Int own = Int::iota(place) + (firsts.slot & Int(group_ - 1)) * Int(kPadded);
  scatter(abs(gather(pdf_.data(), own, firsts.lanes)), pdf_.data(), own, firsts.lanes);
}

/// The pairs of each group's `member` and the second surfaces of samples; sets `lanes` to those that see each
/// other.
Int PathReuse::seeing_pairs(int member, Int slot, Mask& lanes) const {
  const Int place = gather(place_, group_of(slot) + Int(member), lanes);
  lanes &= place >= 0;
  const Int pairs = place + (slot & Int(group_ - 1)) * Int(kPadded);
  lanes &= gather(pdf_.data(), pairs, lanes) > 0.0f;
  return pairs;
}

/// Light of to_light_ and on_, from second surfaces to the first ones of all of their group that see them.
void PathReuse::scatter_back(const Packet& seconds) {
  const Int slot = seconds.slot, shared = gather(shared_, slot);
  const Vertex second = vertex_at(1, seconds);
  const Mask sampled = has(shared, kLight), gone_on = has(shared, kFound | kBeyond);
  const Vec3 to_light = gather_lanes<Vec3>(to_light_, slot, seconds.lanes),
             on = gather_lanes<Vec3>(on_, slot, seconds.lanes);
  for (int member = 0; member < group_; ++member) {
    Mask lanes = seconds.lanes;
    const Int pairs = seeing_pairs(member, slot, lanes);
    if (none(lanes)) continue;
    const Vec3 wo = way(second.surface.p, gather_lanes<Vec3>(first_, group_of(slot) + Int(member), lanes)).w;
    scatter_along(second, wo, to_light, pairs, lanes & sampled, of_light_, pdf_light_);
    scatter_along(second, wo, on, pairs, lanes & gone_on, of_on_, pdf_on_);
  }
}

void PathReuse::scatter_along(const Vertex& second, Vec3 wo, Vec3 wi, Int pairs, Mask lanes,
                              SpectrumPairs& value, Pairs& pdf) const {
  if (none(lanes)) return;
  const BsdfEval bsdf = eval_scattering(scene_, second, wo, wi, lanes);
  for (int c = 0; c < kSpectrumLanes; ++c) scatter(bsdf.f_cos.c[c], value.c[c].data(), pairs, lanes);
  scatter(bsdf.pdf, pdf.data(), pairs, lanes);
}

/// The density, by direction, with which samples of the BSDF at the second surface find what has been found
/// there, for a path from the first one.
Float PathReuse::density_along(Int pairs, Mask lanes, const SpectrumPairs& value, const Pairs& pdf) const {
  if (none(lanes)) return Float(0.0f);
  // A path ends, too, where its two surfaces have no band in common.
  Mask goes_on = Mask::none();
  for (int c = 0; c < kSpectrumLanes; ++c)
    goes_on |= gather(weight_.c[c].data(), pairs, lanes) * gather(value.c[c].data(), pairs, lanes) > 0.0f;
  return gather(pdf.data(), pairs, lanes & goes_on);
}

/// Sums the densities of all ways in which the group finds what these samples have found.
void PathReuse::weigh(const Packet& seconds) {
  const Int slot = seconds.slot, shared = gather(shared_, slot);
  const Mask beyond = has(shared, kBeyond), found = has(shared, kFound), sampled = has(shared, kLight),
             again = and_not(sampled, has(shared, kDelta));
  Float point(0.0f), on(0.0f), along(0.0f);
  for (int member = 0; member < group_; ++member) {
    Mask lanes = seconds.lanes;
    const Int pairs = seeing_pairs(member, slot, lanes);
    if (none(lanes)) continue;
    const Float pdf = gather(pdf_.data(), pairs, lanes);
    point = point + pdf;
    on = fma(pdf, density_along(pairs, lanes & (beyond | found), of_on_, pdf_on_), on);
    along = fma(pdf, density_along(pairs, lanes & again, of_light_, pdf_light_), along);
  }
  const auto inverse = [](Float density) {
    return select_or_zero(density > 0.0f, 1.0f / max(density, 1e-37f));
  };
  scatter(inverse(select(beyond, on, point)), by_suffix_, slot, seconds.lanes);
  scatter(inverse(fma(point, gather(light_pdf_, slot, sampled), along)), by_light_, slot, seconds.lanes);
  scatter(inverse(fma(point, gather(found_pdf_, slot, found), on)), by_found_, slot, seconds.lanes);
}

void PathReuse::hand_out(int place, const Packet& firsts, SampleBatch& batch) const {
  const Int group = group_of(firsts.slot);
  Spectrum sum(0.0f);
  for (int member = 0; member < group_; ++member) {
    const auto of = [at = pair(member, place)](const Pairs& pairs) {
      return Float::load_unaligned(pairs.data() + at);
    };
    const Mask seen = firsts.lanes & (of(pdf_) > 0.0f);
    if (none(seen)) continue;
    const Int partner = group + Int(member), what = gather(shared_, partner, seen);
    const Mask suffix = seen & has(what, kEven | kBeyond), on = seen & has(what, kBeyond);
    const auto add = [&](const SpectrumLanes& radiance, const Lanes<float>& factor,
                         const SpectrumPairs& value, Mask lanes, Spectrum& back) {
      if (none(lanes)) return;
      const Float f = gather(factor, partner, lanes);
      for (int c = 0; c < kSpectrumLanes; ++c) {
        const Float more = gather(radiance.c[c], partner, lanes) * f;
        back.c[c] = back.c[c] + select_or_zero(lanes, more * of(value.c[c]));
      }
    };
    Spectrum back(0.0f);
    if (any(suffix)) {
      back = gather_lanes<Spectrum>(suffix_, partner, suffix) * gather(by_suffix_, partner, suffix);
      for (int c = 0; c < kSpectrumLanes; ++c) back.c[c] = select(on, back.c[c] * of(of_on_.c[c]), back.c[c]);
    }
    add(light_, by_light_, of_light_, seen & has(what, kLight), back);
    add(found_, by_found_, of_on_, seen & has(what, kFound), back);
    for (int c = 0; c < kSpectrumLanes; ++c)
      sum.c[c] = sum.c[c] + select_or_zero(seen, of(weight_.c[c]) * back.c[c]);
  }
  if (last_first_ > 0) {
    const Mask behind = firsts.lanes & (gather(first_event_, firsts.slot) > 0);
    sum = select(behind, sum * gather_lanes<Spectrum>(before_, firsts.slot, behind), sum);
  }
  batch.add_radiance(sum, firsts.slot, firsts.lanes);
}

}  // namespace tessera::render::TESSERA_ISA
