// How much of the light along a direction a rough dielectric boundary reflects and lets through, by
// quadrature: what the tables of coats are made of.
#pragma once

namespace tessera::render {

/// Parts of the light along a direction that a boundary reflects and lets through; what is missing from 1
/// would need more than one bounce on the microfacets.
struct BoundaryEnergy {
  double reflected = 0;
  double transmitted = 0;
};

/// Microfacets of one roughness, as in microfacet.h.
struct BoundaryFacets {
  double alpha = 0;  // 0: smooth
  bool beckmann = false;
  bool separable_masking = false;
};

enum class Quadrature { kCoarse, kFine };  // 377 and 4181 points; the error falls as about their number

/// A boundary where `eta` is the index of the other side over that of the side that the light comes from, at
/// `cosine` > 0 to the normal.
BoundaryEnergy boundary_energy(double cosine, const BoundaryFacets& facets, double eta,
                               Quadrature quadrature = Quadrature::kCoarse);

}  // namespace tessera::render
