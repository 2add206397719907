// Daylight of messages as the photometry library knows it.
#pragma once

#include <array>
#include <optional>

#include "absl/status/statusor.h"
#include "photometry/sky/sky.h"
#include "tessera/v1/light.pb.h"

namespace tessera::wire {

/// Directions of the horizon's frame in world space.
struct WorldHorizon {
  using Vector = std::array<double, 3>;
  Vector east, north, up;

  Vector world_from_horizon(const photometry::HorizonDirection& w) const;
  /// `v` of any length but 0.
  photometry::HorizonDirection horizon_from_world(const Vector& v) const;
};
WorldHorizon horizon_of(const v1::SkyLight& light);

/// Whether there is a sun in the light, by its message alone: a Perez sky has one if there is direct
/// irradiance, a CIE sky of the types 7 to 15 has, others have where they say how bright it is.
bool has_sun(const v1::SkyLight& light);

/// The sky, its sun and the ground in cd/m^2 and lx. InvalidArgument names the field that is at fault.
absl::StatusOr<photometry::Sky> sky_of(const v1::SkyLight& light);

/// The sun's altitude in degrees; nothing where the light does not say where the sun is. InvalidArgument as
/// of sky_of().
absl::StatusOr<std::optional<double>> sun_altitude_degrees(const v1::SkyLight& light);

/// How far the sun is across, degrees; 0: parallel light.
double sun_degrees(const v1::SkyLight& light);
/// Cells along a side of the sky's map.
int sky_resolution(const v1::SkyLight& light);

}  // namespace tessera::wire
