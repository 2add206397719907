#include "render/sampling/alias_table.h"

#include <cmath>
#include <numeric>

namespace tessera::render {

AliasTable AliasTable::build(std::span<const double> weights) {
  const std::size_t n = weights.size();
  std::vector<double> probability(n, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    if (std::isfinite(weights[i]) && weights[i] > 0) probability[i] = weights[i];
  // Scaled by the largest first, so that the sum of huge weights does not overflow.
  double largest = 0;
  for (const double p : probability) largest = std::fmax(largest, p);
  if (largest == 0) probability.assign(n, largest = 1);
  for (double& p : probability) p /= largest;
  const double sum = std::accumulate(probability.begin(), probability.end(), 0.0);

  AliasTable table;
  table.threshold.assign(n, 1.0f);
  table.alias.resize(n);
  std::iota(table.alias.begin(), table.alias.end(), 0);
  table.pmf.resize(n);

  // Bins below the mean take what they lack from one above it [Vose 1991].
  std::vector<double> scaled(n);
  std::vector<std::size_t> small, large;
  for (std::size_t i = 0; i < n; ++i) {
    table.pmf[i] = static_cast<float>(probability[i] / sum);
    scaled[i] = probability[i] / sum * static_cast<double>(n);
    (scaled[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const std::size_t under = small.back(), over = large.back();
    small.pop_back();
    table.threshold[under] = static_cast<float>(scaled[under]);
    table.alias[under] = static_cast<std::int32_t>(over);
    scaled[over] = (scaled[over] + scaled[under]) - 1;
    if (scaled[over] < 1) {
      large.pop_back();
      small.push_back(over);
    }
  }
  // The remaining weights differ from 1 by rounding only, and keep their threshold of 1.
  return table;
}

}  // namespace tessera::render
