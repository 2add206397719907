// 95 % intervals of many figures.
#pragma once

#include <map>

#include "measure/report/figure_text.h"

namespace tessera::client {

/// Quantiles are searched for once for each number of degrees of freedom: figures of a plane share a few.
class Intervals {
 public:
  ConfidenceInterval of(const Figure& figure) {
    if (is_exact(figure)) return {figure.value, figure.value};
    auto [found, added] = factors_.try_emplace(figure.degrees_of_freedom);
    if (added) {
      const ConfidenceInterval unit =
          confidence_95({.value = 0, .standard_error = 1, .degrees_of_freedom = figure.degrees_of_freedom});
      found->second = unit.high;
    }
    const double half = found->second * figure.standard_error;
    return {figure.value - half, figure.value + half};
  }

 private:
  std::map<double, double> factors_;
};

}  // namespace tessera::client
