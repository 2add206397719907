#include "import/pbrt/matter/spectrum_values.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/nearest_name.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/pbrt/file/tokenizer.h"
#include "spectra/curve.h"
#include "spectra/light/daylight.h"
#include "spectra/light/planck.h"
#include "spectra/named_spectra.h"
#include "spectra/rgb/mitsuba_rgb.h"
#include "spectra/rgb/pbrt_luminance.h"
#include "spectra/upsampling/upsample.h"

namespace tessera::client::pbrt {
namespace {

// The range of wavelengths that pbrt-v4 renders.
constexpr float kFirstNm = 360;
constexpr float kLastNm = 830;

v1::Spectrum sampled_spectrum(const spectra::Curve& table) {
  v1::Spectrum spectrum;
  v1::SampledSpectrum* sampled = spectrum.mutable_sampled();
  sampled->mutable_wavelengths_nm()->Add(table.nm.begin(), table.nm.end());
  sampled->mutable_values()->Add(table.values.begin(), table.values.end());
  return spectrum;
}

spectra::Curve table_of(const v1::SampledSpectrum& sampled) {
  return {{sampled.wavelengths_nm().begin(), sampled.wavelengths_nm().end()},
          {sampled.values().begin(), sampled.values().end()}};
}

/// The spectrum at so many wavelengths that lines between them miss nothing that is seen.
spectra::Curve tabulated(const v1::Spectrum& spectrum) {
  if (spectrum.has_sampled()) return table_of(spectrum.sampled());
  constexpr float kStep = 5;
  spectra::Curve table;
  for (float nm = kFirstNm; nm <= kLastNm; nm += kStep) {
    table.nm.push_back(nm);
    table.values.push_back(spectrum.has_blackbody() ? static_cast<float>(spectra::relative_planck(
                                                          nm, spectrum.blackbody().kelvin()))
                                                    : spectrum.constant());
  }
  return table;
}

std::array<double, 3> in_rgb(const v1::Spectrum& spectrum) {
  return {spectrum.in_rgb().r(), spectrum.in_rgb().g(), spectrum.in_rgb().b()};
}

std::array<double, 3> rgb_or_grey(const v1::Spectrum& spectrum) {
  if (spectrum.has_rgb()) return {spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()};
  return {spectrum.constant(), spectrum.constant(), spectrum.constant()};
}

/// Pairs of wavelength and value; the message of what is wrong, or nothing.
std::string fill_table(const std::vector<double>& numbers, spectra::Curve& table) {
  if (numbers.empty() || numbers.size() % 2 != 0) {
    return concat("expected pairs of wavelength and value, found ", numbers.size(), " numbers");
  }
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    table.nm.push_back(static_cast<float>(numbers[i]));
    table.values.push_back(static_cast<float>(numbers[i + 1]));
  }
  return std::string(spectra::check_curve(table).message());
}

/// A file of pairs of wavelength and value, with comments.
absl::StatusOr<spectra::Curve> read_spectrum_file(const std::filesystem::path& path) {
  absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) return file.status();
  Tokenizer tokenizer(file->bytes(), 0);
  std::vector<double> numbers;
  tokenizer.read_numbers([&](double value) { numbers.push_back(value); });
  const Token rest = tokenizer.next();
  spectra::Curve table;
  const std::string problem =
      rest.kind == TokenKind::kEnd
          ? fill_table(numbers, table)
          : concat("line ", rest.where.line, ": expected a number, found \"", rest.text, "\"");
  if (!problem.empty()) return absl::InvalidArgumentError(concat(path.string(), ": ", problem));
  return table;
}

std::optional<v1::Spectrum> fail(Context& context, const Parameter& parameter, std::string_view owner,
                                 std::string_view what) {
  context.diagnostics.error(parameter.where,
                            concat("parameter \"", parameter.name, "\" of ", owner, ": ", what));
  return std::nullopt;
}

/// Gives a colour beyond Rec.709 the spectrum that it has in jobs of wavelengths, where there is one;
/// `spectrum` has the colour that is left of it in jobs of RGB.
bool keep_out_of_gamut(const std::array<double, 3>& rgb, SpectrumUse use, v1::Spectrum& spectrum) {
  const bool is_light = use == SpectrumUse::kIlluminant;
  if (use == SpectrumUse::kUnbounded) return false;
  const auto f = [](double v) { return static_cast<float>(v); };
  const spectra::Rgb color = {f(rgb[0]), f(rgb[1]), f(rgb[2])};
  const spectra::UpsampledReflectance matter = spectra::upsample_reflectance(color);
  const spectra::UpsampledEmission light = spectra::upsample_emission(color);
  if ((is_light ? light.error : matter.error) > spectra::kMostUpsamplingError) return false;
  const spectra::Curve daylight = spectra::unit_d65();
  spectra::Curve curve;
  constexpr float kStep = 5;
  for (float nm = kFirstNm; nm <= kLastNm; nm += kStep) {
    curve.nm.push_back(nm);
    curve.values.push_back(is_light
                               ? f(light.scale * spectra::value(light.coefficients, nm) * daylight.at(nm))
                               : spectra::value(matter.coefficients, nm));
  }
  const v1::Rgb in_rgb = spectrum.rgb();
  spectrum = sampled_spectrum(curve);
  *spectrum.mutable_in_rgb() = in_rgb;
  return true;
}

std::optional<v1::Spectrum> read_rgb(Context& context, const Parameter& parameter, std::string_view owner,
                                     SpectrumUse use) {
  if (parameter.numbers.size() != 3) {
    return fail(context, parameter, owner,
                concat("expected one RGB, found ", parameter.numbers.size() / 3.0));
  }
  std::array<double, 3> rgb = {parameter.numbers[0], parameter.numbers[1], parameter.numbers[2]};
  if (*std::min_element(rgb.begin(), rgb.end()) < 0)
    return fail(context, parameter, owner, "an RGB value is negative");
  const std::array<double, 3> unclamped = rgb = rec709_from(parameter.color_space, rgb);
  const double highest = use == SpectrumUse::kReflectance ? 1 : HUGE_VAL;
  bool clamped = false;
  for (double& component : rgb) {
    const double inside = std::clamp(component, 0.0, highest);
    clamped = clamped || inside != component;
    component = inside;
  }
  if (!clamped) return rgb_spectrum(rgb);
  v1::Spectrum spectrum = rgb_spectrum(rgb);
  const bool is_kept = keep_out_of_gamut(unclamped, use, spectrum);
  context.diagnostics.warning(
      parameter.where, concat("parameter \"", parameter.name, "\" of ", owner,
                              ": a component is outside of what linear Rec.709 can hold there: clamped",
                              is_kept ? " in jobs of RGB" : ""));
  return spectrum;
}

std::optional<v1::Spectrum> read_sampled(Context& context, const Parameter& parameter, std::string_view owner,
                                         SpectrumUse use) {
  spectra::Curve table;
  bool measured_over_all = false;
  if (parameter.strings.empty()) {
    if (std::string problem = fill_table(parameter.numbers, table); !problem.empty()) {
      return fail(context, parameter, owner, problem);
    }
  } else if (parameter.strings.size() != 1) {
    return fail(context, parameter, owner, "expected one name of a spectrum");
  } else if (std::optional<spectra::Curve> named = spectra::find_named_spectrum(parameter.strings.front())) {
    table = *std::move(named);
    measured_over_all = true;
  } else {
    const std::string& name = parameter.strings.front();
    absl::StatusOr<spectra::Curve> from_file = read_spectrum_file(context.resolve(name));
    if (!from_file.ok()) {
      const bool missing = absl::IsNotFound(from_file.status());
      return fail(context, parameter, owner,
                  missing ? concat("\"", name, "\" is neither a named spectrum nor a file",
                                   base::did_you_mean(name, spectra::names_of_spectra()))
                          : std::string(from_file.status().message()));
    }
    table = *std::move(from_file);
  }
  if (use != SpectrumUse::kUnbounded && !measured_over_all) spectra::add_zero_ends(table, kFirstNm, kLastNm);
  return sampled_spectrum(table);
}

}  // namespace

bool is_table(const v1::Spectrum& spectrum) { return spectrum.has_sampled() || spectrum.has_blackbody(); }

v1::Spectrum constant_spectrum(double value) {
  v1::Spectrum spectrum;
  spectrum.set_constant(static_cast<float>(value));
  return spectrum;
}

v1::Spectrum rgb_spectrum(const std::array<double, 3>& rgb) {
  v1::Spectrum spectrum;
  spectrum.mutable_rgb()->set_r(static_cast<float>(rgb[0]));
  spectrum.mutable_rgb()->set_g(static_cast<float>(rgb[1]));
  spectrum.mutable_rgb()->set_b(static_cast<float>(rgb[2]));
  return spectrum;
}

v1::Spectrum scaled(const v1::Spectrum& spectrum, double factor) {
  if (is_table(spectrum)) {
    spectra::Curve table = tabulated(spectrum);
    for (float& value : table.values) value = static_cast<float>(value * factor);
    v1::Spectrum result = sampled_spectrum(table);
    if (spectrum.has_in_rgb())
      *result.mutable_in_rgb() = scaled(rgb_spectrum(in_rgb(spectrum)), factor).rgb();
    return result;
  }
  if (!spectrum.has_rgb()) return constant_spectrum(spectrum.constant() * factor);
  const std::array<double, 3> rgb = rgb_or_grey(spectrum);
  return rgb_spectrum({rgb[0] * factor, rgb[1] * factor, rgb[2] * factor});
}

v1::Spectrum sum(const v1::Spectrum& a, const v1::Spectrum& b) {
  if (a.has_rgb() || b.has_rgb()) {
    const std::array<double, 3> first = linear_rgb_of(a), second = linear_rgb_of(b);
    return rgb_spectrum({first[0] + second[0], first[1] + second[1], first[2] + second[2]});
  }
  if (!is_table(a) && !is_table(b)) return constant_spectrum(double{a.constant()} + b.constant());
  // Linear between the samples of both.
  const spectra::Curve first = tabulated(a), second = tabulated(b);
  spectra::Curve result;
  std::set_union(first.nm.begin(), first.nm.end(), second.nm.begin(), second.nm.end(),
                 std::back_inserter(result.nm));
  for (const float nm : result.nm) {
    result.values.push_back(static_cast<float>(first.at(nm) + second.at(nm)));
  }
  return sampled_spectrum(result);
}

v1::Spectrum sampled_ratio(const v1::Spectrum& a, const v1::Spectrum& b) {
  const spectra::Curve above = tabulated(a), below = tabulated(b);
  spectra::Curve result;
  const float first = std::floor(std::min({kFirstNm, above.nm.front(), below.nm.front()})),
              last = std::ceil(std::max({kLastNm, above.nm.back(), below.nm.back()}));
  for (float nm = first; nm <= last; ++nm) {
    const double divisor = below.at(nm);
    result.nm.push_back(nm);
    result.values.push_back(static_cast<float>(divisor > 0 ? above.at(nm) / divisor : 0));
  }
  return sampled_spectrum(result);
}

std::array<double, 3> linear_rgb_of(const v1::Spectrum& spectrum) {
  if (spectrum.has_in_rgb()) return in_rgb(spectrum);
  if (!is_table(spectrum)) return rgb_or_grey(spectrum);
  // Constant beyond its ends, which mitsuba_rgb() is not.
  spectra::Curve table = tabulated(spectrum);
  if (table.nm.front() > kFirstNm) {
    table.nm.insert(table.nm.begin(), kFirstNm);
    table.values.insert(table.values.begin(), table.values.front());
  }
  if (table.nm.back() < kLastNm) {
    table.nm.push_back(kLastNm);
    table.values.push_back(table.values.back());
  }
  std::array<double, 3> rgb = spectra::mitsuba_rgb(table, spectra::SeenUnder::kD65);
  for (double& component : rgb) component = std::max(component, 0.0);
  return rgb;
}

std::optional<v1::Spectrum> read_spectrum(Context& context, const Parameter& parameter,
                                          std::string_view owner, SpectrumUse use) {
  switch (parameter.type) {
    case ParameterType::kRgb:
      return read_rgb(context, parameter, owner, use);
    case ParameterType::kSpectrum:
      return read_sampled(context, parameter, owner, use);
    default:
      break;
  }
  if (parameter.numbers.size() != 1) {
    return fail(context, parameter, owner, concat("expected one value, found ", parameter.numbers.size()));
  }
  const double value = parameter.numbers.front();
  if (parameter.type != ParameterType::kBlackbody) return constant_spectrum(value);
  if (value <= 0) return fail(context, parameter, owner, "a temperature must be above 0 kelvin");
  v1::Spectrum spectrum;
  spectrum.mutable_blackbody()->set_kelvin(static_cast<float>(value));
  return spectrum;
}

LightSpectrum read_light_spectrum(Context& context, ParameterList& parameters, std::string_view name) {
  LightSpectrum result;
  result.spectrum = rgb_spectrum({1, 1, 1});
  const Parameter* parameter = parameters.find(
      name, {ParameterType::kRgb, ParameterType::kSpectrum, ParameterType::kBlackbody}, context.diagnostics);
  if (parameter == nullptr) return result;
  std::optional<v1::Spectrum> spectrum =
      read_spectrum(context, *parameter, parameters.owner(), SpectrumUse::kIlluminant);
  if (!spectrum) return result;
  result.spectrum = *std::move(spectrum);
  double luminance_of_spectrum = 1;
  if (result.spectrum.has_sampled() && !result.spectrum.has_in_rgb()) {
    luminance_of_spectrum = spectra::pbrt_luminance(table_of(result.spectrum.sampled()));
  } else if (result.spectrum.has_blackbody()) {
    const double kelvin = result.spectrum.blackbody().kelvin();
    luminance_of_spectrum =
        spectra::pbrt_luminance([&](double nm) { return spectra::relative_planck(nm, kelvin); });
  }
  result.scale = luminance_of_spectrum > 0 ? 1 / luminance_of_spectrum : 0;
  return result;
}

}  // namespace tessera::client::pbrt
