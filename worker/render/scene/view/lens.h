// Lens systems of cameras, for the kernels.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "optics/lens_system.h"
#include "render/scene/blob_source.h"
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

/// Things that a camera's lens is built with, besides its message.
struct LensSurroundings {
  const BlobSource* blobs = nullptr;  // has its image files; null: there are none
  bool focused_later = false;         // Camera.focus_point says what is sharp
  bool takes_light = false;           // ghosts of lights are found from the lights, too
};

/// The lens in front of a film whose places the record has. In jobs without wavelengths, where
/// SensorRecord::disperses is not set, indices are those at the Fraunhofer line D, as with all materials.
/// InvalidArgument where the picture of its stop is not usable.
absl::StatusOr<std::shared_ptr<const LensTable>> lens_table(const v1::LensCamera& camera,
                                                            const FocusedLens& lens,
                                                            const SensorRecord& sensor,
                                                            const LensSurroundings& surroundings);

/// The warning where a film is wider than the circle of light that the lens casts, with figures; else empty.
/// `sensor` is what the camera has become, of whatever kind.
std::string dark_film_warning(const v1::Camera& camera, const SensorRecord& sensor);

}  // namespace tessera::render
