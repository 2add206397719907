#include "render/integrator/irradiance_cache/irradiance_cache.h"

namespace tessera::render::TESSERA_ISA {

Mask is_cacheable(const SceneTables& scene, const Vertex& v, Mask hit, int depth) {
  if (depth + 1 >= scene.max_depth) return Mask::none();
  // Bumps that bend softly shade their own BSDF.
  const auto is_even = [](const MaterialPart& part) {
    return (part.flags & (kLambertian | kBendsSoftly)) == Int(kLambertian);
  };
  const Mask mixed = hit & ((v.at.flags & kMixed) != 0);
  Mask even = hit & is_even(v.at);
  if (any(mixed)) even = and_not(even, mixed & ~is_even(v.at.second));
  return even;
}

Mask IrradianceCached::settle(WidePath& path, const Vertex& v, Float, Mask hit, int depth) {
  if (cache_ == nullptr) return Mask::none();
  const Mask wanted = is_cacheable(scene_, v, hit, depth);
  if (none(wanted)) return wanted;
  const Vec3 n = cached_normal(v);
  if (shown_) {
    const Mask shown = cache_->at_record(v.surface.p, wanted);
    const Spectrum red = spectrum_of({1.0f, 0.0f, 0.0f});
    batch_.add_radiance(red, path.slot, shown);
    path.beta = select(shown, Spectrum(0.0f), path.beta);
  }
  const Irradiance light = cache_->look_up(v.surface.p, n, wanted);
  if (none(light.found)) return light.found;
  // Towards the normal the cosine is 1.
  const Spectrum f = eval_bsdf(v.at, v.wo, n, light.found).f_cos;
  batch_.add_radiance(path.beta * f * light.value, path.slot, light.found);
  return light.found;
}

}  // namespace tessera::render::TESSERA_ISA
