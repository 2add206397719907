// Pictures through a hole of some size: integrators whose light lands on the film by connections agree with
// path tracing, where light goes straight, and where it is diffracted in RGB and by wavelength.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

struct HoleCase {
  const char* name;
  const char* integrator;
  const char* hole;
  const char* settings = "";
  double relative = 1e-3, seen = 0.03;
};
class ThroughAHole : public testing::TestWithParam<HoleCase> {};

TEST_P(ThroughAHole, AgreesWithPathTracing) {
  const HoleCase& c = GetParam();
  const std::string scene =
      absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.8 g: 0.5 b: 0.3 } } } }"),
                   lamp("disk { radius: 1 }", "two_sided: true", kAbove),
                   camera(absl::StrCat("pinhole { film_distance_mm: 50 units_per_mm: 0.01 ", c.hole, " }")));
  expect_agreement(pictures_of(scene, "path", 4, c.settings), pictures_of(scene, c.integrator, 4, c.settings),
                   c.relative, c.seen);
}

// A fifth of the scene's unit, so that blur is several pixels of the 32 wide; and holes whose first dark ring
// has a radius of 1.7 mm, where a pixel is 1 mm.
constexpr const char *kWide = "hole_mm: 20 diffraction: STRAIGHT",
                     *kNarrow = "hole_mm: 0.02 scene_distance: 4";

INSTANTIATE_TEST_SUITE_P(Integrators, ThroughAHole,
                         testing::Values(HoleCase{"light_straight", "light", kWide},
                                         HoleCase{"bdpt_straight", "bdpt", kWide},
                                         HoleCase{"mlt_straight", "mlt", kWide},
                                         HoleCase{"vcm_straight", "vcm", kWide, "", 0.01, 0.06},
                                         HoleCase{"light_fresnel", "light", kNarrow},
                                         HoleCase{"bdpt_fresnel", "bdpt", kNarrow},
                                         HoleCase{"light_spectral", "light", kNarrow, kSpectral, 1e-3, 0.06},
                                         HoleCase{"bdpt_spectral", "bdpt", kNarrow, kSpectral, 1e-3, 0.06},
                                         HoleCase{"mlt_spectral", "mlt", kNarrow, kSpectral, 1e-3, 0.06},
                                         HoleCase{"vcm_spectral", "vcm", kNarrow, kSpectral, 0.01, 0.1}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tessera::test
