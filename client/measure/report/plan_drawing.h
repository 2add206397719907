// A plan: places of meters and planes, seen from above. For the sources of this folder only.
#pragma once

#include <vector>

#include "measure/measured.h"
#include "measure/report/measured_html.h"
#include "plot/canvas.h"

namespace tessera::client {

/// Drawing of all meters' places on a page of `width` points: x to the right and y, or -z where y is up,
/// upwards, with coordinates of the world. Places are discs, planes are outlines; the meters' numbers are
/// those of the report's table.
class PlanDrawing {
 public:
  PlanDrawing(const Measured& measured, const MeasuredReportOptions& options, double width);

  /// Whether some meter has a place.
  bool has_places() const { return has_places_; }
  double height() const;
  void draw(Canvas& canvas) const;

 private:
  struct Flat {
    double x = 0, y = 0;
  };
  Flat flat(const Imath::V3d& point) const;
  PagePoint on_page(const Flat& point) const;
  void add(const Flat& point);
  void draw_frame(Canvas& canvas) const;
  void draw_bounds(Canvas& canvas) const;
  void draw_meter(Canvas& canvas, const MeasuredMeter& meter, const std::string& label,
                  std::vector<PagePoint>& labels) const;

  const Measured& measured_;
  const MeasuredReportOptions& options_;
  const double width_;
  bool has_places_ = false;
  Flat low_, high_;
  double scale_ = 1;  // points a unit
};

}  // namespace tessera::client
