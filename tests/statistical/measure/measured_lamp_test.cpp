// A lamp from a photometric file, measured as a goniophotometer does, is the lamp of that file.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "google/protobuf/text_format.h"
#include "measure/lamp_file_of.h"
#include "measure_text.h"
#include "photometry/lamps/lamp_file.h"
#include "tessera/v1/meter.pb.h"
#include "unit/lib/photometry/sample_lamps.h"

namespace tessera::test {
namespace {

/// Intensities and flux are measured back to .2 %.
constexpr double kSame = 0.002;
constexpr double kCStep = 30, kGammaStep = 5;

/// A lamp without symmetry whose light is smooth, as that of most is: the renderer's map of it is good to .3
/// % beside the edges of sharp ones.
photometry::Luminaire smooth_lamp() {
  photometry::Luminaire lamp = photometry::luminaire_of(
      [](double c, double gamma) {
        const double g = gamma * std::numbers::pi / 180, a = c * std::numbers::pi / 180;
        return 500 + 200 * std::sin(g) * std::cos(a - 0.4) + 150 * std::cos(g);
      },
      kCStep, kGammaStep, 360 - kCStep);
  lamp.ies_year = 2019;
  return lamp;
}

TEST(MeasuredLamp, IsWhatItsFileSays) {
  const photometry::Luminaire lamp = smooth_lamp();
  const auto file = photometry::write_ies(lamp);
  ASSERT_TRUE(file.ok()) << file.status();
  const std::string meters =
      "meters { name: 'I' intensity { gamma_step_degrees: 5 c_step_degrees: 30 } } "
      "meters { name: 'F' flux { escaping: true } } ";
  const auto measured =
      measure_text({.scene = scene_with("lights { goniometric { photometric_file { path: 'lamp.ies' } } }"),
                    .meters = meters,
                    .samples = 1 << 13,
                    .files = {{"lamp.ies", *file}}});
  ASSERT_TRUE(measured.ok()) << measured.status();
  const client::Figure& flux = measured->meters.at(1).readings.at(0).figure;
  EXPECT_NEAR(flux.value, photometry::flux(lamp), kSame * flux.value + 5 * flux.standard_error);
  EXPECT_LT(flux.standard_error, kSame * flux.value);

  v1::MeterList list;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(meters, &list));
  const auto found = client::luminaire_of(list.meters(0), measured->meters.at(0));
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(found->plane_degrees, lamp.plane_degrees);
  EXPECT_EQ(found->polar_degrees, lamp.polar_degrees);
  ASSERT_EQ(found->values.size(), lamp.values.size());
  for (std::size_t i = 0; i < lamp.values.size(); ++i)
    EXPECT_NEAR(found->values[i], lamp.values[i], kSame * lamp.values[i]) << "direction " << i;
  EXPECT_NEAR(photometry::flux(*found), photometry::flux(lamp), kSame * photometry::flux(lamp));

  // The files that it is written to, either kind, read back equal.
  for (const bool is_ies : {true, false}) {
    const auto text = is_ies ? photometry::write_ies(*found) : photometry::write_eulumdat(*found);
    ASSERT_TRUE(text.ok()) << text.status();
    const photometry::ReadLamp back = photometry::read_lamp(*text, is_ies ? "back.ies" : "back.ldt");
    ASSERT_TRUE(back.luminaire.ok()) << back.luminaire.status();
    EXPECT_EQ(back.luminaire->polar_degrees, found->polar_degrees);
    if (is_ies) {
      EXPECT_EQ(*back.luminaire, *found);
    }
    for (const double c : {0.0, 30.0, 200.0, 350.0}) {
      for (const double gamma : {0.0, 32.5, 90.0, 180.0})
        EXPECT_NEAR(photometry::intensity_at(*back.luminaire, {c, gamma}),
                    photometry::intensity_at(*found, {c, gamma}), 1e-9)
            << (is_ies ? "ies" : "ldt") << " C " << c << " gamma " << gamma;
    }
  }
}

}  // namespace
}  // namespace tessera::test
