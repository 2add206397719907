#include "wire/film_sensor.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/enum_words.h"
#include "wire/exposure.h"

namespace tessera::wire {
namespace {

constexpr const char *kUsualSensor = "cie1931", *kUsualWhite = "D65", *kUsualFilm = "rgb";

std::string or_usual(const std::string& word, const char* usual) { return word.empty() ? usual : word; }

}  // namespace

const spectra::RgbSpace& primaries_of(v1::RgbSpace space) {
  switch (space) {
    case v1::RGB_SPACE_REC2020:
      return spectra::kRec2020;
    case v1::RGB_SPACE_P3:
      return spectra::kP3D65;
    case v1::RGB_SPACE_ACESCG:
      return spectra::kAcesCg;
    default:
      return spectra::kRec709;
  }
}

absl::StatusOr<FilmSensor> film_sensor_of(const v1::JobSpec::View& view) {
  auto sensor = spectra::parse_sensor(or_usual(view.sensor(), kUsualSensor));
  auto white = spectra::parse_white_balance(or_usual(view.white_balance(), kUsualWhite));
  const auto bands = spectra::parse_film(or_usual(view.film(), kUsualFilm));
  std::vector<std::string> faults;
  const auto note = [&](const char* setting, const absl::Status& status) {
    if (!status.ok()) faults.push_back(absl::StrCat(setting, ": ", status.message()));
  };
  note("sensor", sensor.status());
  note("white-balance", white.status());
  note("film", bands.status());
  if (!faults.empty()) return absl::InvalidArgumentError(absl::StrJoin(faults, "\n"));
  return FilmSensor{*sensor, *std::move(white), primaries_of(view.rgb_space()), *bands};
}

spectra::Bands bands_of(const v1::JobSpec::View& view) {
  const auto bands = spectra::parse_film(or_usual(view.film(), kUsualFilm));
  return bands.ok() ? *bands : spectra::Bands{};
}

absl::Status check_film_words(const v1::JobSpec::View& view) {
  const absl::StatusOr<FilmSensor> film = film_sensor_of(view);
  if (!film.ok()) return film.status();
  if (absl::Status exposure = check_exposure_words(view.exposure()); !exposure.ok()) return exposure;
  const v1::RgbSpace space = or_default(view.rgb_space());
  if (space == v1::RGB_SPACE_REC709 || film->sensor.kind == spectra::SensorKind::kObserver)
    return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("rgb-space '", word_of(space),
                                                 "' is for observers: sensor '", view.sensor(),
                                                 "' has channels of its own"));
}

absl::Status check_film_sensor(const v1::JobSpec& spec) {
  const v1::JobSpec::View& view = spec.view();
  if (const absl::Status sound = check_film_words(view); !sound.ok()) return sound;
  if (spec.content().algorithms().color() == v1::COLOR_SPECTRAL) return absl::OkStatus();
  std::vector<std::string> asked;
  const auto note = [&](const char* setting, const std::string& word, const std::string& usual) {
    if (!word.empty() && word != usual) asked.push_back(absl::StrCat(setting, " '", word, "'"));
  };
  note("sensor", view.sensor(), kUsualSensor);
  note("rgb-space", word_of(or_default(view.rgb_space())), word_of(v1::RGB_SPACE_REC709));
  note("white-balance", view.white_balance(), kUsualWhite);
  note("film", view.film(), kUsualFilm);
  if (asked.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      absl::StrJoin(asked, ", "), " cannot be made of red, green and blue: color 'spectral' can"));
}

}  // namespace tessera::wire
