// Tints of dielectrics: factors that the formats allow and physics does not.
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

/// `light` times spectra[0] where it was reflected and spectra[1] elsewhere, in lanes that have kTinted.
TESSERA_INLINE Spectrum tinted(const BsdfParams& params, Mask reflected, Spectrum light) {
  if ((params.some_variants & kTinted) == 0) return light;
  return select(params.of_variant(kTinted),
                light * select(reflected, params.spectra[slot::kReflectionTint],
                               params.spectra[slot::kTransmissionTint]),
                light);
}

}  // namespace tessera::render::TESSERA_ISA
