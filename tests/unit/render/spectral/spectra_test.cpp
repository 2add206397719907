// Colours and curves as kernels for wavelengths see them, against the same on the host. Compiled with
// TESSERA_SPECTRAL.
#include "render/color/spectra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>
#include <tuple>

#include "render/scene/spectral/spectral_builder.h"
#include "render/scene/view/sensitivity.h"
#include "render/sensor/respond.h"
#include "spectra/color/rgb_space.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"
#include "spectra/sensor/sensor_response.h"
#include "spectra/upsampling/upsample.h"

namespace tessera::render::TESSERA_ISA {
namespace {

double sum_of(Float values) {
  alignas(64) float lanes[kWidth];
  values.store(lanes);
  return std::accumulate(std::begin(lanes), std::end(lanes), 0.0);
}

SensitivityTable sensitivity_of(const char* sensor, const char* film = "rgb") {
  v1::JobSpec::View view;
  view.set_sensor(sensor), view.set_film(film);
  return *build_sensitivity(*wire::film_sensor_of(view), v1::Film());
}

/// Numbers of `count` paths from the first on, evenly distributed.
Float numbers(int first, int count) {
  return (to_float(Int::iota(first)) + 0.5f) * (1.0f / static_cast<float>(count));
}

/// Returns what the CIE 1931 observer sees of light of a colour, nanometre by nanometre.
spectra::Triple seen_by_host(const std::array<float, 3>& rgb) {
  const float largest = std::ranges::max(rgb), scale = largest > 1 ? 2 * largest : 1;
  const auto k = spectra::upsample_reflectance({rgb[0] / scale, rgb[1] / scale, rgb[2] / scale}).coefficients;
  const spectra::Curve daylight = spectra::unit_d65();
  spectra::Curve light;
  for (float nm = 360; nm <= 830; ++nm) {
    light.nm.push_back(nm);
    light.values.push_back(scale * spectra::value(k, nm) * static_cast<float>(daylight.at(nm)));
  }
  return spectra::seen(
      *spectra::sensor_response(*spectra::parse_sensor("cie1931"), daylight, spectra::kRec709), light);
}

class SpectraTest : public testing::Test {
 protected:
  /// The channels of light with this value at a wavelength: its mean over `count` paths, whose numbers are
  /// evenly distributed.
  template <class Light>
  std::array<double, 3> seen(const std::vector<float>& response, Light&& light, int count = 4096) const {
    std::array<double, 3> sum = {};
    for (int first = 0; first < count; first += kWidth) {
      const Wavelengths wavelengths = sample_wavelengths(sensor_, [&] { return numbers(first, count); });
      const Channels channels(sensor_, response, wavelengths);
      const Spectrum value = light(Spectra(&tables_, wavelengths));
      for (int c = 0; c < 3; ++c)
        sum[c] += sum_of(channels.of(c, [&](int lane) { return value.c[lane]; })) / count;
    }
    return sum;
  }

  SpectralTables tables_;
  SpectralBuilder builder_{tables_};
  const SensitivityTable sensor_ = *build_sensitivity(*wire::film_sensor_of(v1::JobSpec::View()), v1::Film());
};

TEST_F(SpectraTest, SigmoidsAreThoseOfTheHost) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 4000; ++i) {
    std::array<float, 3> color = {uniform(random), uniform(random), uniform(random)};
    // Dark, saturated and bright ones as well.
    if (i % 4 == 1) std::ranges::transform(color, color.begin(), [](float v) { return v * v * v * 1e-2f; });
    if (i % 4 == 2) color[i % 3] = 0;
    if (i % 4 == 3) std::ranges::transform(color, color.begin(), [](float v) { return 1 - v * v * 0.2f; });
    const auto expected = spectra::upsample_reflectance({color[0], color[1], color[2]}).coefficients;
    Wavelengths wavelengths;
    for (int lane = 0; lane < kSpectrumLanes; ++lane)
      wavelengths.c[lane] = Float(360 + 470 * uniform(random));
    const Spectra spectra(&tables_, wavelengths);
    const Spectrum actual = spectra.factor(
        color_of([&](int c) { return Float(color[static_cast<std::size_t>(c)]); }), Mask::all());
    for (int lane = 0; lane < kSpectrumLanes; ++lane) {
      const float nm = wavelengths.c[lane].lane(0);
      EXPECT_NEAR(actual.c[lane].lane(0), spectra::value(expected, nm), 2e-4)
          << color[0] << " " << color[1] << " " << color[2] << " at " << nm;
    }
  }
}

TEST_F(SpectraTest, BlackIsBlack) {
  const spectra::SigmoidCoefficients k = spectra::upsample_reflectance({0, 0, 0}).coefficients;
  const Color coefficients = color_of([&](int c) { return Float(c == 0 ? k.c0 : c == 1 ? k.c1 : k.c2); });
  const Wavelengths wavelengths = sample_wavelengths(sensor_, [] { return Float(0.6f); });
  const Spectrum black = Spectra(&tables_, wavelengths).constant(coefficients, Int(-1), Mask::all());
  EXPECT_TRUE(none(~is_black(black)));
}

TEST_F(SpectraTest, GreysAreTheSameAtAllWavelengths) {
  for (const float grey : {0.0f, 1e-5f, 0.18f, 0.5f, 1.0f, 3.0f}) {
    const Wavelengths wavelengths = sample_wavelengths(sensor_, [] { return Float(0.3f); });
    const Spectrum actual = Spectra(&tables_, wavelengths).factor(Color(grey), Mask::all());
    for (const Float& lane : actual.c) EXPECT_EQ(lane.lane(5), grey);
  }
}

TEST_F(SpectraTest, DensitiesAreBelowTwiceTheirColours) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1), exponent(-4, 3);
  for (int i = 0; i < 2000; ++i) {
    const float scale = std::pow(10.0f, exponent(random));
    const std::array<float, 3> color = {
        scale * uniform(random), scale * uniform(random) * (i % 3 == 0 ? 0 : 1), scale * uniform(random)};
    const float largest = *std::ranges::max_element(color);
    const Wavelengths wavelengths = sample_wavelengths(sensor_, [&] { return Float(uniform(random)); });
    const Spectrum density =
        Spectra(&tables_, wavelengths)
            .density(color_of([&](int c) { return Float(color[static_cast<std::size_t>(c)]); }), Mask::all());
    for (const Float& lane : density.c) {
      EXPECT_GE(lane.lane(0), 0);
      EXPECT_LE(lane.lane(0), 2 * largest);
    }
  }
}

TEST_F(SpectraTest, DaylightIsWhite) {
  const auto white =
      seen(sensor_.light, [](const Spectra& s) { return s.light(Color(1.0f), Int(-1), Mask::all()); });
  const auto matter = seen(sensor_.matter, [](const Spectra&) { return Spectrum(1.0f); });
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(white[c], 1, 2e-4);
    EXPECT_NEAR(matter[c], 1, 2e-4);
  }
}

TEST_F(SpectraTest, ColoursComeBack) {
  for (const std::array<float, 3> rgb :
       {std::array{0.63f, 0.065f, 0.05f}, std::array{0.14f, 0.45f, 0.091f}, std::array{0.02f, 0.1f, 0.7f},
        std::array{0.9f, 0.8f, 0.3f}, std::array{4.0f, 1.5f, 0.5f}}) {
    const Color color = color_of([&](int c) { return Float(rgb[static_cast<std::size_t>(c)]); });
    const auto light =
        seen(sensor_.light, [&](const Spectra& s) { return s.light(color, Int(-1), Mask::all()); });
    const auto matter = seen(sensor_.matter, [&](const Spectra& s) { return s.factor(color, Mask::all()); });
    const spectra::Triple of_host = seen_by_host(rgb);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(light[c], of_host[c], 2e-4 * rgb[0] + 2e-4) << c;
      EXPECT_NEAR(matter[c], of_host[c], 2e-4 * rgb[0] + 2e-4) << c;
      // How near spectra of colours come to them is what upsample_test is about.
      EXPECT_NEAR(of_host[c], rgb[c], 5e-3 * rgb[0] + 2e-3) << c;
    }
  }
}

TEST_F(SpectraTest, CurvesAreSeenAsTheObserverSeesThem) {
  v1::Spectrum band;
  for (const float nm : {400.0f, 540.0f, 545.0f, 560.0f, 561.0f, 700.0f}) {
    band.mutable_sampled()->add_wavelengths_nm(nm);
    band.mutable_sampled()->add_values(nm > 543 && nm < 560.5f ? 2.0f : 0.1f);
  }
  const SpectralEmission emission = builder_.emission_of(band);
  ASSERT_GE(emission.curve, 0);
  EXPECT_EQ(builder_.emission_of(band).curve, emission.curve);
  const spectra::Curve curve{{400, 540, 545, 560, 561, 700}, {0.1f, 0.1f, 2, 2, 0.1f, 0.1f}};
  const spectra::Triple expected = spectra::times(spectra::rgb_from_xyz(spectra::kRec709),
                                                  spectra::tristimulus(curve, spectra::cie1931()));
  const auto actual = seen(sensor_.light, [&](const Spectra& s) {
    return s.light(Color(emission.color.r), Int(emission.curve), Mask::all());
  });
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 3e-3) << c;
}

TEST_F(SpectraTest, ASensorSamplesWhatItSeesAndNothingElse) {
  const SensitivityTable band = sensitivity_of("band:550.5-560"), camera = sensitivity_of("nikon-d5100");
  for (int first = 0; first < 1024; first += kWidth) {
    for (const auto& [sensor, from, to] :
         {std::tuple{&band, 550.5f, 560.0f}, std::tuple{&camera, 380.0f, 780.0f}}) {
      const Wavelengths wavelengths = sample_wavelengths(*sensor, [&] { return numbers(first, 1024); });
      for (const Float& nm : wavelengths.c) EXPECT_TRUE(none(~((nm >= from) & (nm <= to))));
    }
  }
  // All alike: each wavelength stands for a quarter of the band.
  const Wavelengths wavelengths = sample_wavelengths(band, [] { return Float(0.7f); });
  const LaneResponse response = lane_response(band, band.light, wavelengths);
  for (const Float& weight : response.weight) EXPECT_NEAR(weight.lane(0), 9.5 / 4, 1e-3);
}

TEST_F(SpectraTest, BandsHoldTheLightOfTheirWavelengths) {
  const SensitivityTable sensor = sensitivity_of("cie1931", "spectral:5:330-905");
  const spectra::Bands bands = *spectra::parse_film("spectral:5:330-905");
  constexpr int kCount = 1 << 14;
  std::array<double, 5> sums = {};
  for (int first = 0; first < kCount; first += kWidth) {
    const Wavelengths wavelengths = sample_wavelengths(sensor, [&] { return numbers(first, kCount); });
    const Channels channels(sensor, sensor.light, wavelengths);
    const Spectrum light = Spectra(&tables_, wavelengths).light(Color(1.0f), Int(-1), Mask::all());
    for (int lane = 0; lane < kSpectrumLanes; ++lane) {
      const BandShare share = band_share(sensor, wavelengths, channels, lane);
      for (int i = 0; i < kWidth; ++i) {
        if (const int band = share.band.lane(i); band >= 0)
          sums[static_cast<std::size_t>(band)] += (light.c[lane] * share.weight).lane(i) / kCount;
      }
    }
  }
  for (int band = 0; band < bands.count; ++band) {
    double expected = 0;
    for (int i = 0; i < 1000; ++i)
      expected += spectra::unit_d65().at(bands.begin(band) + bands.width() * (i + 0.5) / 1000) / 1000;
    EXPECT_NEAR(sums[static_cast<std::size_t>(band)], expected, 2e-3 * expected) << band;
  }
}

TEST_F(SpectraTest, WavelengthsOfAPathAreApart) {
  const Wavelengths wavelengths = sample_wavelengths(sensor_, [] { return Float(0.01f); });
  for (int i = 0; i < kSpectrumLanes; ++i) {
    EXPECT_GE(wavelengths.c[i].lane(0), sensor_.from_nm);
    EXPECT_LE(wavelengths.c[i].lane(0), sensor_.to_nm);
    for (int k = 0; k < i; ++k) EXPECT_GT(std::abs(wavelengths.c[i].lane(0) - wavelengths.c[k].lane(0)), 10);
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
