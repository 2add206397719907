#include "command/report/film_facts.h"

#include <string>

#include "image/color_space.h"
#include "image/spectral_image.h"
#include "spectra/sensor/sensor_name.h"
#include "wire/film_sensor.h"

namespace tessera::client {
namespace {

/// Tells the white of a picture that was balanced: its colour space's, whatever light that was in the scene.
void add_white(const wire::FilmSensor& film, const v1::JobSpec::View& view, Image& image) {
  if (!film.white || image.metadata.contains(kRawChannels)) return;
  image.metadata["adoptedNeutral"] =
      NumberPair{static_cast<float>(film.space.white.x), static_cast<float>(film.space.white.y)};
  if (const auto kelvin = spectra::kelvin_of_white_balance(view.white_balance()))
    image.metadata["cameraCCTSetting"] = static_cast<float>(*kelvin);
}

}  // namespace

void add_film_facts(const v1::JobSpec& spec, Image& image) {
  const v1::JobSpec::View& view = spec.view();
  if (spec.content().algorithms().color() != v1::COLOR_SPECTRAL) return;
  const auto film = wire::film_sensor_of(view);
  if (!film.ok()) return;  // of another version: the picture is Rec.709 as far as this one knows
  if (film->sensor.kind == spectra::SensorKind::kObserver) {
    set_space(film->space, image);
  } else {
    image.metadata[kRawChannels] = view.sensor();
  }
  image.metadata["tessera.sensor"] = view.sensor();
  image.metadata["tessera.white_balance"] = view.white_balance();
  add_white(*film, view, image);
  if (film->bands.count == 0) return;
  image.metadata[kFilmOfImage] = view.film();
  image.metadata["spectralLayoutVersion"] = std::string("1.0");
  // Spectral radiance is per nanometre, besides; the layout has this word for it.
  image.metadata["emissiveUnits"] = std::string("W.m^-2.sr^-1");
}

}  // namespace tessera::client
