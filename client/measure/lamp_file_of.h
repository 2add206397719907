// Measured intensities as photometric files.
#pragma once

#include "absl/status/statusor.h"
#include "measure/measured.h"
#include "photometry/lamps/luminaire.h"
#include "tessera/v1/meter.pb.h"

namespace tessera::client {

/// The luminaire of an intensity meter, whose readings go plane by plane and are in cd: with all planes from
/// 0 to 360 degrees, and absolute. InvalidArgument where the meter is another, in another unit, or a figure
/// is negative.
absl::StatusOr<photometry::Luminaire> luminaire_of(const v1::Meter& meter, const MeasuredMeter& measured);

}  // namespace tessera::client
