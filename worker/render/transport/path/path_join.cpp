// Pairs of surfaces, once paths have ended.
#include <algorithm>

#include "render/integrator/stage_timer.h"
#include "render/sensor/sensor.h"
#include "render/transport/path/packing.h"
#include "render/transport/path/path_reuse.h"
#include "render/transport/vertex/dispersion.h"

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

}  // namespace

template <class F>
void PathReuse::for_each_packet(const Samples& samples, F&& f) {
  for (int i = 0; i < samples.size; i += kWidth)
    f(i, Packet{Int::load(samples.slot + i), Mask::first(samples.size - i)});
}

void PathReuse::finish(ConnectionQueue& queue) {
  if (!any_shared_) return;
  const StageTimer timer(stats_.times, Stage::kShadow);
  for (int first = 0; first < size_; first += kWidth) collect(first);
  list_samples();
  for_each_packet(firsts_, [&](int place, const Packet& firsts) { join(place, firsts, queue); });
  trace(queue);
  if (scene_.paths_pass)
    for_each_packet(firsts_, [&](int place, const Packet& firsts) { see_own(place, firsts); });
  for_each_packet(glossies_, [&](int, const Packet& seconds) { scatter_back(seconds); });
  for (const Samples* seconds : {&glossies_, &evens_})
    for_each_packet(*seconds, [&](int, const Packet& packet) { weigh(packet); });
  for_each_packet(firsts_, [&](int place, const Packet& firsts) { hand_out(place, firsts); });
}

/// Leaves the sample with what is its own, and shared_ with what has brought any light.
void PathReuse::collect(int first) {
  const Int shared = Int::load(shared_ + first);
  if (none(shared != 0)) return;
  const Spectrum rest = batch_.radiance(first);
  Spectrum own, light, found;
  load_lanes(own_, first, own);
  load_lanes(light_, first, light);
  load_lanes(found_, first, found);
  const Mask suffix = has(shared, kEven | kBeyond), sampled = has(shared, kLight), met = has(shared, kFound);
  store_lanes(select(suffix, rest, Spectrum(0.0f)), suffix_, first);
  batch_.set_radiance(own + select(suffix, Spectrum(0.0f), rest), first);
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
  std::fill_n(place_in_firsts_, kPadded, -1);
  for (Samples* samples : {&firsts_, &evens_, &glossies_})
    Int(0).store_unaligned(samples->slot + samples->size);
  for_each_packet(firsts_, [&](int place, const Packet& firsts) {
    scatter(Int::iota(place), place_in_firsts_, firsts.slot, firsts.lanes);
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
  interact(scene_, v.surface, v.wo, mix, batch_.spectra(samples.slot, samples.lanes), samples.lanes, v.at);
  return v;
}

void PathReuse::join(int place, const Packet& firsts, ConnectionQueue& queue) {
  const Int slot = firsts.slot, group = group_of(slot), event = gather(first_event_, slot);
  const Vertex v = vertex_at(0, firsts);
  const Int steered = steering_ != nullptr ? gather(steered_, slot, firsts.lanes) : Int(0);
  const Int alone = disperses(scene_) ? gather(dispersed_, slot, firsts.lanes) : Int(0);
  // One second surface of each group after the other: rays to one point are followed together.
  for (int member = 0; member < group_; ++member) {
    const Int partner = group + Int(member);
    // Paths of one length in front: all have the same number of events to go.
    Mask lanes = firsts.lanes & (gather(shared_, partner) != 0) & (gather(first_event_, partner) == event);
    if (disperses(scene_)) lanes &= gather(dispersed_, partner, lanes) == alone;
    Float pdf(0.0f);
    Spectrum weight(0.0f);
    if (any(lanes)) {
      const Vec3 p = gather_lanes<Vec3>(p_, partner, lanes), ng = gather_lanes<Vec3>(ng_, partner, lanes),
                 ns = gather_lanes<Vec3>(ns_, partner, lanes);
      const Way to = way(v.surface.p, p);
      const Float cosine = -dot(ng, to.w);
      lanes &= (to.squared > 0.0f) & (cosine > 0.0f) & (dot(ns, to.w) < 0.0f);
      BsdfEval bsdf = eval_scattering(scene_, v, to.w, lanes);
      if (steering_ != nullptr) bsdf.pdf = steering_->pdf(steered, to.w, bsdf.pdf, lanes);
      if (disperses(scene_)) bsdf.f_cos = first_alone(alone != 0, bsdf.f_cos);
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
        if (scene_.volumetric) ray.wavelengths = batch_.spectra(slot, asked).wavelengths();
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
  const Int place = gather(place_in_firsts_, group_of(slot) + Int(member), lanes);
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

void PathReuse::hand_out(int place, const Packet& firsts) const {
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
  const bool weighs = weighs_rays(scene_.sensor);
  if (last_first_ > 0 || weighs) {
    const Mask behind = weighs ? firsts.lanes : firsts.lanes & (gather(first_event_, firsts.slot) > 0);
    sum = select(behind, sum * gather_lanes<Spectrum>(before_, firsts.slot, behind), sum);
  }
  batch_.add_radiance(sum, firsts.slot, firsts.lanes);
}

}  // namespace tessera::render::TESSERA_ISA
