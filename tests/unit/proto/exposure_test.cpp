#include "wire/exposure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "google/protobuf/text_format.h"
#include "wire/film_format.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"

namespace tessera::wire {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

template <class Message>
Message message(const std::string& text) {
  Message result;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &result)) << text;
  return result;
}

double scale(const std::string& film, const std::string& words = "",
             const std::string& camera = "perspective { fov_degrees: 40 }") {
  const auto exposure = film_exposure(message<v1::Film>(film), words);
  EXPECT_TRUE(exposure.ok()) << exposure.status();
  if (!exposure.ok()) return 0;
  const auto result = exposure_scale(*exposure, message<v1::Camera>(camera));
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *result : 0;
}
std::string refused_exposure(const std::string& film, const std::string& words = "",
                             const std::string& camera = "perspective { fov_degrees: 40 }") {
  const auto exposure = film_exposure(message<v1::Film>(film), words);
  if (!exposure.ok()) return std::string(exposure.status().message());
  return std::string(exposure_scale(*exposure, message<v1::Camera>(camera)).status().message());
}

TEST(Exposure, FilmsWithoutAreAsTheyWere) {
  EXPECT_EQ(scale(""), 1);
  EXPECT_EQ(scale("", "scene"), 1);
  EXPECT_EQ(scale("exposure: 2.5"), 2.5);
  EXPECT_EQ(scale("exposure: 2.5", "+1"), 5);
  EXPECT_EQ(scale("exposure: 2.5", "-1"), 1.25);
}

/// ISO 12232: at speed S, 10 / S lux seconds are a grey of 0.18, and a lens at f/N makes pi / 4 / N^2 of a
/// luminance.
TEST(Exposure, IsThatOfTheStandardOutputSensitivity) {
  const double lux_seconds = pi / 4 / 64 / 125;
  EXPECT_NEAR(scale("photographic_exposure { f_number: 8 shutter_seconds: 0.008 iso: 400 }"),
              .18 * lux_seconds * 400 / 10, 1e-12);
  // A meter of K = 12.5 cd/m^2: what it points to becomes 0.18, to 2 %.
  const double metered = 12.5 * 64 * 125 / 100;
  EXPECT_NEAR(metered * scale("photographic_exposure { f_number: 8 shutter_seconds: 0.008 }"), .18,
              .02 * .18);
  const double ev = std::log2(64 * 125.0);
  EXPECT_NEAR(scale("photographic_exposure { f_number: 8 shutter_seconds: 0.008 }"),
              scale("photographic_exposure { ev100: " + std::to_string(ev) + " }"), 1e-9);
}

TEST(Exposure, WordsTakeThePlaceOfTheScenes) {
  const std::string film = "exposure: 7 photographic_exposure { ev100: 3 cd_per_m2: 50 }";
  EXPECT_DOUBLE_EQ(
      scale(film, "f/8 1/125s ISO400"),
      scale("photographic_exposure { f_number: 8 shutter_seconds: 0.008 iso: 400 cd_per_m2: 50 }"));
  EXPECT_DOUBLE_EQ(scale("", "t4, 2s, +1"), 2 * scale("", "f/4 2s"));
  EXPECT_DOUBLE_EQ(scale("", "ev12"), scale("photographic_exposure { ev100: 12 }"));
  EXPECT_NEAR(scale("", "ev12 nd0.9"), scale("", "ev12") * std::pow(10, -.9), 1e-15);
  EXPECT_DOUBLE_EQ(scale(film, "+2"), 4 * scale(film));
}

TEST(Exposure, ALensTellsItsTNumber) {
  const std::string hole = "pinhole { hole_mm: 1 film_distance_mm: 100 ";
  const double irradiance = pi * .25 / (.25 + 1e4);
  EXPECT_NEAR(scale("", "1s iso100", hole + "}"), 1.8 * irradiance, 1e-12);
  EXPECT_NEAR(scale("", "1s iso100", hole + "brightness: IRRADIANCE }"), 1.8, 1e-12);
  // Two bare surfaces of index 1.5 reflect 4 % each; at f/4, far away, the film gets nearly pi / (4 N^2).
  const std::string lens = R"(lens { lens { surfaces { thickness_mm: 1 diameter_mm: 30 stop: true }
      surfaces { radius_mm: 100 thickness_mm: 6 diameter_mm: 36 index: 1.5 }
      surfaces { radius_mm: -100 thickness_mm: 99 diameter_mm: 36 } } f_number: 16 )";
  const auto light = lens_light(message<v1::Camera>(lens + "}"));
  ASSERT_TRUE(light);
  EXPECT_NEAR(light->transmission, .96 * .96, 1e-9);
  EXPECT_NEAR(light->irradiance, pi / 4 / 256, 2e-2 * pi / 4 / 256);
  EXPECT_NEAR(scale("", "1s", lens + "}"), 1.8 * light->transmission * light->irradiance, 1e-12);
  EXPECT_NEAR(scale("", "1s", lens + "brightness: IRRADIANCE }"), 1.8 * light->transmission, 1e-12);
}

TEST(Exposure, RefusesWhatIsNone) {
  EXPECT_THAT(refused_exposure("", "1s"), HasSubstr("f_number, t_number or ev100 does"));
  EXPECT_THAT(refused_exposure("", "f/8 g/9 blue"), HasSubstr("'g/9', 'blue' mean nothing"));
  EXPECT_THAT(refused_exposure("", "f/8 f/9"), HasSubstr("said before"));
  EXPECT_THAT(refused_exposure("", "f/0"), HasSubstr("an f-number above 0 was expected, not 0"));
  EXPECT_THAT(refused_exposure("", "f/8 1/0s"), HasSubstr("'1/0s' means nothing"));
  EXPECT_THAT(
      refused_exposure("photographic_exposure { f_number: 8 t_number: 9 ev100: 3 iso: -1 nd_density: -1 }"),
      testing::AllOf(HasSubstr("an ISO speed above 0"), HasSubstr("would make light"),
                     HasSubstr("one of f-number, T-number and EV"), HasSubstr("speed in it")));
  EXPECT_THAT(
      refused_exposure("", "f/8", "pinhole { hole_mm: 1 film_distance_mm: 9 brightness: IRRADIANCE }"),
      HasSubstr("would count it twice"));
  EXPECT_THAT(refused_exposure("exposure: nan"), HasSubstr("the exposure is not finite"));
  v1::RenderSettings settings;
  settings.set_exposure("f/eight");
  v1::JobSpec job;
  resolve_settings(settings, job);
  EXPECT_THAT(std::string(check_settings(job).message()), HasSubstr("'f/eight' means nothing"));
}

TEST(FilmSize, IsTheGaugesOrByTheDiagonal) {
  const optics::FilmSize full = film_size(0, "", {300, 200}), by_diagonal = film_size(50, "", {40, 30}),
                         named = film_size(0, "4x5", {1, 1});
  EXPECT_NEAR(full.width, 36, 1e-5);
  EXPECT_NEAR(full.height, 24, 1e-5);
  EXPECT_DOUBLE_EQ(by_diagonal.width, 40);
  EXPECT_DOUBLE_EQ(named.width, 96);
  EXPECT_THAT(*film_fault(0, "supr35"), HasSubstr("did you mean 'super35'?"));
  EXPECT_THAT(*film_fault(40, "135"), HasSubstr("has no diagonal of its own"));
  EXPECT_THAT(*film_fault(-1, ""), HasSubstr("a film of -1 mm is none"));
  EXPECT_FALSE(film_fault(0, "135"));
}

/// Half of the shorter side over the distance of the film is what a screen window counts in.
TEST(FilmSize, ScalesStayOnFilmsOfAnotherShape) {
  auto hole = message<v1::Camera>("pinhole { hole_mm: 1 film_distance_mm: 50 film_gauge: '6x7' }"),
       perspective = message<v1::Camera>("perspective { focal_length_mm: 50 film_gauge: '6x7' }");
  keep_film_scale({160, 90}, {200, 130}, hole);
  keep_film_scale({160, 90}, {200, 130}, perspective);
  const double half = 70 * 9.0 / 16 / 2;
  EXPECT_NEAR(film_size(hole.pinhole(), {200, 130}).height / 2, half, 1e-9);
  EXPECT_NEAR(field_of_view(perspective.perspective(), {200, 130}), 2 * std::atan(half / 50) * 180 / pi,
              1e-4);
  EXPECT_FALSE(field_fault(perspective.perspective()));
}

TEST(FilmSize, AFocalLengthHasAField) {
  const auto camera = message<v1::PerspectiveCamera>("focal_length_mm: 50");
  EXPECT_FALSE(field_fault(camera));
  EXPECT_NEAR(field_of_view(camera, {300, 200}), 2 * std::atan(.24) * 180 / pi, 1e-9);
  const auto small = message<v1::PerspectiveCamera>("focal_length_mm: 50 film_gauge: 'super16'");
  EXPECT_NEAR(field_of_view(small, {1252, 741}), 2 * std::atan(7.41 / 100) * 180 / pi, 1e-4);
  EXPECT_THAT(*field_fault(message<v1::PerspectiveCamera>("focal_length_mm: 50 fov_degrees: 40")),
              HasSubstr("say the same"));
  EXPECT_THAT(*field_fault(message<v1::PerspectiveCamera>("fov_degrees: 40 film_gauge: '135'")),
              HasSubstr("without a focal_length_mm"));
  EXPECT_THAT(*field_fault(message<v1::PerspectiveCamera>("focal_length_mm: -50")),
              HasSubstr("is not possible"));
  EXPECT_THAT(*field_fault(message<v1::PerspectiveCamera>("")), HasSubstr("0 degrees is not in (0, 180)"));
}

}  // namespace
}  // namespace tessera::wire
