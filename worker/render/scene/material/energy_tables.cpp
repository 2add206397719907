#include "render/scene/material/energy_tables.h"

#include "render/bsdf/tables/coat_table.h"
#include "render/bsdf/tables/film_table.h"
#include "render/bsdf/tables/gltf_layer_table.h"
#include "render/bsdf/tables/plastic_table.h"

namespace tessera::render {

std::int32_t EnergyTables::coat(float eta, float thickness) {
  return computes_ ? append_coat_table(eta, thickness, table_) : -1;
}

std::int32_t EnergyTables::plastic(float eta, const BoundaryFacets& facets) {
  if (!computes_) return -1;
  const auto [offset, added] =
      plastic_.try_emplace({eta, facets.alpha, facets.beckmann, facets.separable_masking}, 0);
  if (added) offset->second = append_plastic_table(eta, facets, table_);
  return offset->second;
}

std::int32_t EnergyTables::balance(const BalancedFacets& facets) {
  if (!computes_) return -1;
  const auto [offset, added] = balance_.try_emplace(facets, 0);
  if (added) offset->second = append_balance_table(facets, table_);
  return offset->second;
}

std::int32_t EnergyTables::layers() {
  if (computes_ && layers_ < 0) layers_ = append_layer_table(table_);
  return layers_;
}

void EnergyTables::films() {
  if (computes_ && table_.film_table.empty()) table_.film_table = film_table();
}

}  // namespace tessera::render
