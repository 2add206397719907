// A BSDF that comes from outside, as CONTRIBUTING tells how to add one.
#include <gtest/gtest.h>

#include "render/sampling/warp.h"
#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Scatters a part of the light, the same in all directions of wo's side.
class EvenBsdf final : public Bsdf {
 public:
  EvenBsdf() : Bsdf(kReflectsOnly) {}
  BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Transport, Mask active) const override {
    const Float pdf = select_or_zero(active & same_hemisphere(wo, wi), Float(kInv2Pi));
    return {params.spectra[slot::kReflectance] * pdf, pdf};
  }
  BsdfSample sample(const BsdfParams& params, Vec3 wo, Float, Vec2 u, Transport, Mask active) const override {
    const Vec3 w = square_to_cone(u, Float(1.0f));
    return {.wi = {w.x, w.y, copysign(w.z, wo.z)},
            .weight = params.spectra[slot::kReflectance],
            .pdf = Float(kInv2Pi),
            .eta = Float(1.0f),
            .valid = active & (w.z > 0.0f) & (wo.z != 0.0f),
            .specular = Mask::none(),
            .transmission = Mask::none()};
  }
  Spectrum albedo(const BsdfParams& params) const override { return params.spectra[slot::kReflectance]; }
};

TEST(ToyBsdf, ASphereInAnEvenSkyIsItsReflectance) {
  static const EvenBsdf model;
  const BsdfKind kind = add_bsdf(model);
  EXPECT_GE(kind, BsdfKind::kCount);
  const auto content =
      build_kernel_scene(R"(
      camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] }
               screen_window: [-0.6, 0.6, -0.6, 0.6] }
      film { width: 16 height: 16 }
      materials { name: 'even' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.4 b: 0.2 } } } } }
      shapes { sphere { radius: 1 } material: 'even' }
      lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } })",
                         16,
                         // A function of its own in material_kinds.cpp would set this.
                         [&](SceneArrays& arrays) { arrays.materials.materials[0].kind = kind; });
  ASSERT_NE(content, nullptr);
  constexpr std::uint32_t kSamples = 64;
  const wire::TileResult picture = render_tile<Wavefront>(*content, kSamples);
  const MeanRadiance mean(picture, kSamples);
  // Each path is scattered once, with the reflectance as its weight, and then sees a sky of radiance 1: the
  // sky is left to the BSDF, so that there is no noise, but for a few roundings of 6e-8.
  const double reflectance[3] = {0.8, 0.4, 0.2};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < picture.pixel_count(); ++i)
      ASSERT_NEAR(mean.of_pixel(c, i), reflectance[c], 1e-5) << c << " " << i;
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
