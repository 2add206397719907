// Pictures through a lens system: integrators that join paths from both ends agree with path tracing,
// although no point of the scene is joined to this camera; and where nothing disperses, light of wavelengths
// agrees with RGB.
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

/// A double Gauss (US patent 3,552,829, example 1) with indices at the line d, fully open; a millimetre is a
/// hundredth of the scene's unit, so that most of the scene is out of focus. It vignettes the corners.
std::string camera_with_lens(const std::string& more = "") {
  return camera(absl::StrCat(R"(lens { lens {
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
    } focus_distance: 4.6 units_per_mm: 0.01 )",
                             more, " }"));
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

/// Bare surfaces, and a lamp in the picture that is bright enough for its ghosts to be seen beside it, and so
/// large that rays from the film find it in every batch: the errors of batches are those of no rare event.
std::string scene_with_ghosts(const std::string& lens) {
  return absl::StrCat(things(kDiffuse),
                      lamp("sphere { radius: 0.3 }", "scale: 10", "1,0,0,0.5, 0,1,0,1, 0,0,1,1.6, 0,0,0,1"),
                      kSky, camera_with_lens(lens));
}

TEST(Ghosts, OfLightsAreThoseOfTheFilm) {
  const std::string scene = scene_with_ghosts("ghosts: true");
  const Pictures of_film =
                     pictures_of(scene, "path", 3, absl::StrCat("lens_ghosts: LENS_GHOSTS_FILM", kAlone)),
                 of_lights = pictures_of(scene, "path", 3, "lens_ghosts: LENS_GHOSTS_LIGHTS"),
                 of_neither = pictures_of(scene_with_ghosts(""), "path", 3, kAlone);
  expect_same(of_film, of_lights, 1e-3);
  EXPECT_LT(p_value_of(differences_of(of_lights, of_neither)), 1e-6);
  // Samples of the lamp find its ghosts more often than rays from the film do.
  const auto noise = [](const Pictures& pictures) {
    double sum = 0;
    for (const Picture& picture : pictures)
      for (const Picture::Value& value : picture.values) sum += value.error * value.error;
    return sum;
  };
  EXPECT_LT(noise(of_lights), noise(of_film));
}

TEST(Ghosts, AreTheSameInLightOfWavelengths) {
  const std::string scene = scene_with_ghosts("ghosts: true");
  for (const char* const found : {"lens_ghosts: LENS_GHOSTS_FILM", "lens_ghosts: LENS_GHOSTS_LIGHTS"})
    expect_same(pictures_of(scene, "path", 2, found),
                pictures_of(scene, "path", 2, absl::StrCat(found, kSpectral)));
}

class WithGhosts : public testing::TestWithParam<std::tuple<Integrator, const char*>> {};

TEST_P(WithGhosts, AgreesWithPathTracing) {
  const auto& [integrator, found] = GetParam();
  const std::string scene = scene_with_ghosts("ghosts: true");
  expect_same(pictures_of(scene, "path", 3, "lens_ghosts: LENS_GHOSTS_LIGHTS"),
              pictures_of(scene, integrator.name, 3, absl::StrCat("lens_ghosts: LENS_GHOSTS_", found)),
              integrator.relative);
}

INSTANTIATE_TEST_SUITE_P(Integrators, WithGhosts,
                         testing::Combine(testing::Values(Integrator{"volpath"}, Integrator{"bdpt"},
                                                          Integrator{"mlt"}, Integrator{"vcm", 0.01}),
                                          testing::Values("FILM", "LIGHTS")),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param).name) + "_" + std::get<1>(test.param);
                         });

/// Lets light through in one corner, and half of it in a stripe.
TestBlobs blobs_with_aperture() {
  constexpr int kSide = 8;
  std::string pfm = "Pf\n8 8\n-1.0\n";
  for (int i = 0; i < kSide * kSide; ++i) {
    const int column = i % kSide, row = i / kSide;
    const float open = row < 3 && column > 3 ? 1.0f : column == 2 ? 0.5f : 0.0f;
    pfm.append(reinterpret_cast<const char*>(&open), sizeof(open));
  }
  TestBlobs blobs = light_blobs();
  blobs["aperture"] = pfm;
  return blobs;
}

struct ApertureCase {
  const char* name;
  const char* aperture;
};
class ThinLens : public testing::TestWithParam<std::tuple<ApertureCase, Integrator>> {};

TEST_P(ThinLens, LooksTheSameToAllIntegrators) {
  const auto& [aperture, integrator] = GetParam();
  const std::string scene = absl::StrCat(
      things(kDiffuse), lamp("disk { radius: 1 }", "two_sided: true", kAbove),
      camera(absl::StrCat("perspective { fov_degrees: 45 lens_radius: 0.3 focal_distance: 3.5 aperture { ",
                          aperture.aperture, " } }")));
  const TestBlobs blobs = blobs_with_aperture();
  expect_same(pictures_of(scene, "path", 3, "", blobs), pictures_of(scene, integrator.name, 3, "", blobs),
              integrator.relative);
}

INSTANTIATE_TEST_SUITE_P(
    Apertures, ThinLens,
    testing::Combine(
        testing::Values(ApertureCase{"picture",
                                     "image { digest: 'aperture' path: 'aperture.pfm' } ratio: 1.4"},
                        ApertureCase{"barrel", "blades: 6 barrel_length: 2.5 barrel_radius: 1.1"}),
        testing::Values(Integrator{"light"}, Integrator{"bdpt"}, Integrator{"mlt"}, Integrator{"vcm", 0.01})),
    [](const auto& test) {
      return std::string(std::get<0>(test.param).name) + "_" + std::get<1>(test.param).name;
    });

TEST(LensPictures, StopsThatArePicturesAreAsBrightInTheMiddle) {
  // Under a sky of radiance 1, pixels are what the pupil lets through over that in the middle.
  const std::string sky = absl::StrCat(
      kSky, camera_with_lens("stop_image { digest: 'aperture' path: 'aperture.pfm' } film_diagonal_mm: 1"));
  const TestBlobs blobs = blobs_with_aperture();
  expect_value(pictures_of(sky, "path", 1, "", blobs), 1, 0.01);
}

}  // namespace
}  // namespace tessera::test
