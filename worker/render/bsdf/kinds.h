// The kinds of BSDFs, and what the reader of a kind's message (scene/material) and its model (bsdf/model)
// agree on: the slots that its parameters are in, and the bits of its variants. Nothing else knows what they
// mean.
#pragma once

#include <cstdint>

namespace tessera::render {

/// Each kind but kMix has a model, at the end of whose file it is named; kinds from kCount on are those that
/// add_bsdf() gives.
enum class BsdfKind : std::int32_t {
  kInterface,  // nothing there: paths go straight on
  kDiffuse,
  kConductor,
  kDielectric,
  kThinDielectric,
  kCoatedDiffuse,
  kDiffuseTransmission,
  kPlastic,
  kCoatedConductor,
  kHair,
  kPrincipled,
  kPrincipledThin,
  kPhong,
  kGltf,
  kMix,  // resolved into its two parts before any BSDF is asked
  kCount
};

/// The kind of a surface that is not there.
inline constexpr BsdfKind kNoSurface = BsdfKind::kInterface;

/// Indices into the slots of a MaterialRecord and of its ExtendedRecord, and so of BsdfParams.
namespace slot {

// spectra
inline constexpr int kReflectance = 0;                            // diffuse bases; base colour of principled
inline constexpr int kTransmittance = 1;                          // diffuse transmission
inline constexpr int kReflectionTint = 0, kTransmissionTint = 1;  // dielectrics
inline constexpr int kConductorEta = 0, kConductorK = 1;          // conductors
inline constexpr int kCoatTint = 1;                               // plastic
inline constexpr int kGloss = 1;                                  // Phong
inline constexpr int kAbsorption = 0;                             // hair

// scalars
inline constexpr int kAlphaX = 0, kAlphaY = 1;          // roughness of the (outer) microfacets
inline constexpr int kEta = 2;                          // index of refraction
inline constexpr int kBetaM = 0, kBetaN = 1;            // hair
inline constexpr int kRoughness = 0, kAnisotropic = 1;  // principled
inline constexpr int kExponent = 2;                     // Phong
inline constexpr int kMixAmount = 0;                    // mixes

// ExtendedRecord::spectra
inline constexpr int kConductorTint = 0;

// ExtendedRecord::scalars
inline constexpr int kBaseAlphaX = 0, kBaseAlphaY = 1, kThickness = 2;  // coated conductor
inline constexpr int kTilt = 0, kFibreOffset = 1;                       // hair
inline constexpr int kMetallic = 0, kSpecTrans = 1, kSpecTint = 2, kSheen = 3, kSheenTint = 4, kFlatness = 5,
                     kClearcoat = 6, kClearcoatGloss = 7, kDiffTrans = 8;  // principled
// glTF, which has roughness, anisotropic and eta where principled has them, and these in its place; with
// kSpecularColor among the spectra, kSheenColor and kBehindColor among the extended ones
inline constexpr int kSpecularColor = 1, kSheenColor = 0, kBehindColor = 1;
inline constexpr int kTransmission = 1, kSpecular = 2, kCoat = 3, kCoatRoughness = 4, kSheenRoughness = 5,
                     kRotation = 6, kBehind = 7;
// ... and ExtendedRecord::further_colors and further: the direction of the anisotropy as a normal map has
// it; share, index and thickness (nm) of a thin film, by how much the indices of red and blue are off kEta
inline constexpr int kAnisotropyDirection = 0;
inline constexpr int kFilm = 0, kFilmEta = 1, kFilmThickness = 2, kSpread = 3;

/// Largest exponent of Phong's and Blinn's lobes: sharper ones have no digits left in single precision.
inline constexpr float kMostPhongExponent = 1e4f;

}  // namespace slot

/// Bits of MaterialRecord::variants: forms of a model that it alone asks for. These mean the same in all
/// models that have them; from kOwnVariant on each model has its own.
enum CommonVariants : std::int32_t {
  kBeckmann = 1 << 0,          // microfacets of Beckmann's distribution instead of GGX
  kSeparableMasking = 1 << 1,  // masking and shadowing multiply instead of being correlated by height
  kBalanced = 1 << 2,          // Roughness::multiple_scattering; coat_table is of bsdf/tables/balance_table.h
  kTinted = 1 << 3,            // the tints among the slots are not all 1
  kOwnVariant = 1 << 4
};
enum PlasticVariants : std::int32_t { kNonlinear = kOwnVariant };  // PlasticMaterial::nonlinear
enum HairVariants : std::int32_t {
  kHairReflectance = kOwnVariant  // spectra[0] is the colour of much hair, not its absorption
};
enum PhongVariants : std::int32_t {
  kBlinn = kOwnVariant,           // the lobe is of the half vector
  kMirrorLobe = kOwnVariant << 1  // the lobe is a mirror
};

}  // namespace tessera::render
