#include "render/scene/spectral/spectral_builder.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/values/spectra.h"
#include "spectra/curve.h"
#include "spectra/light/daylight.h"
#include "spectra/light/planck.h"
#include "spectra/observer/action_spectrum.h"
#include "spectra/rgb/scene_rgb.h"
#include "spectra/upsampling/table.h"
#include "spectra/upsampling/upsample.h"

namespace tessera::render {
namespace {

using spectra::Rgb;

static_assert(kSigmoidMiddleNm == spectra::kSigmoidMiddleNm &&
              kSigmoidHalfWidthNm == spectra::kSigmoidHalfWidthNm);

double nm_of(int sample) { return kFirstNm + sample; }

std::size_t sample_at(double nm) { return static_cast<std::size_t>(nm - kFirstNm); }

std::vector<float> sampled(const std::function<double(double)>& value) {
  std::vector<float> samples(kCurveSamples);
  for (int i = 0; i < kCurveSamples; ++i) samples[i] = static_cast<float>(value(nm_of(i)));
  return samples;
}

Rgb color_of(const float (&value)[kBands]) { return {value[0], value[1], value[2]}; }

void put(const spectra::SigmoidCoefficients& k, float (&value)[kBands]) {
  value[0] = k.c0, value[1] = k.c1, value[2] = k.c2;
}

/// How bright light is that no observer sees: its mean over wavelengths, over that of daylight.
float unseen_brightness(const v1::Spectrum& spectrum) {
  const std::optional<spectra::Curve> light = measured_curve(spectrum);
  if (!light) return 0;
  const spectra::Curve daylight = spectra::unit_d65();
  double sum = 0, sum_of_daylight = 0;
  for (int i = 0; i < kCurveSamples; ++i)
    sum += light->at(nm_of(i)), sum_of_daylight += daylight.at(nm_of(i));
  return static_cast<float>(sum / sum_of_daylight);
}

double luminance(const Rgb& c) { return 0.212671 * c.r + 0.715160 * c.g + 0.072169 * c.b; }

}  // namespace

SpectralBuilder::SpectralBuilder(SpectralTables& tables) : tables_(tables) {
  const spectra::SigmoidTable& sigmoids = spectra::sigmoid_table();
  const spectra::SigmoidNodes& nodes = sigmoids.nodes();
  tables.coefficients = sigmoids.rows().data();
  tables.levels.assign(nodes.along_levels.begin(), nodes.along_levels.end());
  tables.ratios.assign(nodes.ratios.begin(), nodes.ratios.end());
  const spectra::Curve daylight = spectra::unit_d65();
  add_curve([&](double nm) { return daylight.at(nm); });
}

std::int32_t SpectralBuilder::add_curve(const std::function<double(double)>& value) {
  const auto number = static_cast<std::int32_t>(tables_.curves.size() / kCurveSamples);
  const std::vector<float> samples = sampled(value);
  tables_.curves.insert(tables_.curves.end(), samples.begin(), samples.end());
  return number;
}

std::optional<std::int32_t> SpectralBuilder::add_varying(const std::function<double(double)>& value) {
  const std::vector<float> samples = sampled(value);
  const auto [least, most] = std::ranges::minmax(samples);
  if (most - least <= 1e-6f * most) return std::nullopt;
  return add_curve(value);
}

std::optional<std::int32_t> SpectralBuilder::add_measured(const v1::Spectrum& spectrum, double scale) {
  if (const auto measured = measured_curve(spectrum))
    return add_curve([&](double nm) { return scale * measured->at(nm); });
  if (spectrum.has_blackbody() && spectrum.blackbody().kelvin() > 0) {
    return add_curve(
        [&](double nm) { return scale * spectra::relative_planck(nm, spectrum.blackbody().kelvin()); });
  }
  return std::nullopt;
}

std::span<const float> SpectralBuilder::curve(std::int32_t number) const {
  return std::span(tables_.curves).subspan(static_cast<std::size_t>(number) * kCurveSamples, kCurveSamples);
}

std::int32_t SpectralBuilder::add_reflectance(const Rgb& color) {
  const spectra::SigmoidCoefficients k = spectra::upsample_reflectance(color).coefficients;
  return add_curve([&](double nm) { return spectra::value(k, static_cast<float>(nm)); });
}

std::int32_t SpectralBuilder::add_factor(const Rgb& color) {
  const float scale = 2 * std::max({color.r, color.g, color.b, 0.0f});
  if (!(scale > 0)) return add_curve([](double) { return 0.0; });
  const spectra::SigmoidCoefficients k =
      spectra::upsample_reflectance({color.r / scale, color.g / scale, color.b / scale}).coefficients;
  return add_curve([&](double nm) { return scale * spectra::value(k, static_cast<float>(nm)); });
}

std::int32_t SpectralBuilder::add_function_of(std::int32_t number,
                                              const std::function<float(float)>& function) {
  return add_curve([&](double nm) { return function(curve(number)[sample_at(nm)]); });
}

std::int32_t SpectralBuilder::add_albedo(std::int32_t scattering, std::int32_t extinction) {
  return add_curve([&](double nm) {
    const float all = curve(extinction)[sample_at(nm)];
    return all > 0 ? std::min(curve(scattering)[sample_at(nm)] / all, 1.0f) : 0.0f;
  });
}

SpectralEmission SpectralBuilder::emission_of(const v1::Spectrum& spectrum) {
  // Lights are chosen by the mean of their colour, whether they have a curve or not.
  const Rgb color = emission(spectrum);
  float mean = (color.r + color.g + color.b) / 3;
  // A sensor may see what no observer does.
  if (mean == 0) mean = unseen_brightness(spectrum);
  // Light that nobody sees has no grey to be a multiple of.
  if (!(mean > 0)) return {color, -1, {color, spectra::upsample_emission(color).error}};
  const SpectralEmission grey{.color = {mean, mean, mean}};
  const bool is_measured = measured_curve(spectrum) || spectrum.has_blackbody();
  if (color.r == color.g && color.g == color.b && !is_measured) return grey;
  std::string key;
  if (!spectrum.SerializeToString(&key)) return {color};
  const auto [known, is_new] = lights_.try_emplace(key);
  if (is_new) known->second = add_light(spectrum, color, mean);
  return {grey.color, known->second.curve, known->second.unreached};
}

double SpectralBuilder::weighted_mean(const SpectralEmission& light,
                                      const std::function<double(double)>& weight) const {
  const std::span<const float> samples = curve(std::max(light.curve, 0));
  double sum = 0, whole = 0;
  for (int i = 0; i < kCurveSamples; ++i) {
    const double w = weight(nm_of(i));
    sum += w * samples[static_cast<std::size_t>(i)], whole += w;
  }
  // Light that nobody sees has a colour alone.
  return luminance(light.color) * sum / whole;
}

double SpectralBuilder::luminance_of(const SpectralEmission& light) const {
  return weighted_mean(light, [](double nm) { return spectra::photopic().at(nm); });
}

double SpectralBuilder::mean_of(const SpectralEmission& light) const {
  return weighted_mean(light, [](double nm) { return nm >= 360 && nm <= 830 ? 1.0 : 0.0; });
}

SpectralBuilder::Light SpectralBuilder::add_light(const v1::Spectrum& spectrum, const Rgb& color,
                                                  float mean) {
  if (const auto measured = add_measured(spectrum, 1 / mean)) return {*measured};
  const spectra::UpsampledEmission light = spectra::upsample_emission(color);
  const spectra::Curve daylight = spectra::unit_d65();
  const std::int32_t added = add_curve([&](double nm) {
    return light.scale / mean * spectra::value(light.coefficients, static_cast<float>(nm)) * daylight.at(nm);
  });
  return {added, {color, light.error}};
}

UnreachedColor SpectralBuilder::convert(SpectrumSlot& slot) {
  if (slot.texture >= 0 || slot.curve >= 0) return {};
  const Rgb color = color_of(slot.value);
  if (std::max({color.r, color.g, color.b}) > 1) {
    slot.curve = add_factor(color);
    return {color, spectra::upsample_emission(color).error};
  }
  const spectra::UpsampledReflectance up = spectra::upsample_reflectance(color);
  put(up.coefficients, slot.value);
  return {color, up.error};
}

void SpectralBuilder::convert(MaterialTable& materials, const TextureTable& textures,
                              const std::vector<std::string>& names, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < materials.materials.size(); ++i) {
    MaterialRecord& material = materials.materials[i];
    material.luminance = static_cast<float>(luminance(color_of(material.spectra[0].value)));
    UnreachedColor unreached;
    const auto convert_slot = [&](SpectrumSlot& slot) {
      unreached.add(slot.texture >= 0 ? worst_texel(textures, slot.texture) : convert(slot));
    };
    for (SpectrumSlot& slot : material.spectra) convert_slot(slot);
    if (material.flags & kUsesExtended) {
      for (SpectrumSlot& slot : materials.extended[static_cast<std::size_t>(material.extended)].spectra)
        convert_slot(slot);
    }
    if (unreached.is_told())
      warnings.push_back(absl::StrCat("material '", names[i], "': ", unreached.to_string()));
  }
}

void SpectralBuilder::convert(const MediumTable& media, MediumRecord& medium) {
  MediumValue &sigma_t = medium.sigma_t, &albedo = medium.albedo;
  const Rgb extinction = color_of(sigma_t.value), scattering = color_of(albedo.value);
  if (sigma_t.curve < 0) sigma_t.curve = add_factor(extinction);
  if (albedo.curve < 0)
    albedo.curve = medium.scattering_is_sigma_s ? add_factor(scattering) : add_reflectance(scattering);
  // Majorants hold for all wavelengths.
  const float most = std::ranges::max(curve(sigma_t.curve));
  if (sigma_t.grid < 0) {
    for (float& majorant : medium.majorants) majorant = most;
    return;
  }
  const float most_of_color = std::max({extinction.r, extinction.g, extinction.b});
  if (most > 0 && !(most_of_color > 0)) {
    // Extinction beyond what observers see has no colour that majorants could be in proportion to.
    std::ranges::fill(sigma_t.value, most);
    build_majorants(media, medium);
    return;
  }
  // Densities of colours are up to twice as large as these (Spectra::density).
  const bool has_colors = media.grids[static_cast<std::size_t>(sigma_t.grid)].channels == kBands;
  for (float& majorant : medium.majorants)
    majorant *= (has_colors ? 2 : 1) * (most_of_color > 0 ? most / most_of_color : 1);
}

void SpectralBuilder::convert(MediumTable& media) {
  for (MediumRecord& medium : media.media) convert(media, medium);
}

}  // namespace tessera::render
