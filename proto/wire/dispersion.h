// Dispersion of messages as formulas.
#pragma once

#include "absl/status/statusor.h"
#include "spectra/matter/dispersion.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::wire {

/// InvalidArgument for a glass that nobody knows, with the nearest name and all names, and for indices that
/// are no numbers, or beyond wire::check_index(), at some wavelength that is seen.
absl::StatusOr<spectra::Dispersion> dispersion_of(const v1::Dispersion& dispersion);

}  // namespace tessera::wire
