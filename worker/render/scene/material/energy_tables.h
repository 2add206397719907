// Tables of the energy of rough boundaries that materials need, each computed once.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>

#include "render/bsdf/material_table.h"
#include "render/bsdf/tables/balance_table.h"
#include "render/bsdf/tables/boundary_energy.h"

namespace tessera::render {

/// Offsets in MaterialTable::coat_tables. Indices of refraction are those of the inside over the outside.
class EnergyTables {
 public:
  /// `computes` false: none is computed, where nothing will be rendered.
  explicit EnergyTables(MaterialTable& table, bool computes = true) : table_(table), computes_(computes) {}

  std::int32_t coat(float eta, float thickness);
  std::int32_t plastic(float eta, const BoundaryFacets& facets);
  std::int32_t balance(const BalancedFacets& facets);
  std::int32_t layers();
  /// Fills MaterialTable::film_table.
  void films();

 private:
  MaterialTable& table_;
  const bool computes_;
  std::map<std::tuple<float, double, bool, bool>, std::int32_t> plastic_;
  std::map<BalancedFacets, std::int32_t> balance_;
  std::int32_t layers_ = -1;
};

}  // namespace tessera::render
