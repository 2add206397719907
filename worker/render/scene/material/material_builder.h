// Materials of a scene's messages -> MaterialTable: their names, mixes and sides, bump and normal maps.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/bsdf/material_table.h"
#include "render/scene/material/energy_tables.h"
#include "render/scene/material/material_slots.h"
#include "render/scene/texture/texture_nodes.h"
#include "render/scene/values/fault_list.h"
#include "render/scene/values/name_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class MaterialBuilder {
 public:
  using Materials = google::protobuf::RepeatedPtrField<v1::Material>;

  /// `computes`: as in EnergyTables. `spectral`: for jobs of wavelengths only, else null.
  MaterialBuilder(TextureNodes& textures, MaterialTable& table, std::vector<std::string>& warnings,
                  bool computes = true, SpectralBuilder* spectral = nullptr)
      : textures_(textures),
        table_(table),
        warnings_(warnings),
        energies_(table, computes),
        spectral_(spectral) {}

  /// Adds all materials, and behind them the one of shapes that name none. InvalidArgument names the
  /// material.
  absl::Status build(const Materials& materials);
  /// The same, but goes on after a fault, until the list is full.
  void build(const Materials& materials, FaultList& faults);
  /// The empty name is that of the last.
  const NameTable& names() const { return names_; }

 private:
  absl::Status build_material(const v1::Material& material, MaterialRecord& record);
  absl::Status set_mix(const v1::MixMaterial& mix, MaterialSlots& slots);
  absl::Status set_sides(const v1::Material& material, MaterialRecord& record);
  absl::Status set_maps(const v1::Material& material, MaterialSlots& slots);
  void check_mixes(const Materials& materials, FaultList& faults) const;

  TextureNodes& textures_;
  MaterialTable& table_;
  std::vector<std::string>& warnings_;
  EnergyTables energies_;
  SpectralBuilder* const spectral_;
  NameTable names_{"material"};
};

}  // namespace tessera::render
