// A report of measured figures as one page of HTML (docs/measuring-reports.md).
#pragma once

#include <ImathVec.h>

#include <string>

#include "measure/measured.h"
#include "measure/report/plane_maps.h"

namespace tessera::client {

struct MeasuredReportOptions {
  std::string title = "Measured light";
  PlaneMapOptions maps;
  bool y_up = false;        // the plan looks down the y axis; else down the z axis
  bool has_bounds = false;  // the plan shows the scene's bounds, world space
  Imath::V3d bounds_low{}, bounds_high{};
};

/// Returns a page that needs nothing but itself: no scripts, no links, pictures within. It is well-formed
/// XML, too.
std::string measured_html(const Measured& measured, const MeasuredReportOptions& options = {});

/// The same of a series: diagrams of all meters over its steps, then each step, folded.
std::string measured_html(const MeasuredSeries& series, const MeasuredReportOptions& options = {});

}  // namespace tessera::client
