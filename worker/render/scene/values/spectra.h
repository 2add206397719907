// Spectra of messages as colours.
#pragma once

#include "absl/status/status.h"
#include "render/color/cie.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A spectrum as light, and as matter; white means the same as in color/cie.h.
Rgb emission(const v1::Spectrum& spectrum);
Rgb reflectance(const v1::Spectrum& spectrum);

SampledCurve curve_of(const v1::SampledSpectrum& sampled);

/// InvalidArgument for numbers that are not finite, and for samples that do not ascend or do not pair up.
absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what);

}  // namespace tessera::render
