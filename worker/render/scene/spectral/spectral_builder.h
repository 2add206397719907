// Spectra where others have colours, for jobs whose paths carry light of wavelengths.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/bsdf/material_table.h"
#include "render/color/spectral_tables.h"
#include "render/color/texture_table.h"
#include "render/medium/medium_table.h"
#include "render/scene/spectral/unreached_color.h"
#include "spectra/color/rgb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A spectrum as light: a grey times a curve, or times daylight where there is none.
struct SpectralEmission {
  spectra::Rgb color;
  std::int32_t curve = -1;
  UnreachedColor unreached = {};
};

class SpectralBuilder {
 public:
  /// Fills all but curves and lights. The tables must outlive it.
  explicit SpectralBuilder(SpectralTables& tables);

  /// The number of a new curve, of a function of nanometres.
  std::int32_t add_curve(const std::function<double(double nm)>& value);
  /// The same; nothing of a function that is the same at all wavelengths, but for rounding.
  std::optional<std::int32_t> add_varying(const std::function<double(double nm)>& value);
  /// The same of a spectrum that is no colour, times `scale`; nothing of one that is.
  std::optional<std::int32_t> add_measured(const v1::Spectrum& spectrum, double scale = 1);
  /// The same of a colour: a reflectance that has it in daylight; or a factor of any size, up to twice its
  /// largest component.
  std::int32_t add_reflectance(const spectra::Rgb& color);
  std::int32_t add_factor(const spectra::Rgb& color);
  /// Another curve, of a function of one that was added, or the ratio of two, at most 1.
  std::int32_t add_function_of(std::int32_t number, const std::function<float(float)>& function);
  std::int32_t add_albedo(std::int32_t scattering, std::int32_t extinction);

  SpectralEmission emission_of(const v1::Spectrum& spectrum);

  /// The luminance of light, 1 for one that is 1 at all wavelengths: by V(lambda), of what jobs carry.
  double luminance_of(const SpectralEmission& light) const;
  /// Its mean over 360 to 830 nm.
  double mean_of(const SpectralEmission& light) const;

  /// From colours, which the tables have so far, to sigmoids and curves, once nothing asks for colours any
  /// more. Warns of materials, by their names, that have a colour or a texel that no spectrum has.
  void convert(MaterialTable& materials, const TextureTable& textures, const std::vector<std::string>& names,
               std::vector<std::string>& warnings);
  void convert(MediumTable& media);

 private:
  struct Light {
    std::int32_t curve = -1;
    UnreachedColor unreached = {};
  };

  Light add_light(const v1::Spectrum& spectrum, const spectra::Rgb& color, float mean);
  UnreachedColor convert(SpectrumSlot& slot);
  void convert(const MediumTable& media, MediumRecord& medium);
  std::span<const float> curve(std::int32_t number) const;
  /// Sum over the samples of the light's curve times `weight`, a nanometre apart, over that of `weight`.
  double weighted_mean(const SpectralEmission& light, const std::function<double(double nm)>& weight) const;

  SpectralTables& tables_;
  std::map<std::string, Light> lights_;
};

}  // namespace tessera::render
