// Lens systems of cameras, for the kernels.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "optics/lens_system.h"
#include "render/sensor/lens_table.h"
#include "render/sensor/sensor_record.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Between the lens and its film.
struct FocusedLens {
  optics::LensSystem system;
  double film_distance = 1;  // to the film from where it sees things as large as they are, mm
};

/// InvalidArgument with all that is wrong with the lens.
absl::StatusOr<FocusedLens> focus_lens(const v1::LensCamera& camera);

/// The lens in front of a film whose places the record has. In jobs without wavelengths, where
/// SensorRecord::disperses is not set, indices are those at the Fraunhofer line D, as with all materials.
std::shared_ptr<const LensTable> lens_table(const v1::LensCamera& camera, const FocusedLens& lens,
                                            const SensorRecord& sensor);

/// The warning where a film is wider than the circle of light that the lens casts, with figures; else empty.
/// `sensor` is what the camera has become, of whatever kind.
std::string dark_film_warning(const v1::Camera& camera, const SensorRecord& sensor);

}  // namespace tessera::render
