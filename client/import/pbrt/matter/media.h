// MakeNamedMedium -> Medium messages.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// The medium of `type` ("homogeneous", "uniformgrid", "rgbgrid", "cloud"), without its name; nothing after
/// an error.
std::optional<v1::Medium> read_medium(const std::string& type, ValueReader& values,
                                      const Imath::M44d& world_from_medium);

/// Reduced scattering and absorption, 1/mm.
struct MeasuredMedium {
  std::array<double, 3> sigma_s, sigma_a;
};

/// Media of the literature by pbrt's names: "Wholemilk", "Marble", ...
std::optional<MeasuredMedium> find_measured_medium(std::string_view name);

/// Density of pbrt-v4's "cloud" at a point of its own space, 0 to 1.
struct CloudShape {
  double density = 1, wispiness = 1, frequency = 5;

  double at(const Imath::V3d& p) const;
};

}  // namespace tessera::client::pbrt
