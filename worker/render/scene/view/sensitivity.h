// The sensor of a job's pictures -> SensitivityTable.
#pragma once

#include "absl/status/statusor.h"
#include "render/color/spectral_tables.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/film_sensor.h"

namespace tessera::render {

/// `film` has the sensitivities of a sensor of its own. InvalidArgument where they are needed and not usable,
/// or where the sensor sees nothing of the light of its white balance.
absl::StatusOr<SensitivityTable> build_sensitivity(const wire::FilmSensor& asked, const v1::Film& film);

}  // namespace tessera::render
