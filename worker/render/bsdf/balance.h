// Multiple scattering between microfacets, for models with kBalanced: single scattering times s(wo) s(wi),
// with factors by which nothing is lost [balance_table.h]. Reciprocal as single scattering is, and sampled as
// that is: the density is the same, and weights stay below the square of the largest factor, which for
// mirrors is 2.1.
//
// Where facets absorb, light that scatters more than once is absorbed more than once: of what the factors
// add, a conductor keeps F k / (1 - F (1 - k)) with its mean reflectance F and the mean energy k that single
// scattering keeps, the geometric series of [Kulla & Conty 2017].
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/microfacet.h"
#include "render/bsdf/tables/balance_table.h"

namespace tessera::render::TESSERA_ISA {

/// The table of each lane's material. Factors are 1 in lanes that have none.
class Balance {
 public:
  /// For the roughness of the microfacets.
  TESSERA_INLINE Balance(const BsdfParams& params, Mask lanes)
      : lanes_(lanes & params.of_variant(kBalanced)),
        table_(params.coat_tables),
        offset_(params.coat_table),
        first_(gather(table_ + kBalanceFirst, offset_, lanes_)),
        per_row_(gather(table_ + kBalancePerRow, offset_, lanes_)) {
    const Ggx facets = ggx_of(params.scalars[slot::kAlphaX], params.scalars[slot::kAlphaY]);
    alpha2_x_ = sqr(facets.alpha_x);
    alpha2_y_ = sqr(facets.alpha_y);
  }

  /// s(w) for w above the surface (z > 0), or mirrored to there where `below`.
  TESSERA_INLINE Float factor(Vec3 w, Mask below) const {
    // Along the normal any row does.
    constexpr float kTiny = 1e-20f;
    const Float x2 = fma(w.x, w.x, Float(kTiny)), y2 = fma(w.y, w.y, Float(kTiny));
    const Position row = row_of(fma(alpha2_x_, x2, alpha2_y_ * y2) / (x2 + y2));
    const Float column = clamp(sqrt(max(w.z, 0.0f)) * (kBalanceCosines - 1.0f), 0.0f, kBalanceCosines - 1.0f);
    const Float low = min(floor(column), kBalanceCosines - 2.0f);
    const Int side = select(below, Int(kBalanceRows * kBalanceCosines), Int(0));
    const Int entry = offset_ + side + row.index * kBalanceCosines + to_int(low);
    const auto along_row = [&](const float* start) {
      return lerp(column - low, gather(start, entry, lanes_), gather(start + 1, entry, lanes_));
    };
    const float* factors = table_ + kBalanceFactors;
    return select(lanes_, lerp(row.t, along_row(factors), along_row(factors + kBalanceCosines)), 1.0f);
  }

  /// Mean energy that single scattering keeps without absorption.
  TESSERA_INLINE Float kept() const {
    const Position row = row_of(alpha2_x_);  // position of all rows, unless alphas are the same
    const Int entry = offset_ + row.index;
    return lerp(row.t, gather(table_ + kBalanceKept, entry, lanes_),
                gather(table_ + kBalanceKept + 1, entry, lanes_));
  }

 private:
  struct Position {
    Int index;
    Float t;
  };

  TESSERA_INLINE Position row_of(Float alpha2) const {
    const Float position = clamp((sqrt(sqrt(alpha2)) - first_) * per_row_, 0.0f, kBalanceRows - 1.0f);
    const Float low = min(floor(position), kBalanceRows - 2.0f);
    return {to_int(low), position - low};
  }

  Mask lanes_;
  const float* table_;
  Int offset_;
  Float first_, per_row_;
  Float alpha2_x_, alpha2_y_;
};

/// s(wo) s(wi) in lanes that have kBalanced, for directions mirrored so that wo is above; `below` says where
/// it was not. Inlined, it would cost the materials that have none.
[[gnu::noinline]] inline Float balance_factor(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask below,
                                              Mask lanes) {
  const Balance balance(params, lanes);
  return balance.factor(wo, below) * balance.factor(mirror_if(wi.z < 0.0f, wi), below ^ (wi.z < 0.0f));
}

}  // namespace tessera::render::TESSERA_ISA
