// Pictures that sensors and bands make of light of wavelengths, against quadrature over wavelengths.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "spectra/light/daylight.h"
#include "spectra/light/illuminants.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_response.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

constexpr std::size_t kFirstBand = 4;  // behind R, G, B and A

Picture picture_of(const std::string& scene, const std::string& integrator, std::uint32_t depth,
                   const std::string& settings, std::uint32_t seed = 0) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.max_depth = depth;
  request.settings = absl::StrCat(" color: COLOR_SPECTRAL ", settings);
  request.spp = samples_of_form(2048);
  request.seed = seed;
  request.blobs = light_blobs();
  return measure_picture(request);
}

std::string message_of(const spectra::Curve& curve) {
  std::string text = "sampled { ";
  for (std::size_t i = 0; i < curve.nm.size(); ++i)
    absl::StrAppend(&text, "wavelengths_nm: ", curve.nm[i], " values: ", curve.values[i], " ");
  return text + "}";
}

/// The middle of each of many small steps: the integral of f between two wavelengths.
double integral(double from, double to, const std::function<double(double)>& f) {
  constexpr int kSteps = 4000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += f(from + (to - from) * (i + 0.5) / kSteps);
  return sum * (to - from) / kSteps;
}

void expect_near(const Picture::Value& value, double expected, double relative) {
  EXPECT_LT(value.error, 0.05 * std::abs(expected) + 1e-12) << "too noisy to tell anything";
  EXPECT_NEAR(value.mean, expected, 5 * value.error + relative * std::abs(expected));
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
  const Picture balanced = picture_of(scene, "path", 2, sensor + "white_balance: 'F2'"),
                not_balanced = picture_of(scene, "path", 2, sensor + "white_balance: 'D65'");
  ASSERT_FALSE(balanced.values.empty() || not_balanced.values.empty());
  for (std::size_t v = 0; v < balanced.values.size(); v += 3) {
    const Picture::Value green = balanced.values[v + 1];
    for (const std::size_t other : {v, v + 2}) {
      const Picture::Value value = balanced.values[other];
      EXPECT_NEAR(value.mean, green.mean, 6 * std::hypot(value.error, green.error) + 1e-4 * green.mean);
    }
  }
  EXPECT_GT(not_balanced.whole(0).mean, 1.1 * not_balanced.whole(2).mean);
}

TEST(SensorPicture, ASensorOfANarrowBandSeesLinesInItAndNoOthers) {
  const spectra::Curve light = line(546);
  const double in_daylight = integral(540, 552, [](double nm) { return spectra::unit_d65().at(nm); });
  const Picture seen = picture_of(within_light(light), "path", 0, "sensor: 'band:540-552'");
  ASSERT_FALSE(seen.values.empty());
  for (int c = 0; c < 3; ++c) expect_near(seen.whole(c), 10 / in_daylight, 1e-3);
  const Picture beside = picture_of(within_light(light), "path", 0, "sensor: 'band:549-552'");
  ASSERT_FALSE(beside.values.empty());
  for (int c = 0; c < 3; ++c) EXPECT_EQ(beside.whole(c).mean, 0);
  // Infrared, which no observer sees.
  const Picture infrared = picture_of(within_light(line(900)), "path", 0, "sensor: 'band:880-920'");
  const double daylight = integral(880, 920, [](double nm) { return spectra::unit_d65().at(nm); });
  ASSERT_FALSE(infrared.values.empty());
  expect_near(infrared.whole(0), 10 / daylight, 1e-3);
}

TEST(SensorPicture, BandsHoldTheRadianceOfTheirWavelengths) {
  const spectra::Curve wall{{360, 480, 520, 600, 640, 830}, {0.9f, 0.8f, 0.3f, 0.35f, 0.85f, 0.9f}};
  const std::string scene =
      absl::StrCat("materials { name: 'm' diffuse { reflectance { constant { ", message_of(wall),
                   " } } } } shapes { sphere { radius: 5 } material: 'm' area_light { two_sided: true "
                   "radiance { constant: 2 } } } camera { perspective { fov_degrees: 60 } } ");
  const std::string film = "spectral:16:350-850";
  const spectra::Bands bands = *spectra::parse_film(film);
  const Picture picture =
      picture_of(scene, "path", 2, absl::StrCat("film: '", film, "' direct_light: DIRECT_LIGHT_BSDF"));
  ASSERT_EQ(picture.channels.size(), kFirstBand + 16);
  const auto radiance = [&](double nm) {
    return 2 * spectra::unit_d65().at(nm) * (1 + wall.at(nm) + wall.at(nm) * wall.at(nm));
  };
  const auto response =
      *spectra::sensor_response(*spectra::parse_sensor("cie1931"), spectra::unit_d65(), spectra::kRec709);
  spectra::Triple from_measured = {0, 0, 0}, from_expected = {0, 0, 0}, error2 = {0, 0, 0};
  for (int b = 0; b < bands.count; ++b) {
    SCOPED_TRACE(bands.centre(b));
    const double expected = integral(bands.begin(b), bands.begin(b + 1), radiance) / bands.width();
    const Picture::Value& measured = picture.channels[kFirstBand + static_cast<std::size_t>(b)];
    expect_near(measured, expected, 5e-4);
    const spectra::Triple part = spectra::seen(response, bands.begin(b), bands.begin(b + 1));
    for (std::size_t c = 0; c < 3; ++c) {
      from_measured[c] += measured.mean * part[c], from_expected[c] += expected * part[c];
      error2[c] += measured.error * measured.error * part[c] * part[c];
    }
  }
  // Red, green and blue beside them are those of light itself; summed bands are those of steps of light.
  for (int c = 0; c < 3; ++c) {
    const double of_light = integral(
        360, 830, [&](double nm) { return radiance(nm) * response.at(nm)[static_cast<std::size_t>(c)]; });
    expect_near(picture.whole(c), of_light, 1e-3);
    EXPECT_NEAR(from_measured[static_cast<std::size_t>(c)], from_expected[static_cast<std::size_t>(c)],
                5 * std::sqrt(error2[static_cast<std::size_t>(c)]) + 1e-3);
    EXPECT_NEAR(from_measured[static_cast<std::size_t>(c)], picture.whole(c).mean, 0.03 * of_light);
  }
}

TEST(SensorPicture, BandsOfLightFromLampsAreThoseOfPathsFromTheCamera) {
  const std::string scene =
      absl::StrCat(things("diffuse { reflectance { constant { rgb { r: 0.7 g: 0.2 b: 0.1 } } } }"),
                   lamp("disk { radius: 1 }", "two_sided: true", kAbove), camera(kPerspective));
  const Picture path = picture_of(scene, "path", 3, "film: 'spectral:8'"),
                light = picture_of(scene, "light", 3, "film: 'spectral:8'");
  ASSERT_EQ(path.channels.size(), kFirstBand + 8);
  ASSERT_EQ(light.channels.size(), kFirstBand + 8);
  expect_same(path, light);
  for (std::size_t c = kFirstBand; c < path.channels.size(); ++c) {
    const Picture::Value &a = path.channels[c], &b = light.channels[c];
    EXPECT_GT(a.mean, 0);
    EXPECT_NEAR(a.mean, b.mean, 5 * std::hypot(a.error, b.error) + 1e-3 * a.mean)
        << "band " << c - kFirstBand;
  }
}

}  // namespace
}  // namespace tessera::test
