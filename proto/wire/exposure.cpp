#include "wire/exposure.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "optics/image_quality.h"
#include "optics/pupil.h"
#include "wire/lens_message.h"

namespace tessera::wire {

namespace {

using std::numbers::pi;

constexpr const char* kForm = "expected scene, stops (+1.5), ev12, or words like f/8 t/8 1/125s iso400 nd0.9";

std::optional<double> real_in(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

/// "1/125", "1/125s", "2s".
std::optional<double> seconds_in(std::string_view text) {
  const bool has_unit = text.ends_with('s');
  if (has_unit) text.remove_suffix(1);
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return has_unit ? real_in(text) : std::nullopt;
  const auto over = real_in(text.substr(0, slash)), under = real_in(text.substr(slash + 1));
  if (!over || !under || *under == 0) return std::nullopt;
  return *over / *under;
}

struct Words {
  v1::PhotographicExposure said;
  bool replaces = false;  // some word is more than stops that are added
};

/// Takes words one after another.
class WordReader {
 public:
  explicit WordReader(Words& words) : words_(words) {}

  /// Whether it is a word, and the first of its kind.
  bool read(std::string_view word) {
    if (word == "scene") return true;
    if (const char first = word.front(); first == '+' || first == '-') {
      const auto stops = real_in(first == '+' ? word.substr(1) : word);
      if (!stops || words_.said.compensation_stops() != 0) return false;
      words_.said.set_compensation_stops(*stops);
      return true;
    }
    words_.replaces = true;
    v1::PhotographicExposure& said = words_.said;
    if (const auto f = after(word, "f"))
      return set(said.has_f_number(), *f, [&](double x) { said.set_f_number(x); });
    if (const auto t = after(word, "t"))
      return set(said.has_t_number(), *t, [&](double x) { said.set_t_number(x); });
    if (const auto iso = after(word, "iso"))
      return set(said.has_iso(), *iso, [&](double x) { said.set_iso(x); });
    if (const auto ev = after(word, "ev"))
      return set(said.has_ev100(), *ev, [&](double x) { said.set_ev100(x); });
    if (const auto density = after(word, "nd"))
      return set(said.nd_density() != 0, *density, [&](double x) { said.set_nd_density(x); });
    const auto seconds = seconds_in(word);
    return seconds &&
           set(said.has_shutter_seconds(), *seconds, [&](double x) { said.set_shutter_seconds(x); });
  }

 private:
  /// The number behind a prefix, and behind a slash, if there is one: "f/8", "iso400".
  static std::optional<double> after(std::string_view word, std::string_view prefix) {
    if (!word.starts_with(prefix)) return std::nullopt;
    word.remove_prefix(prefix.size());
    if (prefix.size() == 1 && word.starts_with('/')) word.remove_prefix(1);
    return real_in(word);
  }
  template <class Setter>
  static bool set(bool was_said, double number, Setter&& setter) {
    if (!was_said) setter(number);
    return !was_said;
  }

  Words& words_;
};

absl::StatusOr<Words> read_words(const std::string& text) {
  Words words;
  WordReader reader(words);
  std::vector<std::string> faults;
  const std::vector<std::string> small =
      absl::StrSplit(absl::AsciiStrToLower(text), absl::ByAnyChar(" ,"), absl::SkipEmpty());
  for (const std::string& word : small) {
    if (!reader.read(word)) faults.push_back(absl::StrCat("'", word, "'"));
  }
  if (faults.empty()) return words;
  return absl::InvalidArgumentError(absl::StrCat("exposure '", text, "': ", absl::StrJoin(faults, ", "),
                                                 faults.size() > 1 ? " mean nothing" : " means nothing",
                                                 " there, or was said before; ", kForm));
}

void check_numbers(const v1::PhotographicExposure& asked, std::vector<std::string>& faults) {
  const auto positive = [&](bool has, double number, const char* what) {
    if (has && !(number > 0 && std::isfinite(number)))
      faults.push_back(absl::StrCat(what, " above 0 was expected, not ", number));
  };
  positive(asked.has_f_number(), asked.f_number(), "an f-number");
  positive(asked.has_t_number(), asked.t_number(), "a T-number");
  positive(asked.has_shutter_seconds(), asked.shutter_seconds(), "a shutter time");
  positive(asked.has_iso(), asked.iso(), "an ISO speed");
  positive(asked.cd_per_m2() != 0, asked.cd_per_m2(), "a luminance of radiance 1");
  if (!(asked.nd_density() >= 0 && std::isfinite(asked.nd_density())))
    faults.push_back(absl::StrCat("a filter of density ", asked.nd_density(), " would make light"));
  if (!std::isfinite(asked.ev100()) || !std::isfinite(asked.compensation_stops()))
    faults.emplace_back("its stops are not finite");
  if (asked.has_f_number() + asked.has_t_number() + asked.has_ev100() > 1)
    faults.emplace_back("one of f-number, T-number and EV was expected");
  if (asked.has_ev100() && (asked.has_shutter_seconds() || asked.has_iso()))
    faults.emplace_back("an EV at ISO 100 has its shutter time and ISO speed in it");
}

/// Illuminance of the film, times seconds, for each luminance that pixels are: lux seconds over cd/m^2.
absl::StatusOr<double> film_exposure_of_pixel(const v1::PhotographicExposure& asked,
                                              const v1::Camera& camera) {
  constexpr double kQuarterPi = pi / 4;
  const bool tells_stop = asked.has_f_number() || asked.has_t_number() || asked.has_ev100();
  if (tells_stop && is_irradiance(camera)) {
    return absl::InvalidArgumentError(
        "the camera's brightness is IRRADIANCE, which has the aperture in it: f-number, T-number and EV "
        "would count it twice");
  }
  if (asked.has_ev100()) return kQuarterPi * std::exp2(-asked.ev100());
  const double seconds = asked.has_shutter_seconds() ? asked.shutter_seconds() : 1;
  if (tells_stop) {
    const double number = asked.has_t_number() ? asked.t_number() : asked.f_number();
    return kQuarterPi * seconds / (number * number);
  }
  const std::optional<LightThroughLens> lens = lens_light(camera);
  if (!lens) {
    return absl::InvalidArgumentError(
        "this kind of camera does not say how much light it lets through: f_number, t_number or ev100 does");
  }
  if (!is_irradiance(camera)) return seconds * lens->transmission * lens->irradiance;
  // Pixels of a lens with ghosts have lost what its surfaces reflect.
  return seconds * (camera.has_lens() && camera.lens().ghosts() ? 1 : lens->transmission);
}

}  // namespace

absl::StatusOr<FilmExposure> film_exposure(const v1::Film& film, const std::string& words) {
  const absl::StatusOr<Words> read = read_words(words);
  if (!read.ok()) return read.status();
  FilmExposure exposure;
  exposure.factor = film.has_exposure() ? film.exposure() : 1;
  if (film.has_photographic_exposure()) exposure.photographic = film.photographic_exposure();
  if (read->replaces) {
    const double cd_per_m2 = film.photographic_exposure().cd_per_m2();
    exposure.factor = 1;
    exposure.photographic = read->said;
    exposure.photographic->set_cd_per_m2(cd_per_m2);
  } else {
    exposure.factor *= std::exp2(read->said.compensation_stops());
  }
  std::vector<std::string> faults;
  if (exposure.photographic) check_numbers(*exposure.photographic, faults);
  if (!std::isfinite(exposure.factor)) faults.emplace_back("the exposure is not finite");
  if (faults.empty()) return exposure;
  return absl::InvalidArgumentError(absl::StrJoin(faults, "; "));
}

absl::Status check_exposure_words(const std::string& words) {
  return film_exposure(v1::Film(), words).status();
}

absl::StatusOr<double> exposure_scale(const FilmExposure& exposure, const v1::Camera& camera) {
  if (!exposure.photographic) return exposure.factor;
  const v1::PhotographicExposure& asked = *exposure.photographic;
  const absl::StatusOr<double> of_pixel = film_exposure_of_pixel(asked, camera);
  if (!of_pixel.ok()) return of_pixel.status();
  constexpr double kGrey = .18, kSpeedTimesGreyExposure = 10;  // [ISO 12232], standard output sensitivity
  const double iso = asked.has_iso() ? asked.iso() : 100;
  const double luminance = asked.cd_per_m2() > 0 ? asked.cd_per_m2() : 1;
  const double filter = std::pow(10, -asked.nd_density());
  return exposure.factor * luminance * *of_pixel * filter * std::exp2(asked.compensation_stops()) * iso *
         (kGrey / kSpeedTimesGreyExposure);
}

bool is_irradiance(const v1::Camera& camera) {
  return (camera.has_lens() && camera.lens().brightness() == v1::LensCamera::IRRADIANCE) ||
         (camera.has_pinhole() && camera.pinhole().brightness() == v1::LensCamera::IRRADIANCE);
}

std::optional<LightThroughLens> lens_light(const v1::Camera& camera) {
  if (camera.has_pinhole()) {
    const double radius = camera.pinhole().hole_mm() / 2, distance = camera.pinhole().film_distance_mm();
    return LightThroughLens{pi * radius * radius / (radius * radius + distance * distance)};
  }
  if (!camera.has_lens()) return std::nullopt;
  std::vector<optics::Fault> faults;
  const std::optional<optics::LensSystem> lens = lens_system_of(camera.lens(), faults);
  if (!lens) return std::nullopt;
  return LightThroughLens{optics::axial_irradiance(*lens), optics::transmittance(*lens, optics::kLineD)};
}

}  // namespace tessera::wire
