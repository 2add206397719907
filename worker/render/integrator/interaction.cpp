#include "render/integrator/interaction.h"

#include <optional>

#include "render/bsdf/material_slots.h"
#include "render/color/texture.h"
#include "render/core/constants.h"
#include "render/sensor/footprint.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kStride = sizeof(MaterialRecord) / 4;

Int kind_of(const SceneTables& scene, Int record, Mask active) {
  const MaterialRecord* records = scene.materials.materials.data();
  return gather(reinterpret_cast<const std::int32_t*>(&records->kind), record * kStride, active);
}
Int flags_of(const SceneTables& scene, Int record, Mask active) {
  return gather(&scene.materials.materials.data()->flags, record * kStride, active);
}
/// Bsdf::traits a lane.
Int traits_of(Int kind, Mask active) {
  Int traits(0);
  for_each_distinct(kind, active, [&](std::int32_t k, Mask lanes) {
    traits = select(lanes, Int(bsdf_model(static_cast<BsdfKind>(k))->traits), traits);
  });
  return traits;
}
Mask is_mix(Int flags) { return (flags & kMixed) != 0; }

/// Where textures of what scatters light are looked up.
TexturePoint footprint_point(const SceneTables& scene, const Surface& s) {
  TexturePoint at = texture_point(s);
  if (scene.any_filtered && scene.footprint.on) set_footprint(scene.footprint, s.ng, s.dpdu, s.dpdv, at);
  return at;
}

Float amount_of(const SceneTables& scene, const MaterialRecord& mix, const Surface& surface, Mask lanes) {
  const ScalarSlot& slot = mix.scalars[slot::kMixAmount];
  if (slot.texture < 0) return Float(slot.value);
  return clamp(eval_texture_scalar(scene.textures, slot.texture, footprint_point(scene, surface), lanes),
               0.0f, 1.0f);
}

/// Materials on the way from the one that a shape names to those that have a BSDF.
struct Route {
  Int record;
  Mask mirrored = Mask::none();  // lanes that went from behind a surface to what is there
  Int inherited = Int(0);        // flags that mixes hand down to their parts

  /// Lanes seen from behind go on to what is there.
  void turn(const SceneTables& scene, Mask behind, Mask active) {
    const Mask turns =
        and_not(active & behind & ((flags_of(scene, record, active) & kHasBack) != 0), mirrored);
    if (none(turns)) return;
    record = select(turns, gather(&scene.materials.materials.data()->back, record * kStride, turns), record);
    mirrored |= turns;
  }

  /// Mixes go on to one of their parts, with the probability that the mix gives, until none is left.
  /// Materials do not contain themselves (scene/ sees to that); each level uses up part of u.
  void pick_parts(const SceneTables& scene, const Surface& surface, Mask behind, Float u, Mask active) {
    for (;;) {
      const Mask mixed = active & is_mix(flags_of(scene, record, active));
      if (none(mixed)) return;
      for_each_distinct(record, mixed, [&](std::int32_t m, Mask lanes) {
        const MaterialRecord& mix = scene.materials.materials[static_cast<std::size_t>(m)];
        const Float amount = amount_of(scene, mix, surface, lanes);
        const Mask second = u < amount;
        record = select(lanes, select(second, Int(mix.mix_b), Int(mix.mix_a)), record);
        inherited = select(lanes, inherited | (mix.flags & kOneSided), inherited);
        const Float rescaled =
            select(second, u / max(amount, 1e-30f), (u - amount) / max(1.0f - amount, 1e-30f));
        u = select(lanes, clamp(rescaled, 0.0f, kOneMinusEpsilon), u);
      });
      turn(scene, behind, mixed);
    }
  }
};

/// Steps in u and v over which a bump map is differentiated: half of what the footprint covers along them, so
/// that the slope is that of what the footprint averages [pbrt-v4]. The record's where there is none.
Vec2 bump_steps(const MaterialRecord& material, const TexturePoint& at) {
  const Float usual(material.bump_step);
  if (!at.has_footprint || (material.flags & kBendsSoftly) != 0) return {usual, usual};
  // Below, rounding of u and v would be more than 1 % of the slope.
  const Float least = max(max(abs(at.uv.x), abs(at.uv.y)), Float(1.0f)) * 1e-5f;
  const auto step = [&](Float along_x, Float along_y) {
    const Float sum = 0.5f * (abs(along_x) + abs(along_y));
    return select(sum > 0.0f, max(sum, least), usual);
  };
  return {step(at.duvdx.x, at.duvdy.x), step(at.duvdx.y, at.duvdy.y)};
}

/// Tilts the shading normal as if the surface were displaced along it by the texture [Blinn 1978].
Vec3 bump(const SceneTables& scene, const MaterialRecord& material, const Surface& s, Mask lanes) {
  const TexturePoint at = footprint_point(scene, s);
  const Vec2 step = bump_steps(material, at);
  TexturePoint beside_u = at, beside_v = at;
  beside_u.uv.x = beside_u.uv.x + step.x;
  beside_v.uv.y = beside_v.uv.y + step.y;
  beside_u.p = fma(s.dpdu, step.x, beside_u.p);
  beside_v.p = fma(s.dpdv, step.y, beside_v.p);
  const auto height = [&](const TexturePoint& p) {
    return eval_texture_scalar(scene.textures, material.bump_texture, p, lanes);
  };
  const Float here = height(at);
  const Float along_u = (height(beside_u) - here) * (1.0f / step.x),
              along_v = (height(beside_v) - here) * (1.0f / step.y);
  const Vec3 dpdu = fma(s.ns, along_u - dot(s.ns, s.dpdu), s.dpdu);
  const Vec3 dpdv = fma(s.ns, along_v - dot(s.ns, s.dpdv), s.dpdv);
  const Vec3 n = cross(dpdu, dpdv);
  const Float l2 = length_squared(n);
  const Mask usable = lanes & (l2 > 0.0f) & is_finite(l2);
  return select(usable, face_forward(normalize(n), s.ng), s.ns);
}

/// The normal that a tangent-space normal map gives.
Vec3 mapped_normal(const SceneTables& scene, int texture, const Surface& s, Mask lanes) {
  const Vec3 encoded = vec3_of(eval_texture(scene.textures, texture, footprint_point(scene, s), lanes));
  const Vec3 local{encoded.x * 2.0f - 1.0f, encoded.y * 2.0f - 1.0f, encoded.z * 2.0f - 1.0f};
  const Vec3 n = Frame::from_normal_tangent(s.ns, s.dpdu).to_world(local);
  const Float l2 = length_squared(n);
  const Mask usable = lanes & (l2 > 0.0f);
  return select(usable, normalize(n), s.ns);
}

Vec3 bend_normal(const SceneTables& scene, const Surface& surface, Int record, Mask bumped) {
  Surface s = surface;
  for_each_distinct(record, bumped, [&](std::int32_t m, Mask lanes) {
    const MaterialRecord& material = scene.materials.materials[static_cast<std::size_t>(m)];
    if (material.normal_texture >= 0)
      s.ns = select(lanes, mapped_normal(scene, material.normal_texture, s, lanes), s.ns);
    if (material.bump_texture >= 0) s.ns = select(lanes, bump(scene, material, s, lanes), s.ns);
  });
  return s.ns;
}

/// Bends the normal of bumped lanes; `along` becomes the tangent that goes with the shading normal.
Vec3 bump_normal(const SceneTables& scene, const Surface& surface, Vec3 wo, Int record, Mask bumped,
                 Vec3& along, MaterialPart& part) {
  part.ns = surface.ns;
  along = select(bumped, Frame::from_normal_tangent(surface.ns, along).x, along);
  Vec3 n = bend_normal(scene, surface, record, bumped);
  // Facets that wo does not see from the surface's side are seen by their mirror images [Schuessler et al.
  // 2017].
  const Mask soft = bumped & ((part.flags & kBendsSoftly) != 0);
  const Mask hidden = soft & (dot(wo, surface.ns) * dot(wo, n) <= 0.0f);
  n = select(hidden, surface.ns * (2.0f * dot(n, surface.ns)) - n, n);
  const Float cosine2 = sqr(dot(n, surface.ns));
  part.bump_alpha2 =
      select_or_zero(soft, min(0.125f * max(1.0f - cosine2, 0.0f) / max(cosine2, 1e-6f), 1.0f));
  return n;
}

void set_frame(const SceneTables& scene, const Surface& surface, Vec3 wo, Int record, Mask active,
               MaterialPart& part) {
  if (!scene.any_tangents) {
    part.frame = Frame::from_normal(surface.ns);
    return;
  }
  Vec3 ns = surface.ns, along = surface.dpdu;
  const Mask bumped = active & ((part.flags & kHasBump) != 0);
  if (any(bumped)) ns = bump_normal(scene, surface, wo, record, bumped, along, part);
  part.frame = Frame::from_normal(ns);
  const Mask turned = active & ((part.flags & kAnisotropic) != 0);
  if (none(turned)) return;
  const Frame tangent = Frame::from_normal_tangent(ns, along);
  part.frame.x = select(turned, tangent.x, part.frame.x);
  part.frame.y = select(turned, tangent.y, part.frame.y);
}

/// The normal of the layer above the base: by a map of its own, or as it is without maps.
void set_upper_normal(const SceneTables& scene, const Surface& surface, Int record, Mask active,
                      MaterialPart& part) {
  Vec3 normal = surface.ns;
  for_each_distinct(record, active, [&](std::int32_t m, Mask lanes) {
    const int texture = scene.materials.materials[static_cast<std::size_t>(m)].upper_normal_texture;
    if (texture >= 0) normal = select(lanes, mapped_normal(scene, texture, surface, lanes), normal);
  });
  part.params.upper_normal = part.frame.to_local(normal);
}

void load_part(const SceneTables& scene, const Surface& surface, Vec3 wo, const Route& route,
               const Spectra& spectra, Mask active, MaterialPart& part) {
  part.material = route.record;
  const MaterialRecord* common = nullptr;
  if (const std::optional<std::int32_t> same = common_value(route.record, active)) {
    common = &scene.materials.materials[static_cast<std::size_t>(*same)];
    part.kind = Int(static_cast<std::int32_t>(common->kind));
    part.flags = Int(common->flags);
    part.traits = Int(bsdf_model(common->kind)->traits);
  } else {
    part.kind = kind_of(scene, route.record, active);
    part.flags = flags_of(scene, route.record, active);
    part.traits = traits_of(part.kind, active);
  }
  if (scene.any_mix) {
    part.flags = part.flags | route.inherited;
    part.flags = select(route.mirrored, part.flags & ~std::int32_t{kOneSided}, part.flags);
  }
  load_constants(scene.materials, route.record, common, part.flags, spectra, active, part.params);
  if (incomplete(part.params)) {
    complete_parameters(scene.materials, scene.textures, footprint_point(scene, surface), route.record,
                        part.kind, spectra, active, part.params);
  }
  set_frame(scene, surface, wo, route.record, active, part);
  if ((part.params.some_flags & kUsesFurther) != 0)
    set_upper_normal(scene, surface, route.record, active & ((part.flags & kUsesFurther) != 0), part);
  part.lambertian = (part.params.some_flags & (kOneSided | kBendsSoftly)) == 0 &&
                    none(active & (part.kind != static_cast<std::int32_t>(BsdfKind::kDiffuse)));
}

/// Fills both parts of mixes; of mixes of mixes, one part of each.
void interact_mixed(const SceneTables& scene, const Surface& surface, Vec3 wo, Float u,
                    const Spectra& spectra, Mask active, Interaction& at) {
  Route first{surface.material};
  const Mask behind = dot(wo, surface.ns) < 0.0f;
  first.turn(scene, behind, active);
  const Int whole = first.record, whole_flags = flags_of(scene, whole, active);
  const Mask mixed = active & is_mix(whole_flags);
  Route second = first;
  at.amount = Float(0.0f);
  for_each_distinct(whole, mixed, [&](std::int32_t m, Mask lanes) {
    const MaterialRecord& mix = scene.materials.materials[static_cast<std::size_t>(m)];
    at.amount = select(lanes, amount_of(scene, mix, surface, lanes), at.amount);
    first.record = select(lanes, Int(mix.mix_a), first.record);
    second.record = select(lanes, Int(mix.mix_b), second.record);
  });
  if (any(mixed)) {
    first.inherited = second.inherited = select_or_zero(mixed, whole_flags & kOneSided);
    for (Route* route : {&first, &second}) {
      route->turn(scene, behind, mixed);
      route->pick_parts(scene, surface, behind, u, mixed);
    }
    load_part(scene, surface, wo, second, spectra, mixed, at.second);
  }
  load_part(scene, surface, wo, first, spectra, active, at);
  if (none(mixed)) return;
  at.material = whole;
  // Delta is what both are; opacity is that of the mix.
  constexpr std::int32_t kOwn = kHasOpacity | kPassesStraight;
  const Int both = (at.flags & at.second.flags & kAllDelta) | (whole_flags & kOwn) |
                   (at.flags & ~(kAllDelta | kOwn)) | (at.second.flags & kDisperses);
  at.flags = select(mixed, both | kMixed, at.flags);
  at.lambertian = false;
}

/// Lanes in which the part scatters light from wi to wo at all, given both in its frame.
Mask scatters(const MaterialPart& part, Vec3 lo, Vec3 wi, Float li_z, Mask active) {
  if (part.params.some_flags & kOneSided)
    active = and_not(active, ((part.flags & kOneSided) != 0) & (lo.z <= 0.0f));
  if (part.params.some_flags & kBendsSoftly) {
    // A bent normal must not make light shine through.
    active = and_not(active, ((part.flags & kBendsSoftly) != 0) & (dot(wi, part.ns) * li_z <= 0.0f));
  }
  return active;
}

/// Part of the light from wi that the bumps themselves do not shadow [Estevez et al. 2019]: without it bent
/// normals show a hard terminator. 1 where nothing is bent.
Float unshadowed(const MaterialPart& part, Vec3 wi) {
  const Float cosine2 = sqr(dot(wi, part.ns));
  const Float tangent2 = max(1.0f - cosine2, 0.0f) / max(cosine2, 1e-12f);
  const Float factor = 2.0f / (1.0f + sqrt(fma(part.bump_alpha2, tangent2, Float(1.0f))));
  return select((part.flags & kBendsSoftly) != 0, factor, 1.0f);
}

BsdfEval eval_part(const MaterialPart& part, Vec3 wo, Vec3 wi, Transport transport, Mask active) {
  const Vec3 lo = part.frame.to_local(wo), li = part.frame.to_local(wi);
  const Mask scattering = scatters(part, lo, wi, li.z, active);
  BsdfEval result{Spectrum(0.0f), Float(0.0f)};
  for_each_distinct(part.kind, scattering, [&](std::int32_t kind, Mask lanes) {
    const BsdfEval one = bsdf_model(static_cast<BsdfKind>(kind))->eval(part.params, lo, li, transport, lanes);
    result.f_cos = select(lanes, one.f_cos, result.f_cos);
    result.pdf = select(lanes, one.pdf, result.pdf);
  });
  if (part.params.some_flags & kBendsSoftly) result.f_cos *= unshadowed(part, wi);
  return result;
}

BsdfSample sample_part(const MaterialPart& part, Vec3 wo, Float u_lobe, Vec2 u, Transport transport,
                       Mask active) {
  const Vec3 lo = part.frame.to_local(wo);
  BsdfSample result{lo, Spectrum(0.0f), Float(0.0f), Float(1.0f), Mask::none(), Mask::none(), Mask::none()};
  for_each_distinct(part.kind, active, [&](std::int32_t kind, Mask lanes) {
    const BsdfSample one =
        bsdf_model(static_cast<BsdfKind>(kind))->sample(part.params, lo, u_lobe, u, transport, lanes);
    result.wi = select(lanes, one.wi, result.wi);
    result.weight = select(lanes, one.weight, result.weight);
    result.pdf = select(lanes, one.pdf, result.pdf);
    result.eta = select(lanes, one.eta, result.eta);
    result.valid |= one.valid & lanes;
    result.specular |= one.specular & lanes;
    result.transmission |= one.transmission & lanes;
  });
  const Float li_z = result.wi.z;
  result.wi = part.frame.to_world(result.wi);
  result.valid = scatters(part, lo, result.wi, li_z, result.valid);
  if (part.params.some_flags & kBendsSoftly) result.weight *= unshadowed(part, result.wi);
  return result;
}

/// `sample` is of one part of a mix, chosen with probability `share`: with what the other would do, chosen
/// with the rest. A part whose densities are not those of its samples cannot share in
/// the weight.
void weigh_other_part(const MaterialPart& own, const MaterialPart& other, Vec3 wo, Float share,
                      Transport transport, Mask lanes, BsdfSample& sample) {
  const Mask spread = and_not(lanes & sample.valid, sample.specular);
  if (none(spread)) return;
  const BsdfEval also = eval_part(other, wo, sample.wi, transport, spread);
  const Float chosen = share * sample.pdf, pdf = chosen + (1.0f - share) * also.pdf;
  const Spectrum f_cos = sample.weight * chosen + also.f_cos * (1.0f - share);
  const Mask exact = and_not(spread, ((own.traits | other.traits) & kEstimatedDensity) != 0);
  sample.weight = select(exact, f_cos * (1.0f / max(pdf, 1e-37f)), sample.weight);
  sample.pdf = select(spread, pdf, sample.pdf);
}

Float diffuse_share_of_part(const MaterialPart& part, Vec3 wo, Vec3 wi, Mask active) {
  Float share = select((part.traits & kAllDiffuse) != 0, Float(1.0f), Float(0.0f));
  const Mask some = active & ((part.traits & kSomeDiffuse) != 0);
  if (none(some)) return share;
  const Vec3 lo = part.frame.to_local(wo), li = part.frame.to_local(wi);
  for_each_distinct(part.kind, some, [&](std::int32_t kind, Mask lanes) {
    share = select(lanes, bsdf_model(static_cast<BsdfKind>(kind))->diffuse_share(part.params, lo, li, lanes),
                   share);
  });
  return share;
}

Spectrum albedo_of_part(const MaterialPart& at, Mask active) {
  Spectrum albedo(1.0f);
  for_each_distinct(at.kind, active, [&](std::int32_t kind, Mask lanes) {
    albedo = select(lanes, bsdf_model(static_cast<BsdfKind>(kind))->albedo(at.params), albedo);
  });
  return albedo;
}

}  // namespace

void interact(const SceneTables& scene, const Surface& surface, Vec3 wo, Float u, const Spectra& spectra,
              Mask active, Interaction& at) {
  if (scene.any_mix) {
    interact_mixed(scene, surface, wo, u, spectra, active, at);
  } else {
    load_part(scene, surface, wo, Route{surface.material}, spectra, active, at);
  }
}

BsdfEval eval_any_bsdf(const Interaction& at, Vec3 wo, Vec3 wi, Mask active, Transport transport) {
  BsdfEval result = eval_part(at, wo, wi, transport, active);
  const Mask mixed = active & ((at.flags & kMixed) != 0);
  if (none(mixed)) return result;
  const BsdfEval other = eval_part(at.second, wo, wi, transport, mixed);
  result.f_cos = select(mixed, lerp(at.amount, result.f_cos, other.f_cos), result.f_cos);
  result.pdf = select(mixed, lerp(at.amount, result.pdf, other.pdf), result.pdf);
  return result;
}

BsdfSample sample_bsdf(const Interaction& at, Vec3 wo, Float u_lobe, Vec2 u, Mask active,
                       Transport transport) {
  if (at.lambertian) {  // all that counts of wo is its cosine
    BsdfSample result = bsdf_model(BsdfKind::kDiffuse)
                            ->sample(at.params, {Float(0.0f), Float(0.0f), dot(wo, at.frame.z)}, u_lobe, u,
                                     transport, active);
    result.wi = at.frame.to_world(result.wi);
    return result;
  }
  const Mask mixed = active & ((at.flags & kMixed) != 0);
  if (none(mixed)) return sample_part(at, wo, u_lobe, u, transport, active);

  // One part, with what is left of u_lobe.
  const Mask second = mixed & (u_lobe < at.amount);
  const Float rest =
      select(second, u_lobe / max(at.amount, 1e-30f), (u_lobe - at.amount) / max(1.0f - at.amount, 1e-30f));
  u_lobe = select(mixed, clamp(rest, 0.0f, kOneMinusEpsilon), u_lobe);
  BsdfSample result = sample_part(at, wo, u_lobe, u, transport, and_not(active, second));
  weigh_other_part(at, at.second, wo, 1.0f - at.amount, transport, and_not(mixed, second), result);
  if (none(second)) return result;
  BsdfSample other = sample_part(at.second, wo, u_lobe, u, transport, second);
  weigh_other_part(at.second, at, wo, at.amount, transport, second, other);
  result.wi = select(second, other.wi, result.wi);
  result.weight = select(second, other.weight, result.weight);
  result.pdf = select(second, other.pdf, result.pdf);
  result.eta = select(second, other.eta, result.eta);
  result.valid = and_not(result.valid, second) | (other.valid & second);
  result.specular = and_not(result.specular, second) | (other.specular & second);
  result.transmission = and_not(result.transmission, second) | (other.transmission & second);
  return result;
}

Float diffuse_share(const Interaction& at, Vec3 wo, Vec3 wi, Mask active) {
  const Float share = diffuse_share_of_part(at, wo, wi, active);
  const Mask mixed = active & ((at.flags & kMixed) != 0);
  if (none(mixed)) return share;
  const Float other = diffuse_share_of_part(at.second, wo, wi, mixed);
  const Spectrum first = eval_part(at, wo, wi, Transport::kRadiance, mixed).f_cos * (1.0f - at.amount),
                 second = eval_part(at.second, wo, wi, Transport::kRadiance, mixed).f_cos * at.amount;
  return select(mixed, share_of(first * share + second * other, first + second), share);
}

Float least_alpha(const MaterialPart& part, Mask active) {
  Float alpha(0.0f);
  for_each_distinct(part.kind, active & ((part.traits & kReflectsOnly) != 0),
                    [&](std::int32_t kind, Mask lanes) {
                      const Bsdf& model = *bsdf_model(static_cast<BsdfKind>(kind));
                      alpha = select(lanes, model.least_alpha(part.params), alpha);
                    });
  return alpha;
}

Spectrum albedo_of(const Interaction& at, Mask active) {
  const Spectrum albedo = albedo_of_part(at, active);
  const Mask mixed = active & ((at.flags & kMixed) != 0);
  if (none(mixed)) return albedo;
  return select(mixed, lerp(at.amount, albedo, albedo_of_part(at.second, mixed)), albedo);
}

}  // namespace tessera::render::TESSERA_ISA
