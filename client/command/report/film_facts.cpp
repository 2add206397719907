#include "command/report/film_facts.h"

#include <string>

#include "image/color_space.h"
#include "image/spectral_image.h"
#include "wire/film_sensor.h"

namespace tessera::client {

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
  if (film->bands.count == 0) return;
  image.metadata[kFilmOfImage] = view.film();
  image.metadata["spectralLayoutVersion"] = std::string("1.0");
  // Spectral radiance is per nanometre, besides; the layout has this word for it.
  image.metadata["emissiveUnits"] = std::string("W.m^-2.sr^-1");
}

}  // namespace tessera::client
