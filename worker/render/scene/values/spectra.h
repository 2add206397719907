// Spectra of messages as colours.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "spectra/color/rgb.h"
#include "spectra/curve.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A spectrum as light, and as matter; white means the same as in spectra/rgb/scene_rgb.h.
spectra::Rgb emission(const v1::Spectrum& spectrum);
spectra::Rgb reflectance(const v1::Spectrum& spectrum);

/// The curve of a spectrum that was measured, sampled or named; nothing of others.
std::optional<spectra::Curve> measured_curve(const v1::Spectrum& spectrum);

/// InvalidArgument for numbers that are not finite, for samples that make no curve (spectra::check_curve),
/// and for names that nothing has, with the nearest.
absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what);

}  // namespace tessera::render
