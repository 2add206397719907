// The wide side of sampling/alias_table.h.
#pragma once

#include "render/core/constants.h"
#include "render/core/wide.h"
#include "render/sampling/alias_table.h"

namespace tessera::render::TESSERA_ISA {

struct DiscreteSample {
  Int index;
  Float pmf;  // probability of `index`
  Float u;    // `u` again uniform in [0, 1); what is left of its 24 bits
};

/// An outcome of the table, which is not empty, in proportion to its weight; `u` is uniform in [0, 1).
TESSERA_INLINE DiscreteSample sample_discrete(const AliasTable& table, Float u, Mask active) {
  const int n = static_cast<int>(table.pmf.size());
  const Float scaled = u * static_cast<float>(n);
  const Int bin = min(to_int(scaled), n - 1);
  const Float in_bin = min(scaled - to_float(bin), kOneMinusEpsilon);

  const Float threshold = gather(table.threshold.data(), bin, active);
  const Mask stay = in_bin < threshold;
  const Int index = select(stay, bin, gather(table.alias.data(), bin, and_not(active, stay)));

  // Stretch the part of the bin that was hit to [0, 1); neither part is empty where it was hit.
  const Float above = in_bin - threshold, rest = 1.0f - threshold;
  const Float remapped =
      select(stay, in_bin, above) / select(stay, threshold, select(rest > 0.0f, rest, 1.0f));
  return {index, gather(table.pmf.data(), index, active), min(remapped, kOneMinusEpsilon)};
}

/// Probability of an outcome; zero for lanes that are not active.
TESSERA_INLINE Float discrete_pmf(const AliasTable& table, Int index, Mask active) {
  return gather(table.pmf.data(), index, active);
}

}  // namespace tessera::render::TESSERA_ISA
