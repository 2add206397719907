#include "render/scene/values/spectra.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace tessera::render {

SampledCurve curve_of(const v1::SampledSpectrum& sampled) {
  return {{sampled.wavelengths_nm().begin(), sampled.wavelengths_nm().end()},
          {sampled.values().begin(), sampled.values().end()}};
}

Rgb emission(const v1::Spectrum& spectrum) {
  switch (spectrum.kind_case()) {
    case v1::Spectrum::kRgb:
      return {spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()};
    case v1::Spectrum::kConstant:
      return {spectrum.constant(), spectrum.constant(), spectrum.constant()};
    case v1::Spectrum::kSampled:
      return emission_rgb(curve_of(spectrum.sampled()));
    case v1::Spectrum::kBlackbody:
      return blackbody_rgb(spectrum.blackbody().kelvin());
    case v1::Spectrum::KIND_NOT_SET:
      break;
  }
  return {};
}

Rgb reflectance(const v1::Spectrum& spectrum) {
  if (spectrum.has_sampled()) return reflectance_rgb(curve_of(spectrum.sampled()));
  return emission(spectrum);
}

absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what) {
  const auto bad = [&](auto... reason) {
    return absl::InvalidArgumentError(absl::StrCat(what, ": ", reason...));
  };
  const v1::SampledSpectrum& sampled = spectrum.sampled();
  if (spectrum.has_sampled()) {
    if (sampled.values().empty() || sampled.values_size() != sampled.wavelengths_nm_size()) {
      return bad("a sampled spectrum needs one value a wavelength, and at least one");
    }
    for (int i = 0; i < sampled.values_size(); ++i) {
      if (!std::isfinite(sampled.values(i)) || !std::isfinite(sampled.wavelengths_nm(i))) {
        return bad("a sampled spectrum holds a number that is not finite");
      }
      if (i > 0 && sampled.wavelengths_nm(i) <= sampled.wavelengths_nm(i - 1)) {
        return bad("the wavelengths of a sampled spectrum must ascend");
      }
    }
    return absl::OkStatus();
  }
  const Rgb rgb = emission(spectrum);
  if (!std::isfinite(rgb.r) || !std::isfinite(rgb.g) || !std::isfinite(rgb.b))
    return bad("a colour is not finite");
  return absl::OkStatus();
}

}  // namespace tessera::render
