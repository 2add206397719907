// An observer of paths that comes from outside, as CONTRIBUTING tells how to add one: it counts events and
// the light that they bring, and in a second test it ends paths.
#include <gtest/gtest.h>

#include <cmath>

#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Events on the ball, and lamps that paths meet after them.
struct Tally {
  int met = 0, scattered = 0, gone_on = 0, lamps = 0, lit = 0;
  double light = 0;  // sum of the first band over all samples
};

/// Sum of the first band over `lanes`.
double sum_of(const Spectrum& light, Mask lanes) {
  double sum = 0;
  for (int i = 0; i < kWidth; ++i)
    if ((lanes.bits() >> i & 1) != 0) sum += double{light.c[0].lane(i)};
  return sum;
}

class CountingPath final : public Wavefront, private PathObserver {
 public:
  explicit CountingPath(const IntegratorContext& context) : Wavefront(context) { add(*this); }

  static Tally tally;
  static bool settles;

 private:
  static Mask on_ball(const Encounter& e, Mask lanes) { return lanes & (e.vertex.surface.light < 0); }

  void met(Encounter& e) override {
    tally.met += count(on_ball(e, e.met));
    if (settles) e.settled = e.met;
  }
  void emitted(const Encounter& e, MetLight& light) override {
    if (e.depth > 0) tally.lamps += count(light.lanes);
    tally.light += sum_of(light.arriving * e.path.beta, light.lanes);
  }
  void lit(const Encounter& e, SampledLight& light) override {
    tally.lit += count(on_ball(e, light.lanes));
    tally.light += sum_of(light.ray.contribution, light.lanes);
  }
  void scattered(const Encounter& e, Scattering& s) override {
    tally.scattered += count(on_ball(e, s.lanes));
  }
  void ended(const Encounter& e, const Scattering& s) override {
    tally.gone_on += count(on_ball(e, s.alive));
  }
};
Tally CountingPath::tally;
bool CountingPath::settles = false;

constexpr std::uint32_t kSamples = 64;

/// A ball in the middle of a sphere that shines with radiance 1 and is black: all light of lamps comes to the
/// ball, and none twice.
wire::TileResult picture_of_ball() {
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
      film { width: 32 height: 32 }
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.4 b: 0.2 } } } } }
      materials { name: 'black' diffuse { reflectance { constant { rgb {} } } } }
      shapes { sphere { radius: 1 } material: 'paint' }
      shapes { sphere { radius: 9 } material: 'black'
               area_light { radiance { constant: 1 } two_sided: true } })",
                                          32);
  EXPECT_NE(content, nullptr);
  CountingPath::tally = {};
  return content == nullptr ? wire::TileResult{} : render_tile<CountingPath>(*content, kSamples);
}

/// The mean of the first band: the ball covers pi / 4 of the film.
constexpr double kExpected = M_PI / 4 * 0.8 + (1 - M_PI / 4);

TEST(ToyObserver, SeesAllEventsAndAllLight) {
  CountingPath::settles = false;
  const wire::TileResult picture = picture_of_ball();
  const Tally& tally = CountingPath::tally;
  const double samples = 32.0 * 32.0 * kSamples;
  EXPECT_NEAR(tally.met / samples, M_PI / 4, 2e-3);
  EXPECT_EQ(tally.scattered, tally.met);
  EXPECT_GT(tally.lit, tally.met / 2);
  EXPECT_LE(tally.lit, tally.met);
  // Paths that go on from a ball come to the lamp.
  EXPECT_EQ(tally.gone_on, tally.lamps);
  EXPECT_GT(tally.gone_on, tally.met * 9 / 10);
  const double mean = MeanRadiance(picture, kSamples).of_film(0);
  EXPECT_NEAR(mean, kExpected, 2e-3);
  EXPECT_NEAR(tally.light / samples, mean, 1e-5);
}

TEST(ToyObserver, EndsPathsThatItHasSettled) {
  CountingPath::settles = true;
  const wire::TileResult picture = picture_of_ball();
  const Tally& tally = CountingPath::tally;
  EXPECT_GT(tally.met, 0);
  EXPECT_EQ(tally.scattered, 0);
  EXPECT_EQ(tally.gone_on, 0);
  // Samples of the lamp weigh 1 then: the same light by them alone, with more noise.
  EXPECT_NEAR(MeanRadiance(picture, kSamples).of_film(0), kExpected, 5e-3);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
