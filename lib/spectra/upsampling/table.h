// A table of sigmoids for all colours of linear Rec.709, for fast look-up.
#pragma once

#include <span>
#include <vector>

#include "spectra/color/rgb.h"
#include "spectra/upsampling/sigmoid.h"

namespace tessera::spectra {

/// The colours that a table has sigmoids of, by which component is the largest, and by the ratios of the
/// other two to it [Jakob & Hanika 2019].
struct SigmoidNodes {
  explicit SigmoidNodes(int resolution);

  /// Values of the largest component, ascending, and -1 / sqrt() of them, along which coefficients are
  /// interpolated.
  std::vector<double> levels, along_levels;
  /// Ratios to it, ascending from 0 to 1.
  std::vector<double> ratios;
};

class SigmoidTable {
 public:
  /// `rows` are those of fit_table(resolution), and must outlive the table.
  SigmoidTable(int resolution, std::span<const float> rows) : nodes_(resolution), rows_(rows) {}

  /// Trilinear between the fits; components are in [0, 1]. Greys are exactly constant.
  SigmoidCoefficients look_up(const Rgb& rgb) const;

  const SigmoidNodes& nodes() const { return nodes_; }
  std::span<const float> rows() const { return rows_; }

 private:
  SigmoidNodes nodes_;
  std::span<const float> rows_;
};

}  // namespace tessera::spectra
