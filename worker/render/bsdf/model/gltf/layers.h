// The layers of glTF's material, as light along one direction meets them.
#pragma once

#include "render/bsdf/model/gltf/facet_matter.h"

namespace tessera::render::TESSERA_ISA {

/// The coat's normal, where it is not that of the base.
struct CoatFrame {
  bool tilted = false;
  Frame frame;

  /// `normal` is in the shading frame, wo's side up.
  TESSERA_INLINE Vec3 to_local(Vec3 w) const { return tilted ? frame.to_local(w) : w; }
  TESSERA_INLINE Vec3 to_shading(Vec3 w) const { return tilted ? frame.to_world(w) : w; }
  /// Between the normal and a direction above the surface; `behind`: seen from the other side, by its mirror
  /// image, which has the normal turned over.
  TESSERA_INLINE Float cosine(Vec3 w, Mask behind) const {
    if (!tilted) return abs_cos_theta(w);
    const Vec3 n = frame.z;
    const Float along = fma(n.x, w.x, n.y * w.y);
    return max(fma(n.z, abs_cos_theta(w), select(behind, -along, along)), 0.0f);
  }
};

/// GGX with glTF's roughness.
TESSERA_INLINE Ggx coat_facets(const BsdfParams& params) {
  const Float alpha = max(sqr(params.extended[slot::kCoatRoughness]), kLeastLayerAlpha);
  return {alpha, alpha};
}

/// All that follows from the parameters and wo, mirrored to above the surface: reflectances, shares, and how
/// likely each lobe is to be sampled.
struct Layers : FacetMatter {
  Float diffuse, behind;  // shares: the base, and its part that transmits
  Float coat;
  CoatFrame coat_frame;
  Spectrum sheen;
  LayerRows coat_rows, sheen_rows;
  LayerEnergy out;                    // energy of the facets, along wo
  Float coat_out, sheen_out;          // part of the light along wo that coat and sheen reflect
  LayerShare base_out;                // part of it that the dielectric leaves to the base
  Float to_above, to_below, to_coat;  // probabilities; the rest goes to the facets

  /// `upper_normal` is that of the coat, in the frame that wo is in.
  TESSERA_INLINE Layers(const BsdfParams& params, Vec3 wo, Vec3 upper_normal, Mask below, Mask lanes)
      : FacetMatter(params, below, lanes),
        coat_rows(params, params.extended[slot::kCoatRoughness], lanes),
        sheen_rows(params, params.extended[slot::kSheenRoughness], lanes) {
    diffuse = select(inside, 0.0f, 1.0f - params.extended[slot::kMetallic] - glass);
    behind = select(params.with(kHasInside), 0.0f, params.extended[slot::kBehind]);
    coat = params.extended[slot::kCoat];
    sheen = clamp(params.extended_spectra[slot::kSheenColor], 0.0f, 1.0f);
    if ((params.some_flags & kUsesFurther) != 0) tilt_coat(params, upper_normal, below);

    out = rows.at(wo.z);
    base_out = base_factor(wo.z, out);
    coat_out = coat_energy(wo, Mask::none(), inside);
    sheen_out = select(inside, 0.0f, sheen_rows.at(wo.z).sheen);
    set_probabilities(params, wo);
  }

  static TESSERA_INLINE Spectrum behind_color(const BsdfParams& params) {
    return clamp(params.extended_spectra[slot::kBehindColor], 0.0f, 1.0f);
  }
  /// The share that the coat reflects along a direction, which is below the surface where `other_side`; where
  /// `under` it is not met.
  TESSERA_INLINE Float coat_energy(Vec3 w, Mask other_side, Mask under) const {
    return select_or_zero(
        and_not(coat > 0.0f, under),
        coat * coat_rows.at(coat_frame.cosine(w, other_side)).of(Float(kCoatReflectance), Float(1.0f)));
  }
  /// The rest of the probability, of facets with this reflectance: of reflection at them.
  TESSERA_INLINE Float reflection(const FacetReflectance& at) const {
    const Float reflected = at.all.mean(),
                refracted = glass * (1.0f - min(at.dielectric.mean(), 1.0f)) * base.mean();
    return select(refracted > 0.0f, reflected / max(reflected + refracted, 1e-20f), 1.0f);
  }
  TESSERA_INLINE Float to_facets() const { return 1.0f - to_above - to_below - to_coat; }

  static constexpr float kCoatReflectance = 0.04f;  // along the normal: index 1.5

 private:
  TESSERA_INLINE void tilt_coat(const BsdfParams& params, Vec3 normal, Mask below) {
    const Mask tilted = active & params.with(kUsesFurther) & (coat > 0.0f);
    coat_frame.tilted = any(tilted);
    if (!coat_frame.tilted) return;
    // From the other side, the normal is turned over, and the world mirrored at the surface.
    normal = {select(below, -normal.x, normal.x), select(below, -normal.y, normal.y), normal.z};
    coat_frame.frame = Frame::from_normal(select(tilted, normal, Vec3{0.0f, 0.0f, 1.0f}));
  }

  TESSERA_INLINE void set_probabilities(const BsdfParams& params, Vec3 wo) {
    const Float sheen_kept = min(sheen_out, 1.0f);
    const FacetReflectance at_facets = reflected(wo.z, out);
    const Float weakest_reflected =
        filmed ? at_facets.dielectric.mean() : mean_of(out.of(weakest, dielectric90));
    const Float refracted = glass * (1.0f - min(weakest_reflected, 1.0f)) * base.mean();
    const Float even = diffuse * mean_of(base_out), grazing = filmed ? max(f90, film_share) : f90;
    const Float above = even * (1.0f - behind) * base.mean() +
                        select(inside, 0.0f, (1.0f - out.mirror()) * grazing + sheen_kept * sheen.mean());
    const Float under = even * behind * behind_color(params).mean();
    // A tilted coat may be turned away from wo.
    to_coat = coat_frame.tilted ? select(coat_frame.to_local(wo).z > 0.0f, coat_out, 0.0f) : coat_out;
    const Float scale = (1.0f - to_coat) / max(at_facets.all.mean() + refracted + above + under, 1e-6f);
    to_above = select(inside, 0.0f, above * scale);
    to_below = select(inside, 0.0f, under * scale);
  }
};

}  // namespace tessera::render::TESSERA_ISA
