// Published models of distortion, in double precision.
#pragma once

#include <memory>
#include <optional>

#include "tessera/v1/camera.pb.h"

namespace tessera::render {

struct PlanePoint {
  double x = 0, y = 0;
};

/// A place that another one is moved to, and the derivatives of its coordinates: xy is that of x by y.
struct PlaceAndSlopes {
  PlanePoint place;
  double xx = 1, xy = 0, yx = 0, yy = 1;

  double determinant() const { return xx * yy - xy * yx; }
};

/// From the places of a sensor without distortion to those of the film, or the other way. Places are those of
/// the sensor's raster (RasterShape), y upwards.
class DistortionModel {
 public:
  virtual ~DistortionModel() = default;
  /// Whether move() leads to the film, as with OpenCV's models; else from the film.
  virtual bool leads_to_film() const = 0;
  virtual PlaceAndSlopes move(PlanePoint from) const = 0;
};

/// Null for a message that has no formula.
std::unique_ptr<const DistortionModel> distortion_model(const v1::LensDistortion& distortion);

/// The point that `model` moves to `to`, by Newton's method from a point nearby; nothing where that does not
/// converge, or ends where the model folds. With the derivatives of `to` by the point.
std::optional<PlaceAndSlopes> find_origin(const DistortionModel& model, PlanePoint to, PlanePoint near);

}  // namespace tessera::render
