// A table of sigmoids for all colours of linear Rec.709, for fast look-up.
#pragma once

#include <cstddef>
#include <vector>

#include "spectra/color/rgb.h"
#include "spectra/observer/observer.h"
#include "spectra/upsampling/sigmoid.h"

namespace tessera::spectra {

/// Coefficients by which component is the largest, by that component, and by the ratios of the other two to
/// it [Jakob & Hanika 2019].
class SigmoidTable {
 public:
  /// Fits resolution^3 sigmoids for each component that may be the largest: with 24, 0.4 s and 500 kB. They
  /// have the same bits on every machine.
  explicit SigmoidTable(int resolution);

  /// Trilinear between the fits; components are in [0, 1]. Greys are exactly constant.
  SigmoidCoefficients look_up(const Rgb& rgb) const;

  /// Ordered by the largest component, its level, and the ratios of the next component and of the one after
  /// that, the last the fastest; as many of each as the resolution, but for the components.
  const std::vector<SigmoidCoefficients>& entries() const { return entries_; }
  /// Levels as they are interpolated, -1 / sqrt(largest component), and the ratios.
  const std::vector<double>& along_levels() const { return along_levels_; }
  const std::vector<double>& ratios() const { return ratios_; }

 private:
  /// Where an entry is: the largest component, its level, and the ratios of the two after it.
  struct Place {
    std::size_t largest, level, next, after_next;
  };

  std::size_t index(const Place& place) const;
  Triple fit(const Place& place, const Triple& start);
  void fit_levels(Place place);

  std::size_t resolution_;
  /// Values of the largest component that are in the table, ascending, and `along` them.
  std::vector<double> levels_, along_levels_;
  /// Ratios to it that are in the table, ascending from 0 to 1.
  std::vector<double> ratios_;
  std::vector<SigmoidCoefficients> entries_;
};

}  // namespace tessera::spectra
