// How bright lights are, as LightAmount says it: units against the light that a record makes.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "photometry/units/light_unit.h"
#include "render/light/light_table.h"
#include "render/scene/spectral/spectral_builder.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// What the numbers of a scene stand for, with what it leaves unsaid filled in.
struct SceneScale {
  double metres = 1;       // the unit of length
  double cd_per_m2 = 683;  // luminance of a radiance of luminance 1
  bool says_metres = false;

  /// InvalidArgument for lengths and luminances that are negative or not finite.
  static absl::StatusOr<SceneScale> of(const v1::SceneUnits& units);
};

/// An amount in base units: lm, cd, lx, cd/m2, or W, W/sr, W/m2, W/(m2 sr).
struct Amount {
  double value = 0;
  photometry::Quantity quantity = photometry::Quantity::kFlux;
  bool photometric = true;

  bool needs_metres() const {
    return quantity == photometry::Quantity::kFlux || quantity == photometry::Quantity::kIntensity;
  }
};

/// InvalidArgument for values that are negative or not finite, units that are none, and units that do not
/// fit: the message names those that do.
absl::StatusOr<Amount> read_amount(const v1::LightAmount& amount, const v1::Light& light);
absl::StatusOr<Amount> read_amount(const v1::LightAmount& amount, const v1::AreaLight& light);

/// How much light of a spectrum a record of radiance, intensity or irradiance 1 times that spectrum makes, in
/// base units of the amount's kind; 0 where there is none. `spectral`: null in jobs of RGB, where watts are
/// lumens over 683.
double light_of_record(const Amount& amount, const SpectralEmission& emission, const SceneScale& scale,
                       const SpectralBuilder* spectral);

/// The solid angle that the intensity on the axis would fill alone to give the whole light of a kPoint,
/// kSpot, kProjection or kGoniometric without a texture, or of their soft kinds, in sr.
double filled_solid_angle(const LightRecord& light);

/// Luminance, as renderers of RGB have it.
double luminance_of(const spectra::Rgb& color);

}  // namespace tessera::render
