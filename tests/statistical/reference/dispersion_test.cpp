// Glass whose index varies with the wavelength: pictures of paths that carry four wavelengths, and end three
// of them where they are refracted, against quadrature over wavelengths of pictures in RGB, each of the index
// at one of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "spectra/color/rgb_space.h"
#include "spectra/light/daylight.h"
#include "spectra/matter/dispersion.h"
#include "spectra/observer/observer.h"
#include "statistical/reference/spectral_pictures.h"

namespace tessera::test {
namespace {

/// A heavy flint would have 25.
constexpr double kIndex = 1.5, kAbbe = 9;

struct Glass {
  const char* name;
  const char* kind;   // of the material's message
  const char* rough;  // its roughness
};
constexpr Glass kSmooth{"smooth", "dielectric", ""}, kThin{"thin", "thin_dielectric", ""},
    kRough{"rough", "dielectric", "roughness { u { constant: 0.25 } v { constant: 0.25 } }"};

std::string material(const Glass& glass, const std::string& index) {
  return absl::StrCat(glass.kind, " { ", index, " ", glass.rough, " }");
}

/// A ball and a slab of glass over a grey floor, below a grey lamp; another is seen through the ball, whose
/// edge each wavelength moves elsewhere.
std::string scene_of(const std::string& glass) {
  return absl::StrCat("materials { name: 'm' ", glass, R"( }
    materials { name: 'floor' diffuse { reflectance { constant { constant: 0.6 } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.7 } material: 'm'
      world_from_object { elements: [1,0,0,-0.7, 0,1,0,-0.3, 0,0,1,0.8, 0,0,0,1] } }
    shapes { box { low: [0.2, -0.8, 0.5] high: [1.4, 0.6, 0.9] } material: 'm'
      world_from_object { elements: [1,0,0,0, 0,1,0,0, 0.3,0,1,0, 0,0,0,1] } }
    shapes { disk { radius: 0.5 } area_light { two_sided: true radiance { constant: 3 } }
      world_from_object { elements: [1,0,0,-1, 0,1,0,1.1, 0,0,1,0.02, 0,0,0,1] } }
    shapes { disk { radius: 0.8 } area_light { two_sided: true radiance { constant: 3 } }
      world_from_object { elements: [1,0,0,0.2, 0,1,0,0.1, 0,0,1,2.6, 0,0,0,1] } } )",
                      camera(kPerspective));
}

Pictures pictures_of(const std::string& scene, const std::string& integrator, const std::string& settings,
                     std::uint32_t seed) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.max_depth = 5;
  request.settings = settings;
  request.spp = samples_of_form(integrator == "mlt" ? 512 : 4096);
  request.seed = seed;
  return measure_pictures(request);
}

/// The part of the picture's colour that is of wavelengths near each of `nodes`, which ascend: pictures are
/// linear between them.
std::vector<spectra::Triple> shares_of(const std::vector<double>& nodes) {
  const spectra::Curve daylight = spectra::unit_d65();
  const spectra::Matrix3 rgb_from_xyz = spectra::rgb_from_xyz(spectra::kRec709);
  std::vector<spectra::Triple> shares(nodes.size(), {0, 0, 0});
  spectra::Triple white = {0, 0, 0};
  for (int nm = 360; nm <= 830; ++nm) {
    const spectra::Triple seen = spectra::times(rgb_from_xyz, spectra::cie1931().at(nm));
    const auto above = std::clamp<std::ptrdiff_t>(std::ranges::upper_bound(nodes, nm) - nodes.begin(), 1,
                                                  std::ssize(nodes) - 1);
    const auto high = static_cast<std::size_t>(above);
    const double part = std::clamp((nm - nodes[high - 1]) / (nodes[high] - nodes[high - 1]), 0.0, 1.0);
    for (std::size_t c = 0; c < 3; ++c) {
      const double light = seen[c] * daylight.at(nm);
      shares[high - 1][c] += light * (1 - part);
      shares[high][c] += light * part;
      white[c] += light;
    }
  }
  for (spectra::Triple& share : shares)
    for (std::size_t c = 0; c < 3; ++c) share[c] /= white[c];
  return shares;
}

/// Pictures by quadrature over wavelengths of this integrator's, each of seeds of its own.
const Pictures& quadrature(const Glass& glass, const std::string& integrator) {
  static std::vector<std::pair<std::string, Pictures>> known;
  for (const auto& [name, pictures] : known)
    if (name == glass.name + integrator) return pictures;
  const std::vector<double> nodes = {380, 410, 435, 460, 485, 510, 535, 560, 585, 610, 640, 680, 740};
  const std::vector<spectra::Triple> shares = shares_of(nodes);
  const spectra::Dispersion index = spectra::abbe_dispersion(kIndex, kAbbe);
  Pictures sums;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::string eta = absl::StrCat("eta { constant: ", index.eta(nodes[i]), " }");
    const Pictures at_node =
        pictures_of(scene_of(material(glass, eta)), integrator, "", static_cast<std::uint32_t>(i) + 1);
    sums.resize(at_node.size());
    for (std::size_t seed = 0; seed < at_node.size(); ++seed) {
      const std::vector<Picture::Value>& values = at_node[seed].values;
      sums[seed].values.resize(values.size());
      for (std::size_t v = 0; v < values.size(); ++v) {
        const double share = shares[i][v % 3];
        Picture::Value& sum = sums[seed].values[v];
        sum.mean += share * values[v].mean;
        sum.error = std::hypot(sum.error, share * values[v].error);
      }
    }
  }
  return known.emplace_back(glass.name + integrator, sums).second;
}

struct Way {
  const char* name;
  Glass glass;
  const char* integrator;
  const char* settings;
  // Lines between 13 wavelengths are off by less than 0.2 %; light that is merged is blurred.
  double relative = 3e-3;
  const char* reference = "path";  // photons are held against photons, which are blurred alike
};

class Dispersion : public testing::TestWithParam<Way> {};

TEST_P(Dispersion, IsAsQuadratureOverWavelengthsHasIt) {
  const Way& way = GetParam();
  const std::string glass =
      material(way.glass, absl::StrCat("dispersion { abbe { index: ", kIndex, " number: ", kAbbe, " } }"));
  const Pictures& expected = quadrature(way.glass, way.reference);
  const Pictures actual =
      pictures_of(scene_of(glass), way.integrator, absl::StrCat(kSpectral, way.settings), 100);
  expect_same(actual, expected, way.relative);
}

INSTANTIATE_TEST_SUITE_P(
    Ways, Dispersion,
    testing::Values(Way{"SmoothPath", kSmooth, "path", kAlone}, Way{"SmoothShared", kSmooth, "path", kShared},
                    Way{"SmoothBdpt", kSmooth, "bdpt", ""}, Way{"SmoothMlt", kSmooth, "mlt", ""},
                    Way{"SmoothVcm", kSmooth, "vcm", "", 0.02},
                    Way{"SmoothPhoton", kSmooth, "photon", "", 3e-3, "photon"},
                    Way{"RoughPath", kRough, "path", kAlone}, Way{"RoughShared", kRough, "path", kShared},
                    Way{"RoughLight", kRough, "light", ""}, Way{"RoughBdpt", kRough, "bdpt", ""},
                    Way{"RoughMlt", kRough, "mlt", ""}, Way{"RoughVcm", kRough, "vcm", "", 0.02},
                    Way{"RoughPhoton", kRough, "photon", "", 3e-3, "photon"},
                    Way{"RoughGuided", kRough, "guided", ""}, Way{"ThinPath", kThin, "path", kAlone},
                    Way{"ThinBdpt", kThin, "bdpt", ""}),
    [](const auto& way) { return std::string(way.param.name); });

/// The comparison would see light that is not dispersed.
TEST(DispersionOfGlass, IsSeen) {
  const Pictures plain = pictures_of(
      scene_of(material(kSmooth, absl::StrCat("eta { constant: ", kIndex, " }"))), "path", "", 200);
  EXPECT_LT(p_value_of(differences_of(plain, quadrature(kSmooth, "path"), 3e-3)), 1e-6);
}

/// A scene with no light but the sky's, of which glass takes none, whatever its index is.
TEST(DispersionOfGlass, LosesNoLight) {
  for (const Glass& glass : {kSmooth, kThin}) {
    SCOPED_TRACE(glass.name);
    const std::string scene =
        absl::StrCat("materials { name: 'm' ", material(glass, "dispersion { glass: 'diamond' }"), R"( }
        shapes { sphere { radius: 1 } material: 'm' } )",
                     kSky, camera(kPerspective));
    PictureRequest request;
    request.scene = scene;
    request.max_depth = 60;
    request.settings = kSpectral;
    request.spp = samples_of_form(2048);
    expect_value(measure_pictures(request), 1, 2e-3);
  }
}

}  // namespace
}  // namespace tessera::test
