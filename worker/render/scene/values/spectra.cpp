#include "render/scene/values/spectra.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "spectra/rgb/scene_rgb.h"

namespace tessera::render {

spectra::Curve curve_of(const v1::SampledSpectrum& sampled) {
  return {{sampled.wavelengths_nm().begin(), sampled.wavelengths_nm().end()},
          {sampled.values().begin(), sampled.values().end()}};
}

spectra::Rgb emission(const v1::Spectrum& spectrum) {
  switch (spectrum.kind_case()) {
    case v1::Spectrum::kRgb:
      return {spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()};
    case v1::Spectrum::kConstant:
      return {spectrum.constant(), spectrum.constant(), spectrum.constant()};
    case v1::Spectrum::kSampled:
      return spectra::emission_rgb(curve_of(spectrum.sampled()));
    case v1::Spectrum::kBlackbody:
      return spectra::blackbody_rgb(spectrum.blackbody().kelvin());
    case v1::Spectrum::KIND_NOT_SET:
      break;
  }
  return {};
}

spectra::Rgb reflectance(const v1::Spectrum& spectrum) {
  if (spectrum.has_sampled()) return spectra::reflectance_rgb(curve_of(spectrum.sampled()));
  return emission(spectrum);
}

absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what) {
  const auto bad = [&](auto... reason) {
    return absl::InvalidArgumentError(absl::StrCat(what, ": ", reason...));
  };
  if (spectrum.has_sampled()) {
    const absl::Status status = spectra::check_curve(curve_of(spectrum.sampled()));
    return status.ok() ? status : bad(status.message());
  }
  const spectra::Rgb rgb = emission(spectrum);
  if (!std::isfinite(rgb.r) || !std::isfinite(rgb.g) || !std::isfinite(rgb.b))
    return bad("a colour is not finite");
  return absl::OkStatus();
}

}  // namespace tessera::render
