// An algorithm that comes from outside, as CONTRIBUTING tells how to add one: what a textbook needs of the
// renderer, and no more.
#include <gtest/gtest.h>

#include <cmath>

#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/vertex.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Shows each surface in its colour, the darker the more it turns away from the eye.
class FacingIntegrator final : public Integrator {
 public:
  explicit FacingIntegrator(const IntegratorContext& context)
      : scene_(context.scene), rays_(context.rays), batch_(context) {}

  bool render(SampleSource& work, Film& film, std::stop_token stop) override {
    while (batch_.start(work, paths_)) {
      if (stop.stop_requested()) return false;
      rays_.nearest(arrays_of(paths_.origin, paths_.direction, nullptr), batch_.size(), true, hits_.arrays());
      for (int i = 0; i < batch_.size(); i += kWidth) shade(i, Mask::first(batch_.size() - i));
      batch_.finish(film, false);
    }
    return true;
  }

 private:
  void shade(int i, Mask active) {
    const WidePath path = load(scene_, paths_, i);
    const Hit found = load_hit(hits_, i);
    const Mask hit = active & (found.shape >= 0);
    if (none(hit)) return;
    Vertex v;
    v.wo = -path.direction;
    v.surface = surface_at(scene_.shapes, found, path.origin, path.direction, hit, scene_.any_tangents);
    interact(scene_, v.surface, v.wo, Float(0.5f), spectra_of(scene_, path), hit, v.at);
    batch_.record_first_hit(v, found, path.slot, hit);
    batch_.add_radiance(path.beta * albedo_of(v.at, hit) * abs(dot(v.wo, v.at.frame.z)), path.slot, hit);
  }

  const SceneTables& scene_;
  const RayQuery& rays_;
  SampleBatch batch_;
  PathState paths_;
  HitState hits_;
};

TEST(ToyIntegrator, ASphereSeenFromFarIsItsColourTimesTheCosine) {
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
      film { width: 32 height: 32 }
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.4 b: 0.2 } } } } }
      shapes { sphere { radius: 1 } material: 'paint' })",
                                          32);
  ASSERT_NE(content, nullptr);
  constexpr std::uint32_t kSamples = 64;
  const wire::TileResult picture = render_tile<FacingIntegrator>(*content, kSamples);
  // The mean of the cosine over a disk of radius 1 is 2/3; it covers pi / 4 of the film. A Sobol' picture of
  // 65,536 samples errs by far less than the standard error of independent ones, 0.37 / 256 = 0.0015.
  const double expected = M_PI / 4 * 2 / 3, colour[3] = {0.8, 0.4, 0.2};
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(MeanRadiance(picture, kSamples).of_film(c), colour[c] * expected, 0.0015 * colour[c]) << c;
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
