// Pictures through a hole of some size: integrators whose light lands on the film by connections agree with
// path tracing, where light goes straight, and where it is diffracted in RGB and by wavelength.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

/// No shading normals, which make light tracing noisy.
constexpr const char* kBallOnFloor = R"(
    materials { name: 'ball' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.5 b: 0.3 } } } } }
    materials { name: 'floor' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.5 b: 0.4 } } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.6 } material: 'ball'
      world_from_object { elements: [1,0,0,-0.8, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } } )";

struct HoleCase {
  const char* name;
  const char* integrator;
  const char* hole;
  const char* settings = "";
  double relative = 1e-3, seen = 0.03;
  std::uint32_t spp = 2048;
};
class ThroughAHole : public testing::TestWithParam<HoleCase> {};

TEST_P(ThroughAHole, AgreesWithPathTracing) {
  const HoleCase& c = GetParam();
  const std::string scene = absl::StrCat(
      kBallOnFloor, lamp("disk { radius: 1 }", "two_sided: true", kAbove),
      test::camera(absl::StrCat("pinhole { film_distance_mm: 50 units_per_mm: 0.01 ", c.hole, " }")));
  const auto pictures = [&](const char* integrator) {
    return pictures_of(scene, integrator, 4, c.settings, light_blobs(), c.spp);
  };
  expect_agreement(pictures("path"), pictures(c.integrator), c.relative, c.seen);
}

// A fifth of the scene's unit, so that blur is several pixels of the 32 wide; and holes whose first dark ring
// has a radius of 1.7 mm, where a pixel is 1 mm.
constexpr const char *kWideHole = "hole_mm: 20 diffraction: STRAIGHT",
                     *kNarrowHole = "hole_mm: 0.02 scene_distance: 4";

// Noise asks for more samples of light tracing, which seldom finds the ball's shade, and of vcm, each of
// whose passes has one set of wavelengths.
INSTANTIATE_TEST_SUITE_P(
    Integrators, ThroughAHole,
    testing::Values(HoleCase{"light_straight", "light", kWideHole, "", 1e-3, 0.03, 16384},
                    HoleCase{"bdpt_straight", "bdpt", kWideHole}, HoleCase{"mlt_straight", "mlt", kWideHole},
                    HoleCase{"vcm_straight", "vcm", kWideHole, "", 0.01, 0.06},
                    HoleCase{"light_fresnel", "light", kNarrowHole, "", 1e-3, 0.03, 8192},
                    HoleCase{"bdpt_fresnel", "bdpt", kNarrowHole},
                    HoleCase{"light_spectral", "light", kNarrowHole, kSpectral, 1e-3, 0.12},
                    HoleCase{"bdpt_spectral", "bdpt", kNarrowHole, kSpectral, 1e-3, 0.12},
                    HoleCase{"mlt_spectral", "mlt", kNarrowHole, kSpectral, 1e-3, 0.12},
                    HoleCase{"vcm_spectral", "vcm", kNarrowHole, kSpectral, 0.01, 0.2, 8192}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tessera::test
