// Spectra where others have colours, for jobs whose paths carry light of wavelengths.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "render/bsdf/material_table.h"
#include "render/color/spectral_tables.h"
#include "render/medium/medium_table.h"
#include "spectra/color/rgb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A spectrum as light: a grey times a curve, or times daylight where there is none; or a colour in daylight.
struct SpectralEmission {
  spectra::Rgb color;
  std::int32_t curve = -1;
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
  /// Another curve, of a function of one that was added.
  std::int32_t add_function_of(std::int32_t curve, const std::function<float(float)>& function);

  SpectralEmission emission_of(const v1::Spectrum& spectrum);

  /// From colours, which the tables have so far, to sigmoids and curves, once nothing asks for colours any
  /// more.
  void convert(MaterialTable& materials);
  void convert(MediumTable& media);

 private:
  void convert(SpectrumSlot& slot);
  std::int32_t add_factor(const spectra::Rgb& color);
  std::int32_t add_light(const spectra::Rgb& color, float mean);

  SpectralTables& tables_;
  std::map<std::string, std::int32_t> curves_by_light_;
};

}  // namespace tessera::render
