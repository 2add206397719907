// Pictures that sensors and bands make of light of wavelengths, against quadrature over wavelengths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_response.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/spectral_pictures.h"
#include "wire/algorithm.h"

namespace tessera::test {
namespace {

constexpr std::size_t kFirstBand = 4;  // behind R, G, B and A

Pictures seen(const std::string& scene, const std::string& integrator, std::uint32_t depth,
              const std::string& settings) {
  return pictures_of(scene, integrator, depth, absl::StrCat(kSpectral, settings));
}

/// Fails unless some channels of the whole pictures have this value, within their noise and a part of it.
void expect_whole(const Pictures& pictures, std::size_t channels, double expected, double relative) {
  std::vector<Difference> differences;
  for (std::size_t c = 0; c < channels; ++c)
    differences.push_back(difference_from_known(absl::StrCat("channel ", c),
                                                values_by_seed(pictures, &Picture::values, c), expected,
                                                relative, 0.05));
  expect_none(differences);
}

/// The inside of a sphere that emits a spectrum everywhere.
std::string within_light(const spectra::Curve& light) {
  return absl::StrCat("shapes { sphere { radius: 5 } area_light { two_sided: true radiance { ",
                      message_of(light), " } } } camera { perspective { fov_degrees: 60 } } ");
}

spectra::Curve line(float nm) { return {{nm - 2, nm, nm + 2}, {0, 5, 0}}; }

TEST(SensorPicture, AGreySceneIsGreyToACameraThatIsBalancedForItsLamp) {
  const spectra::Curve lamp = *spectra::find_illuminant("F2");
  const std::string scene = absl::StrCat(
      "materials { name: 'm' diffuse { reflectance { constant { constant: 0.6 } } } } "
      "shapes { disk { radius: 3 } material: 'm' } lights { infinite { radiance { ",
      message_of(lamp), " } } } ", camera(kPerspective));
  const std::string sensor = "sensor: 'nikon-d5100' ";
  const Pictures balanced = seen(scene, "path", 2, sensor + "white_balance: 'F2'"),
                 not_balanced = seen(scene, "path", 2, sensor + "white_balance: 'D65'");
  Pictures green = balanced;
  for (Picture& picture : green) {
    for (std::size_t v = 0; v < picture.values.size(); v += 3)
      picture.values[v] = picture.values[v + 2] = picture.values[v + 1];
  }
  expect_same(balanced, green, 1e-4);
  EXPECT_LT(p_value_of(differences_of(not_balanced, balanced, 0.1)), 1e-6);
}

TEST(SensorPicture, ASensorOfANarrowBandSeesLinesInItAndNoOthers) {
  const spectra::Curve light = line(546);
  const double of_daylight = integral(540, 552, [](double nm) { return spectra::unit_d65().at(nm); });
  expect_whole(seen(within_light(light), "path", 0, "sensor: 'band:540-552'"), 3, 10 / of_daylight, 1e-3);
  for (const Picture& beside : seen(within_light(light), "path", 0, "sensor: 'band:549-552'"))
    for (int c = 0; c < 3; ++c) EXPECT_EQ(beside.whole(c).mean, 0);
  // Infrared, which no observer sees.
  const double daylight = integral(880, 920, [](double nm) { return spectra::unit_d65().at(nm); });
  expect_whole(seen(within_light(line(900)), "path", 0, "sensor: 'band:880-920'"), 1, 10 / daylight, 1e-3);
}

/// A wall whose light between its own sides is known, and the radiance that it has.
struct Wall {
  static constexpr std::uint32_t kDepth = 2;
  const spectra::Curve curve{{360, 480, 520, 600, 640, 830}, {0.9f, 0.8f, 0.3f, 0.35f, 0.85f, 0.9f}};

  std::string scene() const {
    return absl::StrCat("materials { name: 'm' diffuse { reflectance { constant { ", message_of(curve),
                        " } } } } shapes { sphere { radius: 5 } material: 'm' area_light { two_sided: true "
                        "radiance { constant: 2 } } } camera { perspective { fov_degrees: 60 } } ");
  }
  double radiance(double nm) const {
    const double rho = curve.at(nm);
    return 2 * spectra::unit_d65().at(nm) * (1 + rho + rho * rho);
  }
};

struct BandsCase {
  const char* integrator;
  const char* film;
  const char* settings = "";
  double relative = 1e-3;  // what is merged may be off by this
  // Largest standard error of a band. Where all of a pass has four wavelengths, few are in any one band.
  double noise = 0.03;
};
std::string name_of(const testing::TestParamInfo<BandsCase>& bands) { return bands.param.integrator; }

class BandsOfLight : public testing::TestWithParam<BandsCase> {};

TEST_P(BandsOfLight, HoldTheRadianceOfTheirWavelengths) {
  const Wall wall;
  const std::string film = GetParam().film;
  const spectra::Bands bands = *spectra::parse_film(film);
  const Pictures pictures = seen(wall.scene(), GetParam().integrator, Wall::kDepth,
                                 absl::StrCat("film: '", film, "' ", GetParam().settings));
  std::vector<Difference> differences;
  for (int b = 0; b < bands.count; ++b) {
    const double expected =
        integral(bands.begin(b), bands.begin(b + 1), [&](double nm) { return wall.radiance(nm); }) /
        bands.width();
    differences.push_back(difference_from_known(
        absl::StrCat(bands.centre(b), " nm"),
        values_by_seed(pictures, &Picture::channels, kFirstBand + static_cast<std::size_t>(b)), expected,
        GetParam().relative, GetParam().noise));
  }
  expect_none(differences);
  // Red, green and blue beside them.
  const auto response =
      *spectra::sensor_response(*spectra::parse_sensor("cie1931"), spectra::unit_d65(), spectra::kRec709);
  spectra::Triple expected;
  for (std::size_t c = 0; c < 3; ++c)
    expected[c] = integral(360, 830, [&](double nm) { return wall.radiance(nm) * response.at(nm)[c]; });
  expect_color(pictures, expected, 2 * GetParam().relative);
}

INSTANTIATE_TEST_SUITE_P(
    Within, BandsOfLight,
    testing::Values(BandsCase{"path", "spectral:16:350-850", "direct_light: DIRECT_LIGHT_BSDF", 5e-4},
                    BandsCase{"photon", "spectral:4:350-850",
                              "photon { radius: 2 photons: 512 light: PHOTON_LIGHT_ALL }", 5e-3, 0.1}),
    &name_of);

std::string coloured_things() {
  return absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.7 g: 0.2 b: 0.1 } } } }"),
                      lamp("disk { radius: 1 }", "two_sided: true", kAbove), camera(kPerspective));
}

class BandsOfIntegrators : public testing::TestWithParam<BandsCase> {};

TEST_P(BandsOfIntegrators, AreThoseOfPathsFromTheCamera) {
  const std::string film = absl::StrCat("film: '", GetParam().film, "' ");
  const auto end = kFirstBand + static_cast<std::size_t>(spectra::parse_film(GetParam().film)->count);
  // Pixels that share light share wavelengths, too, and so the noise of bands.
  const Pictures path = seen(coloured_things(), "path", 3, film + kAlone),
                 other = seen(coloured_things(), GetParam().integrator, 3, film + GetParam().settings);
  for (const Pictures* pictures : {&path, &other})
    for (const Picture& picture : *pictures) ASSERT_EQ(picture.channels.size(), end);
  expect_same(path, other, GetParam().relative);
  const std::vector<Difference> differences =
      channel_differences(path, other, kFirstBand, GetParam().relative);
  expect_none(differences);
  for (std::size_t b = 0; b < differences.size(); ++b) {
    const double light = mean_of(values_by_seed(path, &Picture::channels, kFirstBand + b)).mean;
    EXPECT_LT(mean_of(differences[b].by_seed).error, GetParam().noise * light)
        << "band " << b << ": nothing can be told";
  }
}

INSTANTIATE_TEST_SUITE_P(All, BandsOfIntegrators,
                         testing::Values(BandsCase{"light", "spectral:8"}, BandsCase{"bdpt", "spectral:8"},
                                         BandsCase{"mlt", "spectral:8"},
                                         BandsCase{"guided", "spectral:8", kAlone},
                                         BandsCase{"vcm", "spectral:4", "", 0.01, 0.05}),
                         &name_of);

/// A sensor that sees all of the bands' wavelengths alike sees their sum, of each sample.
TEST(SensorPicture, BandsOfAllIntegratorsAddUpToWhatTheSensorSees) {
  const double of_daylight = integral(400, 700, [](double nm) { return spectra::unit_d65().at(nm); });
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    if (!algorithm.wavelengths) continue;
    SCOPED_TRACE(algorithm.name);
    PictureRequest request;
    request.scene = coloured_things();
    request.integrator = algorithm.name;
    request.max_depth = 3;
    request.settings = absl::StrCat(kSpectral, "film: 'spectral:6:400-700' sensor: 'band:400-700'");
    request.spp = 64;
    request.blobs = light_blobs();
    const Picture picture = measure_picture(request);
    ASSERT_EQ(picture.channels.size(), kFirstBand + 6);
    double sum = 0;
    for (std::size_t b = 0; b < 6; ++b) sum += 50 * picture.channels[kFirstBand + b].mean / of_daylight;
    EXPECT_GT(sum, 0);
    EXPECT_NEAR(sum, picture.whole(1).mean, 1e-4 * sum);
  }
}

}  // namespace
}  // namespace tessera::test
