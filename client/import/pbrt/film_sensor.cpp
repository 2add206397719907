#include "import/pbrt/film_sensor.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "base/nearest_name.h"
#include "import/input/concat.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_name.h"
#include "wire/enum_words.h"

namespace tessera::client::pbrt {
namespace {

constexpr std::string_view kObserver = "cie1931";

/// A camera that pbrt-v4 has measurements of, and its name here; empty: there are none of it here.
struct Camera {
  std::string_view theirs, ours;
};

constexpr Camera kCameras[] = {
    {"canon_eos_100d", ""},      {"canon_eos_1dx_mkii", ""}, {"canon_eos_200d", ""},
    {"canon_eos_200d_mkii", ""}, {"canon_eos_5d", ""},       {"canon_eos_5d_mkii", "canon-eos-5d-mark-ii"},
    {"canon_eos_5d_mkiii", ""},  {"canon_eos_5d_mkiv", ""},  {"canon_eos_5ds", ""},
    {"canon_eos_m", ""},         {"hasselblad_l1d_20c", ""}, {"nikon_d810", ""},
    {"nikon_d850", ""},          {"sony_ilce_6400", ""},     {"sony_ilce_7m3", ""},
    {"sony_ilce_7rm3", ""},      {"sony_ilce_9", ""}};

/// pbrt's colour temperatures are those of an older radiation constant, so that 6500 K is D65.
constexpr double kNominalKelvin = 1.4388 / 1.4380;
constexpr double kKelvinOfD65 = 6500;

void ask_for_wavelengths(Context& context) {
  context.scene.mutable_settings()->set_color(v1::COLOR_SPECTRAL);
}

/// The place of a parameter that has been read; that of the film where it is absent.
SourceLocation place_of(ParameterList& parameters, std::string_view name, ParameterType type,
                        Diagnostics& diagnostics) {
  const Parameter* const parameter = parameters.find(name, {type}, diagnostics);
  return parameter == nullptr ? parameters.where() : parameter->where;
}

void write_sensor(Context& context, ParameterList& parameters) {
  const std::string name = parameters.get_string("sensor", std::string(kObserver), context.diagnostics);
  if (name == kObserver) return;
  const SourceLocation where = place_of(parameters, "sensor", ParameterType::kString, context.diagnostics);
  const auto known = std::ranges::find(kCameras, name, &Camera::theirs);
  if (known == std::end(kCameras)) {
    std::vector<std::string> names = {std::string(kObserver)};
    for (const Camera& camera : kCameras) names.emplace_back(camera.theirs);
    context.diagnostics.error(
        where, concat("there is no film sensor \"", name, "\"", base::did_you_mean(name, names)));
    return;
  }
  if (known->ours.empty()) {
    context.diagnostics.warning(where, concat("the sensitivities of film sensor \"", name,
                                              "\" are not here: cie1931 is used; of pbrt's cameras there is "
                                              "canon_eos_5d_mkii"));
    return;
  }
  ask_for_wavelengths(context);
  context.scene.mutable_settings()->set_sensor(std::string(known->ours));
  context.diagnostics.warning(where, concat("film sensor \"", name,
                                            "\": its own channels are written; pbrt-v4 makes colours of them "
                                            "by a matrix that is fitted to 24 patches"));
}

void write_white_balance(Context& context, ParameterList& parameters) {
  const double kelvin = parameters.get_float("whitebalance", 0, context.diagnostics);
  // Nothing is balanced where an observer is not asked to, and a camera is balanced for D65.
  if (kelvin == 0 || kelvin == kKelvinOfD65) return;
  const std::string words = concat(kelvin * kNominalKelvin, "K");
  if (const auto white = spectra::parse_white_balance(words); !white.ok()) {
    context.diagnostics.error(
        place_of(parameters, "whitebalance", ParameterType::kFloat, context.diagnostics),
        concat("\"whitebalance\": ", std::string(white.status().message())));
    return;
  }
  ask_for_wavelengths(context);
  context.scene.mutable_settings()->set_white_balance(words);
}

void write_bands(Context& context, ParameterList& parameters) {
  Diagnostics& diagnostics = context.diagnostics;
  const std::int64_t count = parameters.get_integer("nbuckets", 16, diagnostics);
  const double from = parameters.get_float("lambdamin", 360, diagnostics),
               to = parameters.get_float("lambdamax", 830, diagnostics);
  const std::string words = concat("spectral:", count, ":", from, "-", to);
  if (const auto bands = spectra::parse_film(words); !bands.ok()) {
    diagnostics.error(parameters.where(), concat("film: ", std::string(bands.status().message())));
    return;
  }
  ask_for_wavelengths(context);
  context.scene.mutable_settings()->set_film(words);
}

v1::RgbSpace space_of(ColorSpace space) {
  switch (space) {
    case ColorSpace::kSrgb:
      return v1::RGB_SPACE_REC709;
    case ColorSpace::kDciP3:
      return v1::RGB_SPACE_P3;
    case ColorSpace::kRec2020:
      return v1::RGB_SPACE_REC2020;
    case ColorSpace::kAces2065:
      return v1::RGB_SPACE_ACESCG;
  }
  return v1::RGB_SPACE_REC709;
}

void write_space(Context& context, ParameterList& parameters) {
  const v1::RgbSpace space = space_of(parameters.color_space());
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  // The channels of a camera are in no space.
  if (space == v1::RGB_SPACE_REC709 || !settings.sensor().empty()) return;
  if (settings.color() != v1::COLOR_SPECTRAL) {
    context.diagnostics.warning(
        parameters.where(),
        concat("the image is written in Rec.709 whatever the colour space of the film; --color spectral "
               "--set rgb-space=",
               wire::word_of(space), " writes it in that"));
    return;
  }
  settings.set_rgb_space(space);
  if (parameters.color_space() == ColorSpace::kAces2065) {
    context.diagnostics.warning(parameters.where(),
                                "the image is written in ACEScg, which has the white of the film's "
                                "aces2065-1 and primaries of its own");
  }
}

void write_exposure(Context& context, ParameterList& parameters, double shutter_seconds) {
  const double iso = parameters.get_float("iso", 100, context.diagnostics);
  const double exposure = shutter_seconds * iso / 100;
  if (!(iso > 0) || !std::isfinite(static_cast<float>(exposure))) {
    context.diagnostics.error(place_of(parameters, "iso", ParameterType::kFloat, context.diagnostics),
                              concat("an \"iso\" above 0 was expected, found ", iso));
    return;
  }
  if (exposure != 1) context.scene.mutable_film()->set_exposure(static_cast<float>(exposure));
  if (std::isfinite(parameters.get_float("maxcomponentvalue", HUGE_VAL, context.diagnostics))) {
    context.diagnostics.warning(parameters.where(),
                                "\"maxcomponentvalue\" of the film is not applied: samples are never "
                                "clamped");
  }
}

}  // namespace

void write_film_sensor(Context& context, Directive& film, double shutter_seconds) {
  write_sensor(context, film.parameters);
  write_white_balance(context, film.parameters);
  if (film.type == "spectral") write_bands(context, film.parameters);
  write_space(context, film.parameters);
  write_exposure(context, film.parameters, shutter_seconds);
}

}  // namespace tessera::client::pbrt
