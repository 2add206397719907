// The sensor and the bands of a job's pictures, as its view says them in words.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "spectra/color/rgb_space.h"
#include "spectra/curve.h"
#include "spectra/sensor/bands.h"
#include "spectra/sensor/sensor_name.h"
#include "tessera/v1/job.pb.h"

namespace tessera::wire {

struct FilmSensor {
  spectra::NamedSensor sensor;
  std::optional<spectra::Curve> white;  // scaled to a luminance of 1; absent: no white balance
  spectra::RgbSpace space;              // of observers
  spectra::Bands bands;
};

/// The primaries and the white of a space; Rec.709 where it is unspecified.
const spectra::RgbSpace& primaries_of(v1::RgbSpace space);

/// Words that are absent mean the usual ones: jobs of older versions left them out. InvalidArgument, with all
/// that is wrong, for words that mean nothing.
absl::StatusOr<FilmSensor> film_sensor_of(const v1::JobSpec::View& view);

/// The bands of pictures whose words have been checked.
spectra::Bands bands_of(const v1::JobSpec::View& view);

/// InvalidArgument where the words mean nothing, or do not go together.
absl::Status check_film_words(const v1::JobSpec::View& view);

/// The same, and where a job of RGB asks
/// for what only light of wavelengths has.
absl::Status check_film_sensor(const v1::JobSpec& spec);

}  // namespace tessera::wire
