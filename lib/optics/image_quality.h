// How good the picture of a lens is, by rays: what makers print in data sheets.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "optics/lens_system.h"

namespace tessera::optics {

/// Part of the light along the axis that the surfaces let through: 1 less what each reflects [Born & Wolf
/// 1999, section 1.6], bare or coated with its layer. Glass absorbs nothing here.
double transmittance(const LensSystem& lens, double nm);

/// What is sharp within a circle of confusion, as distances from the film: a pinhole's blur through the
/// entrance pupil. `far` may be infinity.
struct DepthOfField {
  double near = 0, far = 0;
};
DepthOfField depth_of_field(const LensSystem& lens, double circle_of_confusion);

/// A place of the film, `height` from its middle.
struct FieldPoint {
  double height = 0;
  double angle = 0;         // of its principal ray to the axis in the scene, radians
  double distortion = 0;    // height over that of a lens without distortion, less 1
  double illumination = 0;  // irradiance over that in the middle, the scene being of one radiance
  double open_pupil = 0;    // part of the middle's pupil that is not vignetted, by area
  double spot_rms = 0;      // RMS distance from the centroid, of lines F, d and C where the glass disperses
  // Along the axis from the film to where rays next to the principal ray meet, above 0 towards the lens: in
  // the plane with the axis, and across it.
  double tangential_focus = 0, sagittal_focus = 0;
  std::vector<Vector> spot;  // places on the film about the centroid
  // Contrast of lines that run across the radius and along it, one for each frequency; diffraction apart.
  std::vector<double> tangential_mtf, sagittal_mtf;
};

/// `frequencies` in line pairs a millimetre. Nothing where no light comes to that height, or comes from
/// behind.
std::optional<FieldPoint> field_point(const LensSystem& lens, double height,
                                      std::span<const double> frequencies);

/// The ray from a place of the film that crosses the middle of the stop; nothing where there is none.
std::optional<Ray> principal_ray(const LensSystem& lens, double height, double nm);

}  // namespace tessera::optics
