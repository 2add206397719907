#include "render/scene/values/spectra.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "spectra/named_spectra.h"
#include "spectra/rgb/scene_rgb.h"

namespace tessera::render {

std::optional<spectra::Curve> measured_curve(const v1::Spectrum& spectrum) {
  if (spectrum.kind_case() == v1::Spectrum::kNamed) return spectra::find_named_spectrum(spectrum.named());
  if (!spectrum.has_sampled()) return std::nullopt;
  const v1::SampledSpectrum& sampled = spectrum.sampled();
  return spectra::Curve{{sampled.wavelengths_nm().begin(), sampled.wavelengths_nm().end()},
                        {sampled.values().begin(), sampled.values().end()}};
}

spectra::Rgb emission(const v1::Spectrum& spectrum) {
  if (spectrum.has_in_rgb()) return {spectrum.in_rgb().r(), spectrum.in_rgb().g(), spectrum.in_rgb().b()};
  switch (spectrum.kind_case()) {
    case v1::Spectrum::kRgb:
      return {spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()};
    case v1::Spectrum::kConstant:
      return {spectrum.constant(), spectrum.constant(), spectrum.constant()};
    case v1::Spectrum::kSampled:
    case v1::Spectrum::kNamed:
      if (const auto curve = measured_curve(spectrum)) return spectra::emission_rgb(*curve);
      break;
    case v1::Spectrum::kBlackbody:
      return spectra::blackbody_rgb(spectrum.blackbody().kelvin());
    case v1::Spectrum::KIND_NOT_SET:
      break;
  }
  return {};
}

spectra::Rgb reflectance(const v1::Spectrum& spectrum) {
  if (spectrum.has_in_rgb()) return emission(spectrum);
  if (const auto curve = measured_curve(spectrum)) return spectra::reflectance_rgb(*curve);
  return emission(spectrum);
}

absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what) {
  const auto bad = [&](auto... reason) {
    return absl::InvalidArgumentError(absl::StrCat(what, ": ", reason...));
  };
  const auto curve = measured_curve(spectrum);
  if (!curve && spectrum.kind_case() == v1::Spectrum::kNamed) {
    return bad("no spectrum is called '", spectrum.named(), "'",
               base::did_you_mean(spectrum.named(), spectra::names_of_spectra()));
  }
  if (curve) {
    if (auto status = spectra::check_curve(*curve); !status.ok()) return bad(status.message());
  }
  if (spectrum.has_blackbody() && !(spectrum.blackbody().kelvin() > 0))
    return bad("a blackbody of ", spectrum.blackbody().kelvin(), " K is not above 0 K");
  const spectra::Rgb rgb = emission(spectrum);
  if (!std::isfinite(rgb.r) || !std::isfinite(rgb.g) || !std::isfinite(rgb.b))
    return bad("a colour is not finite");
  return absl::OkStatus();
}

}  // namespace tessera::render
