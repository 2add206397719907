#include "render/scene/spectral/spectral_builder.h"

#include <algorithm>
#include <vector>

#include "render/scene/values/spectra.h"
#include "spectra/curve.h"
#include "spectra/light/daylight.h"
#include "spectra/light/planck.h"
#include "spectra/rgb/scene_rgb.h"
#include "spectra/upsampling/table.h"
#include "spectra/upsampling/upsample.h"

namespace tessera::render {
namespace {

using spectra::Rgb;

static_assert(kSigmoidMiddleNm == spectra::kSigmoidMiddleNm &&
              kSigmoidHalfWidthNm == spectra::kSigmoidHalfWidthNm);

double nm_of(int sample) { return kFirstNm + sample; }

std::vector<float> sampled(const std::function<double(double)>& value) {
  std::vector<float> samples(kCurveSamples);
  for (int i = 0; i < kCurveSamples; ++i) samples[i] = static_cast<float>(value(nm_of(i)));
  return samples;
}

bool is_factor(const Rgb& c) { return std::min({c.r, c.g, c.b}) >= 0 && std::max({c.r, c.g, c.b}) <= 1; }

Rgb color_of(const float (&value)[kBands]) { return {value[0], value[1], value[2]}; }

void put(const spectra::SigmoidCoefficients& k, float (&value)[kBands]) {
  value[0] = k.c0, value[1] = k.c1, value[2] = k.c2;
}

/// How bright light is that no observer sees: its mean over wavelengths, over that of daylight.
float unseen_brightness(const v1::Spectrum& spectrum) {
  if (!spectrum.has_sampled()) return 0;
  const spectra::Curve light = curve_of(spectrum.sampled()), daylight = spectra::unit_d65();
  double sum = 0, sum_of_daylight = 0;
  for (int i = 0; i < kCurveSamples; ++i) sum += light.at(nm_of(i)), sum_of_daylight += daylight.at(nm_of(i));
  return static_cast<float>(sum / sum_of_daylight);
}

double luminance(const Rgb& c) { return 0.212671 * c.r + 0.715160 * c.g + 0.072169 * c.b; }

}  // namespace

SpectralBuilder::SpectralBuilder(SpectralTables& tables) : tables_(tables) {
  const spectra::SigmoidTable& sigmoids = spectra::sigmoid_table();
  for (const spectra::SigmoidCoefficients& k : sigmoids.entries())
    tables.coefficients.insert(tables.coefficients.end(), {k.c0, k.c1, k.c2, 0});
  tables.levels.assign(sigmoids.along_levels().begin(), sigmoids.along_levels().end());
  tables.ratios.assign(sigmoids.ratios().begin(), sigmoids.ratios().end());
  const spectra::Curve daylight = spectra::unit_d65();
  add_curve([&](double nm) { return daylight.at(nm); });
}

std::int32_t SpectralBuilder::add_curve(const std::function<double(double)>& value) {
  const auto number = static_cast<std::int32_t>(tables_.curves.size() / kCurveSamples);
  const std::vector<float> samples = sampled(value);
  tables_.curves.insert(tables_.curves.end(), samples.begin(), samples.end());
  return number;
}

std::optional<std::int32_t> SpectralBuilder::add_measured(const v1::Spectrum& spectrum, double scale) {
  if (spectrum.has_sampled()) {
    const spectra::Curve curve = curve_of(spectrum.sampled());
    return add_curve([&](double nm) { return scale * curve.at(nm); });
  }
  if (spectrum.has_blackbody() && spectrum.blackbody().kelvin() > 0) {
    return add_curve(
        [&](double nm) { return scale * spectra::relative_planck(nm, spectrum.blackbody().kelvin()); });
  }
  return std::nullopt;
}

std::int32_t SpectralBuilder::add_function_of(std::int32_t curve,
                                              const std::function<float(float)>& function) {
  const std::size_t first = static_cast<std::size_t>(curve) * kCurveSamples;
  return add_curve(
      [&](double nm) { return function(tables_.curves[first + static_cast<std::size_t>(nm - kFirstNm)]); });
}

SpectralEmission SpectralBuilder::emission_of(const v1::Spectrum& spectrum) {
  // Lights are chosen by the mean of their colour, whether they have a curve or not.
  const Rgb color = emission(spectrum);
  float mean = (color.r + color.g + color.b) / 3;
  // A sensor may see what no observer does.
  if (mean == 0) mean = unseen_brightness(spectrum);
  // Without light there is no grey to be a multiple of; what is less than no light stays a colour.
  if (!(mean > 0) || std::min({color.r, color.g, color.b}) < 0) return {color};
  const SpectralEmission grey{.color = {mean, mean, mean}};
  if (color.r == color.g && color.g == color.b && !spectrum.has_sampled() && !spectrum.has_blackbody())
    return grey;
  std::string key;
  if (!spectrum.SerializeToString(&key)) return {color};
  const auto [known, is_new] = curves_by_light_.try_emplace(key, 0);
  if (is_new) {
    const std::optional<std::int32_t> measured = add_measured(spectrum, 1 / mean);
    known->second = measured ? *measured : add_light(color, mean);
  }
  return {grey.color, known->second};
}

std::int32_t SpectralBuilder::add_light(const Rgb& color, float mean) {
  const spectra::UpsampledEmission light = spectra::upsample_emission(color);
  const spectra::Curve daylight = spectra::unit_d65();
  return add_curve([&](double nm) {
    return light.scale / mean * spectra::value(light.coefficients, static_cast<float>(nm)) * daylight.at(nm);
  });
}

std::int32_t SpectralBuilder::add_factor(const Rgb& color) {
  const float scale = 2 * std::max({color.r, color.g, color.b, 0.0f});
  if (!(scale > 0)) return add_curve([](double) { return 0.0; });
  const spectra::SigmoidCoefficients k =
      spectra::upsample_reflectance({color.r / scale, color.g / scale, color.b / scale}).coefficients;
  return add_curve([&](double nm) { return scale * spectra::value(k, static_cast<float>(nm)); });
}

void SpectralBuilder::convert(SpectrumSlot& slot) {
  if (slot.texture != -1) return;
  const Rgb color = color_of(slot.value);
  if (is_factor(color)) {
    put(spectra::upsample_reflectance(color).coefficients, slot.value);
  } else {
    slot.texture = kFirstCurve - add_factor(color);
  }
}

void SpectralBuilder::convert(MaterialTable& materials) {
  for (MaterialRecord& material : materials.materials) {
    material.luminance = static_cast<float>(luminance(color_of(material.spectra[0].value)));
    for (SpectrumSlot& slot : material.spectra) convert(slot);
  }
  for (ExtendedRecord& extended : materials.extended) {
    for (SpectrumSlot& slot : extended.spectra) convert(slot);
  }
}

void SpectralBuilder::convert(MediumTable& media) {
  for (MediumRecord& medium : media.media) {
    const Rgb extinction = color_of(medium.sigma_t.value);
    medium.sigma_t.curve = add_factor(extinction);
    medium.albedo.curve = add_factor(color_of(medium.albedo.value));
    // Majorants hold for all wavelengths.
    const auto first = tables_.curves.begin() + medium.sigma_t.curve * kCurveSamples;
    const float most = *std::max_element(first, first + kCurveSamples),
                most_of_color = std::max({extinction.r, extinction.g, extinction.b});
    for (float& majorant : medium.majorants) majorant *= most_of_color > 0 ? most / most_of_color : 1;
  }
}

}  // namespace tessera::render
