#include "render/textbook/irradiance_cache/irradiance_cache.h"

#include "render/transport/vertex/dimensions.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Bumps that bend softly shade their own BSDF.
Mask is_even(const MaterialPart& part) {
  return and_not((part.traits & kLambertian) != 0, (part.flags & kBendsSoftly) != 0);
}

/// Lobes all of which harmonics of so many bands can keep.
Mask is_wide(const MaterialPart& part, int bands, Mask lanes) {
  const Mask flat = and_not(lanes, (part.flags & kBendsSoftly) != 0);
  return is_even(part) | (flat & (least_alpha(part, flat) >= least_alpha_of(bands)));
}

/// The fractional part of x, which is not negative.
Float wrapped(Float x) { return min(x - floor(x), kOneMinusEpsilon); }

}  // namespace

Cacheable cacheable(const SceneTables& scene, const Vertex& v, Mask hit, int depth) {
  Cacheable result{Mask::none(), Mask::none()};
  if (depth + 1 >= scene.max_depth) return result;
  const Mask mixed = hit & ((v.at.flags & kMixed) != 0);
  result.even = hit & is_even(v.at);
  if (any(mixed)) result.even = and_not(result.even, mixed & ~is_even(v.at.second));
  const int bands = scene.irradiance_cache.glossy_bands;
  const Mask rest = and_not(hit, result.even);
  if (bands == 0 || none(rest)) return result;
  result.glossy = rest & is_wide(v.at, bands, rest);
  if (const Mask both = result.glossy & mixed; any(both))
    result.glossy = and_not(result.glossy, both & ~is_wide(v.at.second, bands, both));
  return result;
}

void IrradianceCached::met(Encounter& e) {
  if (cache_ == nullptr) return;
  const Vertex& v = e.vertex;
  WidePath& path = e.path;
  const Cacheable wanted = cacheable(scene_, v, e.on_surface, e.depth);
  if (none(wanted.any())) return;
  if (shown_) {
    const Mask shown = cache_->at_record(v.surface.p, wanted.glossy, wanted.any());
    const Spectrum red = color_of({1.0f, 0.0f, 0.0f});
    batch_.add_radiance(red, path.slot, shown);
    path.beta = select(shown, Spectrum(0.0f), path.beta);
  }
  e.settled |= settle_even(path, v, wanted.even) | settle_glossy(path, v, wanted.glossy, e.depth);
}

Mask IrradianceCached::settle_even(const WidePath& path, const Vertex& v, Mask wanted) {
  if (none(wanted)) return wanted;
  const Vec3 n = cached_normal(v);
  const Irradiance light = cache_->look_up(v.surface.p, n, wanted);
  if (none(light.found)) return light.found;
  // Towards the normal the cosine is 1.
  const Spectrum f = eval_bsdf(v.at, v.wo, n, light.found).f_cos;
  batch_.add_radiance(path.beta * f * light.value, path.slot, light.found);
  return light.found;
}

Mask IrradianceCached::settle_glossy(const WidePath& path, const Vertex& v, Mask wanted, int depth) {
  if (none(wanted)) return wanted;
  const GlossyCache::Light light =
      cache_->glossy().look_up(v.surface.p, cached_normal(v), lobe_of(path, v, wanted, depth), wanted);
  batch_.add_radiance(path.beta * light.value, path.slot, light.found);
  return light.found;
}

/// The numbers that would choose the path's next direction, and points of a lattice around them [Roberts
/// 2018], choose those of the lobe: together they cover the BSDF evenly.
Lobe IrradianceCached::lobe_of(const WidePath& path, const Vertex& v, Mask lanes, int depth) const {
  constexpr float kAcross = 0.7548776662f, kAlong = 0.5698402910f;
  const Sampler sampler = batch_.sampler(path.slot, lanes);
  const int first_pair = dimension::kFirstEvent + depth * dimension::kPairsPerEvent;
  const Vec2 u = sampler.get_2d(first_pair + dimension::kBsdfDirection);
  const Float choice = sampler.get_2d(first_pair + dimension::kChoice).y;
  Lobe lobe;
  for (int k = 0; k < Lobe::kDirections; ++k) {
    const auto step = static_cast<float>(k);
    const BsdfSample sample =
        sample_bsdf(v.at, v.wo, wrapped(choice + step / Lobe::kDirections),
                    {wrapped(u.x + step * kAcross), wrapped(u.y + step * kAlong)}, lanes);
    lobe.wi[k] = sample.wi;
    lobe.weight[k] = select_or_zero(sample.valid, sample.weight * (1.0f / Lobe::kDirections));
  }
  return lobe;
}

}  // namespace tessera::render::TESSERA_ISA
