// Spectra of messages as colours.
#pragma once

#include "absl/status/status.h"
#include "spectra/color/rgb.h"
#include "spectra/curve.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A spectrum as light, and as matter; white means the same as in spectra/rgb/scene_rgb.h.
spectra::Rgb emission(const v1::Spectrum& spectrum);
spectra::Rgb reflectance(const v1::Spectrum& spectrum);

spectra::Curve curve_of(const v1::SampledSpectrum& sampled);

/// InvalidArgument for numbers that are not finite, and for samples that do not ascend or do not pair up.
absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what);

}  // namespace tessera::render
