#include "import/mitsuba/matter/colors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "import/input/concat.h"
#include "import/mitsuba/document/value_text.h"
#include "spectra/light/planck.h"
#include "spectra/rgb/mitsuba_rgb.h"

namespace tessera::client::mitsuba {
namespace {

using Color = std::array<double, 3>;

/// Into what the use can hold, with a warning where that changes the colour.
Color clamped(PropertyReader& reader, const Property& property, Color color, ColorUse use) {
  const double highest = use == ColorUse::kReflectance ? 1 : std::numeric_limits<float>::max();
  bool changed = false;
  for (double& component : color) {
    const double inside = std::clamp(component, 0.0, highest);
    changed = changed || inside != component;
    component = inside;
  }
  if (changed) {
    reader.diagnostics().warning(property.where,
                                 concat("parameter \"", property.name, "\" of ", reader.object().title(),
                                        ": a component is outside of what linear Rec.709 can "
                                        "hold there: clamped"));
  }
  return color;
}

ConstantColor grey(double value) { return {{value, value, value}}; }

/// A spectrum of samples, at least two.
ConstantColor sampled(spectra::Curve samples, ColorUse use) {
  const spectra::Triple rgb = spectra::mitsuba_rgb(
      samples, use == ColorUse::kEmission ? spectra::SeenUnder::kEqualEnergy : spectra::SeenUnder::kD65);
  // Indices go on beyond what was measured of them; sensors end there by themselves.
  if (use != ColorUse::kUnbounded && use != ColorUse::kSensitivity)
    spectra::add_zero_ends(samples, kFirstNm, kLastNm);
  return {rgb, std::move(samples)};
}

/// The same value at all wavelengths: light of it is not white.
ConstantColor uniform_light(double value, const Color& rgb) {
  const auto v = static_cast<float>(value);
  return {rgb, {{kFirstNm, kLastNm}, {v, v}}};
}

ConstantColor color_of(const SpectrumData& spectrum, ColorUse use) {
  if (!spectrum.is_uniform()) return sampled(spectrum.samples, use);
  const double value = spectrum.uniform;
  if (use != ColorUse::kEmission) return grey(value);
  return uniform_light(value, spectra::mitsuba_rgb_from_xyz({value, value, value}));
}

/// The numbers of a parameter that is a list of them in a string; none, with an error, where it is not.
std::vector<double> read_list(PropertyReader& reader, std::string_view name) {
  const std::optional<std::vector<double>> numbers = parse_floats(reader.text(name, ""));
  if (numbers && !numbers->empty()) return *numbers;
  const std::string expected = concat("expected a list of numbers as parameter \"", name, "\"");
  if (const Property* property = reader.find(name)) {
    reader.error(*property, expected);
  } else {
    reader.error(concat(reader.object().title(), ": ", expected));
  }
  return {};
}

/// Samples of "regular", whose wavelengths are evenly apart, or of "irregular".
std::optional<ConstantColor> read_samples(PropertyReader& reader, ColorUse use) {
  const bool even = reader.object().type == "regular";
  const double first = even ? reader.number("wavelength_min", kFirstNm) : 0,
               last = even ? reader.number("wavelength_max", kLastNm) : 0;
  const std::vector<double> values = read_list(reader, "values");
  std::vector<double> nm = even ? std::vector<double>(values.size()) : read_list(reader, "wavelengths");
  if (values.empty() || nm.empty()) return std::nullopt;
  for (std::size_t i = 0; even && i < nm.size(); ++i)
    nm[i] = std::lerp(first, last, static_cast<double>(i) / std::max<double>(1, values.size() - 1.0));
  const spectra::Curve samples{{nm.begin(), nm.end()}, {values.begin(), values.end()}};
  absl::Status status = spectra::check_curve(samples);
  if (status.ok() && values.size() < 2) status = absl::InvalidArgumentError("expected two values or more");
  if (status.ok()) return sampled(samples, use);
  reader.error(concat(reader.object().title(), ": ", std::string(status.message())));
  return std::nullopt;
}

/// Planck's law in W / (m^2 sr nm).
std::optional<ConstantColor> read_blackbody(PropertyReader& reader, ColorUse use) {
  const double kelvin = reader.number("temperature", 5000);
  const double first = reader.number("wavelength_min", kFirstNm),
               last = reader.number("wavelength_max", kLastNm);
  if (!(kelvin > 0) || !(first > 0 && last > first)) {
    reader.error(concat(reader.object().title(),
                        ": expected a temperature above 0 and wavelengths that ascend, "
                        "found ",
                        kelvin, " K from ", first, " to ", last, " nm"));
    return std::nullopt;
  }
  spectra::Curve samples;
  const int steps = static_cast<int>(std::clamp(std::ceil(last - first), 1.0, 2000.0));
  for (int i = 0; i <= steps; ++i) {
    const double nm = std::lerp(first, last, static_cast<double>(i) / steps);
    samples.nm.push_back(static_cast<float>(nm));
    samples.values.push_back(static_cast<float>(spectra::planck(nm, kelvin)));
  }
  return sampled(std::move(samples), use);
}

/// The plugins that are one colour everywhere.
std::optional<ConstantColor> color_of_texture(PropertyReader& reader, Object& texture, ColorUse use) {
  PropertyReader nested(reader.context(), texture);
  if (texture.type == "uniform") {
    const double value = nested.number("value", 1);
    return use == ColorUse::kEmission ? uniform_light(value, {value, value, value}) : grey(value);
  }
  if (texture.type == "rawconstant") {
    const Property* value = nested.find("value");
    const Imath::V3d* vector = value == nullptr ? nullptr : std::get_if<Imath::V3d>(&value->value);
    return vector != nullptr ? ConstantColor{{vector->x, vector->y, vector->z}}
                             : read_color(nested, "value", 0, ColorUse::kUnbounded);
  }
  if (texture.type == "srgb")
    return read_color(nested, "color", 0, use == ColorUse::kReflectance ? use : ColorUse::kUnbounded);
  if (texture.type == "d65") {
    const double scale = nested.number("scale", 1);
    // Daylight of a colour is what light of the colour is here.
    ConstantColor color{read_color(nested, "color", 1, ColorUse::kUnbounded).rgb};
    return color *= scale;
  }
  if (texture.type == "regular" || texture.type == "irregular") return read_samples(nested, use);
  if (texture.type == "blackbody") return read_blackbody(nested, use);
  return std::nullopt;
}

}  // namespace

v1::Spectrum rgb_spectrum(const Color& rgb) {
  v1::Spectrum spectrum;
  spectrum.mutable_rgb()->set_r(static_cast<float>(rgb[0]));
  spectrum.mutable_rgb()->set_g(static_cast<float>(rgb[1]));
  spectrum.mutable_rgb()->set_b(static_cast<float>(rgb[2]));
  return spectrum;
}

v1::Spectrum constant_spectrum(double value) {
  v1::Spectrum spectrum;
  spectrum.set_constant(static_cast<float>(value));
  return spectrum;
}

v1::Spectrum ConstantColor::to_spectrum() const {
  v1::Spectrum spectrum = rgb_spectrum(rgb);
  if (curve.nm.empty()) return spectrum;
  *spectrum.mutable_in_rgb() = v1::Rgb(spectrum.rgb());
  spectrum.mutable_sampled()->mutable_wavelengths_nm()->Add(curve.nm.begin(), curve.nm.end());
  spectrum.mutable_sampled()->mutable_values()->Add(curve.values.begin(), curve.values.end());
  return spectrum;
}

ConstantColor& ConstantColor::operator*=(double factor) {
  for (double& component : rgb) component *= factor;
  for (float& value : curve.values) value = static_cast<float>(value * factor);
  return *this;
}

std::optional<ConstantColor> read_constant_color(PropertyReader& reader, const Property& property,
                                                 ColorUse use) {
  std::optional<ConstantColor> color;
  if (const double* number = std::get_if<double>(&property.value)) {
    color = grey(*number);
  } else if (const std::int64_t* whole = std::get_if<std::int64_t>(&property.value)) {
    color = grey(static_cast<double>(*whole));
  } else if (const Rgb* rgb = std::get_if<Rgb>(&property.value)) {
    color = ConstantColor{rgb->value};
  } else if (const SpectrumData* spectrum = std::get_if<SpectrumData>(&property.value)) {
    color = color_of(*spectrum, use);
  } else if (Object* const* object = std::get_if<Object*>(&property.value);
             object && (*object)->tag == "texture") {
    color = color_of_texture(reader, **object, use);
  }
  if (color && use != ColorUse::kSensitivity) color->rgb = clamped(reader, property, color->rgb, use);
  return color;
}

ConstantColor read_color(PropertyReader& reader, std::string_view name, double fallback, ColorUse use) {
  const Property* property = reader.find(name);
  if (property == nullptr) return grey(fallback);
  if (auto color = read_constant_color(reader, *property, use)) return *std::move(color);
  reader.error(*property, "expected a constant colour");
  return grey(fallback);
}

}  // namespace tessera::client::mitsuba
