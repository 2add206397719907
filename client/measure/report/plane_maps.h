// Maps, histograms and sections of measured planes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/image.h"
#include "measure/measured.h"
#include "plot/axes_plot.h"
#include "plot/false_color.h"

namespace tessera::client {

struct PlaneMapOptions {
  ColorMap map = ColorMap::kCividis;
  ScaleKind scale = ScaleKind::kLinear;
  std::optional<ValueRange> range{};  // absent: that of the plane's figures
  bool isolines = true;
  bool smooth = false;           // linear between the middles of cells; else a cell has one colour
  std::uint32_t exr_pixels = 1;  // of an EXR, each way a cell
};

/// How the plane's map looks: titles, unit, lengths of its sides.
FalseColorOptions false_color_of(const Measured& measured, const MeasuredMeter& meter,
                                 const MeasuredPlane& plane, const PlaneMapOptions& options);

/// Values as channel Y, and their standard errors as "error.Y", with "tessera.meter", "tessera.quantity" and
/// "tessera.unit". The plane's corner is the lower left pixel; edge_u goes to the right, edge_v up.
/// InvalidArgument where the meter lacks readings.
absl::StatusOr<Image> plane_image(const MeasuredMeter& meter, const MeasuredPlane& plane,
                                  const PlaneMapOptions& options);

/// Writes the map as .png or .svg with legend, or the plane_image as .exr. InvalidArgument for another kind
/// of file, or where the meter lacks readings.
absl::Status write_plane_map(const Measured& measured, const MeasuredMeter& meter, const MeasuredPlane& plane,
                             const PlaneMapOptions& options, const std::string& path);

/// How often the plane's cells have which value, in the colours of its map.
AxesPlot plane_histogram(const MeasuredMeter& meter, const ValueGrid& grid, const PlaneMapOptions& options);

/// A line across a plane, in shares of edge_u and edge_v.
struct PlaneLine {
  double u0 = 0, v0 = 0.5, u1 = 1, v1 = 0.5;
};

/// Values of the cells that the line crosses, over the distance along it, with 95 % intervals.
AxesPlot plane_section(const Measured& measured, const MeasuredMeter& meter, const MeasuredPlane& plane,
                       const PlaneLine& line);

/// "W/m²" of "W/m2" and "W/m^2".
std::string unit_label(const std::string& unit);

}  // namespace tessera::client
