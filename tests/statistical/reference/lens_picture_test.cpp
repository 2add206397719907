// Pictures through a lens system: integrators that join paths from both ends agree with path tracing,
// although no point of the scene is joined to this camera; and where nothing disperses, light of wavelengths
// agrees with RGB.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

/// A double Gauss (US patent 3,552,829, example 1) with indices at the line d, fully open; a millimetre is a
/// hundredth of the scene's unit, so that most of the scene is out of focus. It vignettes the corners.
std::string camera_with_lens() {
  return camera(R"(lens { lens {
      surfaces { radius_mm: 56.655 thickness_mm: 5.24 diameter_mm: 38.5 index: 1.815 }
      surfaces { radius_mm: 600 thickness_mm: 0.565 diameter_mm: 38.5 }
      surfaces { radius_mm: 25.68 thickness_mm: 6.56 diameter_mm: 33.5 index: 1.694 }
      surfaces { radius_mm: 51.875 thickness_mm: 0.8 diameter_mm: 28.716 }
      surfaces { radius_mm: 84.6 thickness_mm: 2.255 diameter_mm: 34 index: 1.63003 }
      surfaces { radius_mm: 17.295 thickness_mm: 5.865 diameter_mm: 24.5 }
      surfaces { thickness_mm: 5.565 diameter_mm: 24.1 stop: true }
      surfaces { radius_mm: -19.475 thickness_mm: 2.855 diameter_mm: 24 index: 1.7918 }
      surfaces { radius_mm: 246.02 thickness_mm: 6.185 diameter_mm: 31 index: 1.8004 }
      surfaces { radius_mm: -35.965 thickness_mm: 0.095 diameter_mm: 31 }
      surfaces { radius_mm: -125.895 thickness_mm: 4.05 diameter_mm: 31.5 index: 1.8004 }
      surfaces { radius_mm: -37.625 thickness_mm: 0.095 diameter_mm: 31.5 }
      surfaces { radius_mm: 198.13 thickness_mm: 4.05 diameter_mm: 31.5 index: 1.71615 }
      surfaces { radius_mm: -63.025 thickness_mm: 36.5 diameter_mm: 31.5 }
    } focus_distance: 4.6 units_per_mm: 0.01 })");
}

struct Integrator {
  const char* name;
  double relative = 1e-3, seen = 0.03;
};
class ThroughALens : public testing::TestWithParam<Integrator> {};

TEST_P(ThroughALens, AgreesWithPathTracing) {
  const std::string scene =
      absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.8 g: 0.5 b: 0.3 } } } }"),
                   lamp("disk { radius: 1 }", "two_sided: true", kAbove), camera_with_lens());
  expect_agreement(pictures_of(scene, "path", 4, ""), pictures_of(scene, GetParam().name, 4, ""),
                   GetParam().relative, GetParam().seen);
}

// Merging blurs.
INSTANTIATE_TEST_SUITE_P(Integrators, ThroughALens,
                         testing::Values(Integrator{"bdpt"}, Integrator{"mlt"},
                                         Integrator{"vcm", 0.01, 0.06}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(LensPictures, AreTheSameInLightOfWavelengthsWhereNothingDisperses) {
  const std::string scene = absl::StrCat(R"(
      materials { name: 'm' dielectric { eta { constant: 1.5 } } }
      materials { name: 'floor' diffuse { reflectance { constant { constant: 0.5 } } } }
      shapes { disk { radius: 3 } material: 'floor' }
      shapes { sphere { radius: 0.6 } material: 'm'
        world_from_object { elements: [1,0,0,-0.6, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } } )",
                                         kSky, kLamp, camera_with_lens());
  for (const char* const integrator : {"path", "bdpt"}) {
    SCOPED_TRACE(integrator);
    expect_agreement(pictures_of(scene, integrator, 4, ""), pictures_of(scene, integrator, 4, kSpectral),
                     1e-3, 0.03);
  }
}

}  // namespace
}  // namespace tessera::test
