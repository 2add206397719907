#include "render/integrator/interaction.h"

#include "render/color/texture.h"
#include "render/core/constants.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kStride = sizeof(MaterialRecord) / 4;

/// Replaces mixed materials by one of their parts, with the probability that the mix gives.
Int resolve_mix(const SceneTables& scene, const Surface& surface, Int material, Float u, Mask active) {
  const MaterialRecord* records = scene.materials.materials.data();
  const auto* kinds = reinterpret_cast<const std::int32_t*>(&records->kind);
  // Mixes of mixes are acyclic (build/ sees to that); each level uses up part of u.
  for (;;) {
    const Mask mixed = active & (gather(kinds, material * kStride, active) == static_cast<std::int32_t>(BsdfKind::kMix));
    if (none(mixed)) return material;
    for_each_distinct(material, mixed, [&](std::int32_t m, Mask lanes) {
      const MaterialRecord& mix = records[m];
      Float amount(mix.scalars[0].value);
      if (mix.scalars[0].texture >= 0) {
        amount = clamp(eval_texture_scalar(scene.textures, mix.scalars[0].texture, texture_point(surface), lanes), 0.0f, 1.0f);
      }
      const Mask second = u < amount;
      material = select(lanes, select(second, Int(mix.mix_b), Int(mix.mix_a)), material);
      const Float rescaled = select(second, u / max(amount, 1e-30f), (u - amount) / max(1.0f - amount, 1e-30f));
      u = select(lanes, clamp(rescaled, 0.0f, kOneMinusEpsilon), u);
    });
  }
}

/// Overwrites the textured slots.
void look_up_textures(const SceneTables& scene, const Surface& surface, Int material, Int flags, Mask textured,
                      BsdfParams& params) {
  const MaterialRecord* records = scene.materials.materials.data();
  const auto* base = reinterpret_cast<const std::int32_t*>(records);
  const auto texture_at = [&](const std::int32_t& member) {
    const auto offset = &member - base;
    return select(textured, gather(base + offset, material * kStride, textured), Int(-1));
  };
  for (int i = 0; i < kMaterialSpectra; ++i) {
    const Int texture = texture_at(records->spectra[i].texture);
    for_each_distinct(texture, texture >= 0, [&](std::int32_t t, Mask lanes) {
      params.spectra[i] = select(lanes, eval_texture(scene.textures, t, texture_point(surface), lanes), params.spectra[i]);
    });
  }
  for (int i = 0; i < kMaterialScalars; ++i) {
    const Int texture = texture_at(records->scalars[i].texture);
    for_each_distinct(texture, texture >= 0, [&](std::int32_t t, Mask lanes) {
      Float value = eval_texture_scalar(scene.textures, t, texture_point(surface), lanes);
      // Scalars 0 and 1 are alphas, which pbrt's scenes give as roughness.
      if (i < 2) value = select((flags & kRemapAlpha) != 0, safe_sqrt(value), value);
      params.scalars[i] = select(lanes, value, params.scalars[i]);
    });
  }
}

/// eta = 1 and the k that gives a conductor the reflectance looked up for it [pbrt-v4].
void reflectance_to_k(Mask lanes, BsdfParams& params) {
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float r = clamp(params.spectra[1].c[c], 0.0f, 0.9999f);
    params.spectra[0].c[c] = select(lanes, Float(1.0f), params.spectra[0].c[c]);
    params.spectra[1].c[c] = select(lanes, 2.0f * sqrt(r / (1.0f - r)), params.spectra[1].c[c]);
  }
}

/// Tilts the shading normal as if the surface were displaced along it by the texture [Blinn 1978].
Vec3 bump(const SceneTables& scene, int texture, const Surface& s, Mask lanes, Vec3 ns) {
  // Half a thousandth of the parameter range: as pbrt does where it has no footprint.
  constexpr float kStep = 0.0005f;
  const TexturePoint at = texture_point(s);
  TexturePoint beside_u = at, beside_v = at;
  beside_u.uv.x = beside_u.uv.x + kStep;
  beside_v.uv.y = beside_v.uv.y + kStep;
  const Float here = eval_texture_scalar(scene.textures, texture, at, lanes);
  const Float along_u = eval_texture_scalar(scene.textures, texture, beside_u, lanes);
  const Float along_v = eval_texture_scalar(scene.textures, texture, beside_v, lanes);
  const Vec3 dpdu = s.dpdu + ns * ((along_u - here) * (1 / kStep));
  const Vec3 dpdv = s.dpdv + ns * ((along_v - here) * (1 / kStep));
  const Vec3 n = cross(dpdu, dpdv);
  const Float l2 = length_squared(n);
  const Mask usable = lanes & (l2 > 0.0f) & is_finite(l2);
  return select(usable, face_forward(normalize(n), ns), ns);
}

/// The normal that a tangent-space normal map gives.
Vec3 mapped_normal(const SceneTables& scene, int texture, const Surface& s, Mask lanes, Vec3 ns) {
  const Spectrum encoded = eval_texture(scene.textures, texture, texture_point(s), lanes);
  const Vec3 local{encoded.c[0] * 2.0f - 1.0f, encoded.c[1] * 2.0f - 1.0f, encoded.c[2] * 2.0f - 1.0f};
  const Vec3 n = Frame::from_normal_tangent(ns, s.dpdu).to_world(local);
  const Float l2 = length_squared(n);
  const Mask usable = lanes & (l2 > 0.0f);
  return select(usable, normalize(n), ns);
}

Vec3 bend_normal(const SceneTables& scene, const Surface& surface, Int material, Int flags, Mask active) {
  Vec3 ns = surface.ns;
  const Mask bumped = active & ((flags & kHasBump) != 0);
  if (none(bumped)) return ns;
  for_each_distinct(material, bumped, [&](std::int32_t m, Mask lanes) {
    const MaterialRecord& record = scene.materials.materials[m];
    if (record.normal_texture >= 0) ns = mapped_normal(scene, record.normal_texture, surface, lanes, ns);
    if (record.bump_texture >= 0) ns = bump(scene, record.bump_texture, surface, lanes, ns);
  });
  return ns;
}

}  // namespace

Interaction interact(const SceneTables& scene, const Surface& surface, Float u, Mask active) {
  const MaterialRecord* records = scene.materials.materials.data();
  const auto* base = reinterpret_cast<const float*>(records);
  Int material = surface.material;
  if (scene.any_mix) material = resolve_mix(scene, surface, material, u, active);

  Interaction at;
  const Int record = material * kStride;
  const auto constant_at = [&](const float& member) { return gather(base + (&member - base), record, active); };
  const auto* kinds = reinterpret_cast<const std::int32_t*>(&records->kind);
  at.kind = gather(kinds, record, active);
  at.flags = gather(&records->flags, record, active);
  // Only what some lane's model looks at.
  for (int c = 0; c < kSpectrumLanes; ++c) at.params.spectra[0].c[c] = constant_at(records->spectra[0].value[c]);
  const auto some_use = [&](std::int32_t flag) { return any(active & ((at.flags & flag) != 0)); };
  if (some_use(kUsesSecondSpectrum)) {
    for (int c = 0; c < kSpectrumLanes; ++c) at.params.spectra[1].c[c] = constant_at(records->spectra[1].value[c]);
  }
  if (some_use(kUsesAlphas)) {
    for (int i = 0; i < 2; ++i) at.params.scalars[i] = constant_at(records->scalars[i].value);
  }
  if (some_use(kUsesEta)) {
    at.params.scalars[2] = constant_at(records->scalars[2].value);
    at.params.coat_table = gather(&records->coat_table, record, active);
  }
  at.params.coat_tables = scene.materials.coat_tables.data();
  if (scene.any_textures) {
    const Mask textured = active & ((at.flags & kHasTextures) != 0);
    if (any(textured)) look_up_textures(scene, surface, material, at.flags, textured, at.params);
    const Mask reflective = textured & ((at.flags & kConductorReflectance) != 0);
    if (any(reflective)) reflectance_to_k(reflective, at.params);
  }

  if (!scene.any_tangents) {
    at.frame = Frame::from_normal(surface.ns);
    return at;
  }
  const Vec3 ns = bend_normal(scene, surface, material, at.flags, active);
  const Mask along = active & ((at.flags & kAnisotropic) != 0);
  const Frame isotropic = Frame::from_normal(ns);
  if (none(along)) {
    at.frame = isotropic;
    return at;
  }
  const Frame tangent = Frame::from_normal_tangent(ns, surface.dpdu);
  at.frame = {select(along, tangent.x, isotropic.x), select(along, tangent.y, isotropic.y), ns};
  return at;
}

BsdfEval eval_bsdf(const Interaction& at, Vec3 wo, Vec3 wi, Mask active) {
  const Vec3 lo = at.frame.to_local(wo), li = at.frame.to_local(wi);
  BsdfEval result{Spectrum(0.0f), Float(0.0f)};
  for_each_distinct(at.kind, active, [&](std::int32_t kind, Mask lanes) {
    const Bsdf* model = bsdf_model(static_cast<BsdfKind>(kind));
    if (!model) return;
    const BsdfEval one = model->eval(at.params, lo, li, lanes);
    result.f_cos = select(lanes, one.f_cos, result.f_cos);
    result.pdf = select(lanes, one.pdf, result.pdf);
  });
  return result;
}

BsdfSample sample_bsdf(const Interaction& at, Vec3 wo, Float u_lobe, Vec2 u, Mask active) {
  const Vec3 lo = at.frame.to_local(wo);
  BsdfSample result{lo, Spectrum(0.0f), Float(0.0f), Float(1.0f), Mask::none(), Mask::none(), Mask::none()};
  for_each_distinct(at.kind, active, [&](std::int32_t kind, Mask lanes) {
    const Bsdf* model = bsdf_model(static_cast<BsdfKind>(kind));
    if (!model) return;
    const BsdfSample one = model->sample(at.params, lo, u_lobe, u, lanes);
    result.wi = select(lanes, one.wi, result.wi);
    result.weight = select(lanes, one.weight, result.weight);
    result.pdf = select(lanes, one.pdf, result.pdf);
    result.eta = select(lanes, one.eta, result.eta);
    result.valid |= one.valid & lanes;
    result.specular |= one.specular & lanes;
    result.transmission |= one.transmission & lanes;
  });
  result.wi = at.frame.to_world(result.wi);
  return result;
}

Spectrum albedo_of(const Interaction& at, Mask active) {
  const auto is = [&](BsdfKind kind) { return active & (at.kind == static_cast<std::int32_t>(kind)); };
  Spectrum albedo(1.0f);
  albedo = select(is(BsdfKind::kDiffuse) | is(BsdfKind::kCoatedDiffuse), at.params.spectra[0], albedo);
  albedo = select(is(BsdfKind::kDiffuseTransmission), at.params.spectra[0] + at.params.spectra[1], albedo);
  // Reflectance of a conductor at normal incidence.
  const Mask metal = is(BsdfKind::kConductor);
  if (any(metal)) {
    const Spectrum one(1.0f), eta = at.params.spectra[0], k2 = at.params.spectra[1] * at.params.spectra[1];
    const Spectrum numerator = (eta - one) * (eta - one) + k2;
    const Spectrum denominator = (eta + one) * (eta + one) + k2;
    albedo = select(metal, numerator / denominator, albedo);
  }
  return albedo;
}

}  // namespace tessera::render::TESSERA_ISA
