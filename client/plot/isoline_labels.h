// Places of labels along isolines. For the sources of this folder only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "plot/canvas.h"

namespace tessera::client {

struct LabelPlace {
  PagePoint at;
  double turned = 0;  // radians, between -pi/2 and pi/2: upright
};

/// Finds the place along a line where a text of `length` points bends least, within `within` and away from
/// those in `taken`. Nothing where the line is too short, or has no such place.
std::optional<LabelPlace> label_place(std::span<const PagePoint> line, double length, const PageBox& within,
                                      const std::vector<PagePoint>& taken);

}  // namespace tessera::client
