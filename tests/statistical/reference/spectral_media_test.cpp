// Media in pictures whose paths carry light of wavelengths: absorption, scattering and light that were
// measured, and grids of colours.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "spectra/light/planck.h"
#include "statistical/reference/spectral_pictures.h"
#include "wire/volume_blob.h"

namespace tessera::test {
namespace {

constexpr double kRadius = 2;

/// The camera is in the middle of a ball of a medium, whose surface shines by `radiance`.
std::string ball(const std::string& medium, double radiance) {
  return absl::StrCat(
      "media { name: 'fog' ", medium,
      " } materials { name: 'black' diffuse { reflectance { constant { constant: 0 } } } } "
      "shapes { sphere { radius: ",
      kRadius, " } material: 'black' interior_medium: 'fog' exterior_medium: 'fog' ",
      radiance > 0 ? absl::StrCat("area_light { two_sided: true radiance { constant: ", radiance, " } }")
                   : "",
      " } camera { perspective { fov_degrees: 60 } medium: 'fog' } ");
}

std::string constant(const std::string& field, const std::string& spectrum) {
  return absl::StrCat(field, " { constant { ", spectrum, " } } ");
}

std::string rgb(const std::array<double, 3>& color) {
  return absl::StrCat("rgb { r: ", color[0], " g: ", color[1], " b: ", color[2], " }");
}

/// A cube that encloses the ball.
std::string cube(const std::string& field) {
  return field + " { elements: [6,0,0,-3, 0,6,0,-3, 0,0,6,-3, 0,0,0,1] }";
}

/// Blue, green and red parts of the spectrum with one value each.
spectra::Curve plateaus(const std::array<double, 3>& rgb_values) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {{360, 500, 501, 590, 591, 830},
          {f(rgb_values[2]), f(rgb_values[2]), f(rgb_values[1]), f(rgb_values[1]), f(rgb_values[0]),
           f(rgb_values[0])}};
}

const spectra::Curve kAbsorption{{360, 450, 520, 560, 640, 830}, {0.9f, 0.8f, 0.1f, 0.15f, 0.6f, 0.7f}};

constexpr std::array<double, 3> kExtinction = {0.2, 0.9, 1.6}, kAlbedo = {0.9, 0.5, 0.8};

TEST(SpectralMedia, LightIsAbsorbedAsMeasured) {
  const std::string scene =
      ball(constant("extinction", message_of(kAbsorption)) + constant("albedo", "constant: 0"), 1);
  expect_color(pictures_of(scene, "volpath", 1, kSpectral),
               in_daylight([](double nm) { return std::exp(-kRadius * kAbsorption.at(nm)); }), 2e-3);
}

TEST(SpectralMedia, LightIsEmittedAsMeasured) {
  const std::string scene =
      ball(constant("extinction", message_of(kAbsorption)) + constant("albedo", "constant: 0") +
               constant("emission", "blackbody { kelvin: 3000 }"),
           0);
  const spectra::Curve daylight = spectra::unit_d65();
  expect_color(pictures_of(scene, "volpath", 1, kSpectral), in_daylight([&](double nm) {
                 return spectra::relative_planck(nm, 3000) / daylight.at(nm) *
                        (1 - std::exp(-kRadius * kAbsorption.at(nm)));
               }),
               4e-3);
}

/// Light that a medium lets through and scatters at three sets of coefficients: the channels of RGB.
std::array<double, 3> light_of_channels() {
  const Pictures pictures = pictures_of(
      ball(constant("extinction", rgb(kExtinction)) + constant("albedo", rgb(kAlbedo)), 1), "volpath", 8, "");
  std::array<double, 3> light;
  for (std::size_t c = 0; c < 3; ++c) light[c] = mean_of(values_by_seed(pictures, &Picture::values, c)).mean;
  return light;
}

TEST(SpectralMedia, LightIsScatteredAsMeasured) {
  const std::array<double, 3> light = light_of_channels();
  const spectra::Triple expected = in_daylight([curve = plateaus(light)](double nm) { return curve.at(nm); });
  const std::string extinction = constant("extinction", message_of(plateaus(kExtinction))),
                    albedo = constant("albedo", message_of(plateaus(kAlbedo)));
  std::array<double, 3> scattering;
  for (std::size_t c = 0; c < 3; ++c) scattering[c] = kExtinction[c] * kAlbedo[c];
  const std::string sigma_s = constant("sigma_s", message_of(plateaus(scattering)));
  // In closed form, and along majorants.
  for (const std::string& bounds : {std::string(), cube("world_from_bounds")}) {
    for (const std::string& scatters : {albedo, sigma_s}) {
      const std::string medium = absl::StrCat(extinction, scatters, bounds);
      SCOPED_TRACE(medium);
      expect_color(pictures_of(ball(medium, 1), "volpath", 8, kSpectral), expected, 6e-3);
    }
  }
}

TEST(SpectralMedia, GridsOfColoursAreAsMediaOfOneColour) {
  const auto grid_of = [](const std::array<double, 3>& color) {
    std::vector<float> samples;
    for (int i = 0; i < 8; ++i)
      for (const double c : color) samples.push_back(static_cast<float>(c));
    return wire::encode_volume({2, 2, 2, 3, std::span(samples)});
  };
  std::array<double, 3> scattering;
  for (std::size_t c = 0; c < 3; ++c) scattering[c] = kExtinction[c] * kAlbedo[c];
  TestBlobs blobs = light_blobs();
  blobs["extinction"] = grid_of(kExtinction);
  blobs["albedo"] = grid_of(kAlbedo);
  blobs["scattering"] = grid_of(scattering);
  const auto grid = [](const std::string& field, const std::string& blob) {
    return absl::StrCat(field, " { grid { blob { digest: '", blob, "' } ", cube("world_from_grid"), " } } ");
  };
  const Pictures expected =
      pictures_of(ball(constant("extinction", rgb(kExtinction)) + constant("albedo", rgb(kAlbedo)), 1),
                  "volpath", 8, kSpectral);
  for (const std::string& medium : {grid("extinction", "extinction") + constant("albedo", rgb(kAlbedo)),
                                    grid("extinction", "extinction") + grid("albedo", "albedo"),
                                    grid("extinction", "extinction") + grid("sigma_s", "scattering")}) {
    SCOPED_TRACE(medium);
    const Pictures actual = pictures_of(ball(medium, 1), "volpath", 8, kSpectral, blobs);
    expect_same(expected, actual);
  }
}

TEST(SpectralMedia, GridsTimesWhatWasMeasuredAreAsMediaOfIt) {
  const std::vector<float> halves(8, 0.5f);
  TestBlobs blobs = light_blobs();
  blobs["halves"] = wire::encode_volume({2, 2, 2, 1, std::span(halves)});
  const auto grid = [](const std::string& field, const std::string& factor) {
    return absl::StrCat(field, " { grid { blob { digest: 'halves' } ", cube("world_from_grid"), " factor { ",
                        factor, " } } } ");
  };
  const auto times = [](double factor, std::array<double, 3> values) {
    for (double& value : values) value *= factor;
    return values;
  };
  std::array<double, 3> scattering;
  for (std::size_t c = 0; c < 3; ++c) scattering[c] = kExtinction[c] * kAlbedo[c];
  const std::array<double, 3> light = light_of_channels();
  const spectra::Triple expected = in_daylight([curve = plateaus(light)](double nm) { return curve.at(nm); });
  const std::string extinction = grid("extinction", message_of(plateaus(times(2, kExtinction))));
  for (const std::string& scatters : {constant("albedo", message_of(plateaus(kAlbedo))),
                                      grid("albedo", message_of(plateaus(times(2, kAlbedo)))),
                                      grid("sigma_s", message_of(plateaus(times(2, scattering))))}) {
    SCOPED_TRACE(scatters);
    expect_color(pictures_of(ball(extinction + scatters, 1), "volpath", 8, kSpectral, blobs), expected, 6e-3);
  }
  // Light that a grid gives, of a spectrum.
  const spectra::Curve daylight = spectra::unit_d65();
  const std::string glow = constant("extinction", message_of(kAbsorption)) +
                           constant("albedo", "constant: 0") + grid("emission", "blackbody { kelvin: 3000 }");
  expect_color(pictures_of(ball(glow, 0), "volpath", 8, kSpectral, blobs), in_daylight([&](double nm) {
                 return 0.5 * spectra::relative_planck(nm, 3000) / daylight.at(nm) *
                        (1 - std::exp(-kRadius * kAbsorption.at(nm)));
               }),
               6e-3);
}

TEST(SpectralMedia, GridsAbsorbWhatNoObserverSees) {
  const std::vector<float> ones(8, 1.0f);
  TestBlobs blobs = light_blobs();
  blobs["ones"] = wire::encode_volume({2, 2, 2, 1, std::span(ones)});
  const spectra::Curve infrared{{880, 881, 1000}, {0, 0.5f, 0.5f}};
  const auto seen_in = [&](const std::string& medium) {
    const std::string settings = absl::StrCat(kSpectral, " sensor: 'band:900-950' white_balance: 'none' ");
    const Pictures pictures = pictures_of(ball(medium, 1), "volpath", 8, settings, blobs);
    return mean_of(values_by_seed(pictures, &Picture::values, 0)).mean;
  };
  const std::string albedo = " albedo { constant { constant: 0 } }";
  const double clear = seen_in("extinction { constant { constant: 0 } }" + albedo);
  const double absorbing =
      seen_in(absl::StrCat("extinction { grid { blob { digest: 'ones' } ", cube("world_from_grid"),
                           " factor { ", message_of(infrared), " } } }", albedo));
  ASSERT_GT(clear, 0);
  // A share exp(-1) of the paths passes majorants of the same height: the deviation over all of them.
  EXPECT_NEAR(absorbing / clear, std::exp(-kRadius * 0.5), 6e-3);
}

}  // namespace
}  // namespace tessera::test
