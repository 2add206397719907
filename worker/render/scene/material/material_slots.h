// Parameters that several kinds of materials have in common, into the slots of one material's record.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/bsdf/material_table.h"
#include "render/scene/material/energy_tables.h"
#include "render/scene/spectral/spectral_builder.h"
#include "render/scene/texture/texture_nodes.h"
#include "spectra/color/rgb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Tables that the materials of a scene share while they are made.
struct MaterialInputs {
  TextureNodes& textures;
  EnergyTables& energies;
  MaterialTable& table;
  std::vector<std::string>& warnings;
  SpectralBuilder* spectral = nullptr;  // jobs of wavelengths only
};

class MaterialSlots {
 public:
  MaterialSlots(const MaterialInputs& inputs, const std::string& name, MaterialRecord& material)
      : record(material), inputs_(inputs), name_(name) {}

  MaterialRecord& record;

  absl::Status set_spectrum(const v1::SpectrumValue& value, const spectra::Rgb& otherwise,
                            SpectrumSlot& slot);
  absl::Status set_scalar(const v1::FloatValue& value, float otherwise, ScalarSlot& slot);
  /// Sets the share of light that is scattered at all: textures at full resolution.
  absl::Status set_opacity(const v1::FloatValue& value);
  absl::Status set_tint(const v1::SpectrumValue& value, SpectrumSlot& slot);
  absl::Status set_roughness(const v1::Roughness& roughness, ScalarSlot& u, ScalarSlot& v);
  absl::Status set_eta(const v1::Spectrum& eta, float otherwise);
  /// The same of a coat, which has one index at all wavelengths; warns where a measured one varies.
  absl::Status set_coat_eta(const v1::Spectrum& eta, float otherwise);
  /// The same of a boundary that refracts light of each wavelength by its own index, in jobs of wavelengths,
  /// where one of the two has it.
  absl::Status set_dispersing_eta(const v1::Spectrum& eta, bool has_dispersion,
                                  const v1::Dispersion& dispersion, float otherwise);
  /// In jobs of wavelengths, lets the index be this function of nanometres, if it varies at all.
  void set_varying_eta(const std::function<double(double)>& index);
  /// Gives a rough conductor (`eta` 0) or dielectric the table for multiple scattering, unless it asks for
  /// none.
  void set_multiple_scattering(const v1::Roughness& roughness, float eta);
  /// The normals of the layer above the base.
  absl::Status set_upper_normal(const v1::ImageTexture& map);
  /// Multiplies the values of both spectra.
  void scale_spectra(float factor);
  ExtendedRecord& extend();

  EnergyTables& energies() { return inputs_.energies; }
  SpectralBuilder* spectral() { return inputs_.spectral; }
  /// "material 'gold': " and `what`.
  void warn(const std::string& what);

 private:
  /// Puts a texture's node into a slot; of one that is constant, returns the value instead.
  absl::StatusOr<std::optional<spectra::Rgb>> look_up(const std::string& texture, std::int32_t& slot);

  const MaterialInputs& inputs_;
  const std::string& name_;
  bool exact_ = false;  // textures are looked up at full resolution
};

void put(const spectra::Rgb& rgb, SpectrumSlot& slot);

/// Whether it is 0 everywhere.
inline bool is_zero(const ScalarSlot& slot) { return slot.texture < 0 && slot.value == 0; }

}  // namespace tessera::render
