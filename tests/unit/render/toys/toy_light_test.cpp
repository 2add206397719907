// A light that comes from outside, as CONTRIBUTING tells how to add one: its picture by paths from the eye
// and by paths from the light, and its power.
#include <gtest/gtest.h>

#include <cmath>

#include "render/light/light.h"
#include "render/light/positional_light.h"
#include "render/transport/light/light_tracer.h"
#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"
#include "wire/aov_channels.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A tiny Lambertian lamp that hangs down: its intensity goes with the cosine to -z.
class PendantLight final : public PositionalLight {
 public:
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    LightSample s = light_model(LightKind::kPoint).sample(table, light, from, u, active);
    s.radiance *= max(s.wi.z, 0.0f);
    s.valid &= s.wi.z > 0.0f;
    return s;
  }
  double power(const LightTable&, const LightRecord& light) const override {
    return std::numbers::pi * mean_radiance(light);
  }

 protected:
  Directions directions(const LightLanes&, Vec2 u) const override {
    const Vec3 w = square_to_cosine_hemisphere(u);
    return {{w.x, w.y, -w.z}, kPi / max(w.z, 1e-6f)};
  }
  Float direction_density(const LightLanes&, Vec3 w) const override { return max(-w.z, 0.0f) * kInvPi; }
};

/// The mean over the film of light on a floor of reflectance 0.5, as seen from above.
double expected_mean() {
  // Radiance 0.5 / pi I cos^2 / d^2 with I = 8 and the lamp 1 above: 4 / pi h^2 / (x^2 + y^2 + h^2)^2, over
  // the square of half side 1.
  double sum = 0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double x = (i + 0.5) / kSteps, y = (j + 0.5) / kSteps, d2 = x * x + y * y + 1;
      sum += 4 / M_PI / (d2 * d2);
    }
  }
  return sum / (kSteps * kSteps);
}

TEST(ToyLight, IsSeenAlikeFromTheEyeAndFromTheLight) {
  static const PendantLight model;
  const LightKind kind = add_light_model(model);
  EXPECT_GE(kind, LightKind::kCount);
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,-1,0,0, 0,0,-1,4, 0,0,0,1] } }
      film { width: 32 height: 32 }
      shapes { disk { radius: 9 } }
      lights { point { position { z: 1 } intensity { rgb { r: 8 g: 8 b: 8 } } } })",
                                          32,
                                          // A case of its own in light_builder.cpp would set this.
                                          [&](SceneArrays& arrays) { arrays.lights.lights[0].kind = kind; });
  ASSERT_NE(content, nullptr);
  const LightTable& lights = content->arrays.lights;
  EXPECT_NEAR(lights.sources(kind).power(lights, lights.lights[0]), 8 * M_PI, 1e-6);

  constexpr std::uint32_t kSamples = 16, kGreen = 1;
  const wire::TileResult eye = render_tile<Wavefront>(*content, kSamples);
  // A smooth picture of stratified samples: its mean errs by less than a step between pixels, squared.
  EXPECT_NEAR(MeanRadiance(eye, kSamples).of_film(kGreen), expected_mean(), 1e-3 * expected_mean());

  // 16,384 paths, a third of which land on the film: the standard error is about 1.4 / 128 of the mean for
  // independent ones, and Sobol's are better.
  const wire::TileResult passes = render_passes<LightTracer>(*content, kSamples);
  EXPECT_NEAR(MeanRadiance(passes, kSamples).of_film(kGreen), expected_mean(), 0.04 * expected_mean());
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
