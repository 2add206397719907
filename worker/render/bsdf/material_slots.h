// The parameters of the materials at 16 points: constants fetched, textures looked up.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/color/spectra.h"
#include "render/color/texture_table.h"

namespace tessera::render::TESSERA_ISA {

/// Fills `params` with the flags, variants and constants of the active lanes' records. `common` is the record
/// of all of them, null where they differ.
void load_constants(const MaterialTable& materials, Int record, const MaterialRecord* common, Int flags,
                    const Spectra& spectra, Mask active, BsdfParams& params);

/// Whether constants are not all there is: complete_parameters() has to follow.
TESSERA_INLINE bool incomplete(const BsdfParams& params) {
  return (params.some_flags & (kHasTextures | kUsesExtended | kPrepared)) != 0;
}

/// Looks the textures up at `at`, and does what the models of these kinds do themselves.
void complete_parameters(const MaterialTable& materials, const TextureTable& textures, const TexturePoint& at,
                         Int record, Int kind, const Spectra& spectra, Mask active, BsdfParams& params);

}  // namespace tessera::render::TESSERA_ISA
