#include "image/spectral_image.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "image/color_space.h"
#include "spectra/sensor/bands.h"
#include "wire/colour_channels.h"

namespace tessera::client {

absl::StatusOr<std::vector<BandPlane>> bands_of(const Image& image) {
  std::vector<BandPlane> bands;
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    if (const std::optional<double> nm = spectra::centre_of_channel(image.channels[c].name))
      bands.push_back({*nm, *nm, *nm, c});
  }
  if (bands.empty())
    return absl::InvalidArgumentError(
        "the image has no bands (channels S0.550,000000nm): --film spectral:N renders them");
  std::ranges::sort(bands, {}, &BandPlane::centre_nm);
  const auto told = image.metadata.find(kFilmOfImage);
  if (told != image.metadata.end() && std::holds_alternative<std::string>(told->second)) {
    const auto film = spectra::parse_film(std::get<std::string>(told->second));
    if (film.ok() && film->count == static_cast<int>(bands.size())) {
      for (std::size_t b = 0; b < bands.size(); ++b) {
        bands[b].from_nm = film->begin(static_cast<int>(b));
        bands[b].to_nm = film->begin(static_cast<int>(b) + 1);
      }
      return bands;
    }
  }
  if (bands.size() == 1)
    return absl::InvalidArgumentError("the image has one band, whose width it does not tell");
  for (std::size_t b = 0; b + 1 < bands.size(); ++b)
    bands[b].to_nm = bands[b + 1].from_nm = (bands[b].centre_nm + bands[b + 1].centre_nm) / 2;
  bands.front().from_nm = 2 * bands.front().centre_nm - bands.front().to_nm;
  bands.back().to_nm = 2 * bands.back().centre_nm - bands.back().from_nm;
  return bands;
}

absl::StatusOr<Image> seen_by(const Image& image, const spectra::SensorResponse& sensor) {
  const auto bands = bands_of(image);
  if (!bands.ok()) return bands.status();
  std::array<std::vector<double>, 3> sums;
  sums.fill(std::vector<double>(image.pixel_count()));
  for (const BandPlane& band : *bands) {
    const spectra::Triple response = spectra::seen(sensor, band.from_nm, band.to_nm);
    const std::vector<float>& radiance = image.channels[band.channel].values;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < radiance.size(); ++i) sums[c][i] += response[c] * double{radiance[i]};
    }
  }
  Image result{.data = image.data, .display = image.display, .channels = {}, .metadata = image.metadata};
  for (const char* key :
       {kFilmOfImage, kRawChannels, kChromaticities, "spectralLayoutVersion", "emissiveUnits"})
    result.metadata.erase(key);
  for (std::size_t c = 0; c < 3; ++c) {
    Channel& channel = result.add(wire::kColourChannels[c]);
    std::ranges::transform(sums[c], channel.values.begin(), [](double v) { return static_cast<float>(v); });
  }
  if (const Channel* const alpha = image.find("A")) result.channels.push_back(*alpha);
  return result;
}

}  // namespace tessera::client
