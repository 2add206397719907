#include "import/mitsuba/matter/colors.h"

#include <algorithm>
#include <cmath>

#include "import/input/concat.h"
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

Color color_of(const SpectrumData& spectrum, ColorUse use) {
  if (!spectrum.is_uniform()) {
    return spectra::mitsuba_rgb(spectrum.samples, use == ColorUse::kEmission
                                                      ? spectra::SeenUnder::kEqualEnergy
                                                      : spectra::SeenUnder::kD65);
  }
  const double value = spectrum.uniform;
  if (use != ColorUse::kEmission) return {value, value, value};
  return spectra::mitsuba_rgb_from_xyz({value, value, value});
}

/// The plugins that are one colour everywhere.
std::optional<Color> color_of_texture(PropertyReader& reader, Object& texture, ColorUse use) {
  PropertyReader nested(reader.context(), texture);
  std::optional<Color> color;
  if (texture.type == "uniform") {
    const double value = nested.number("value", 1);
    color = Color{value, value, value};
  } else if (texture.type == "rawconstant") {
    const Property* value = nested.find("value");
    const Imath::V3d* vector = value == nullptr ? nullptr : std::get_if<Imath::V3d>(&value->value);
    color = vector != nullptr ? Color{vector->x, vector->y, vector->z}
                              : read_color(nested, "value", 0, ColorUse::kUnbounded);
  } else if (texture.type == "srgb") {
    color = read_color(nested, "color", 0, use == ColorUse::kReflectance ? use : ColorUse::kUnbounded);
  } else if (texture.type == "d65") {
    const double scale = nested.number("scale", 1);
    color = read_color(nested, "color", 1, ColorUse::kUnbounded);
    for (double& component : *color) component *= scale;
  }
  return color;
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

std::optional<Color> read_constant_color(PropertyReader& reader, const Property& property, ColorUse use) {
  std::optional<Color> color;
  if (const double* number = std::get_if<double>(&property.value)) {
    color = Color{*number, *number, *number};
  } else if (const std::int64_t* whole = std::get_if<std::int64_t>(&property.value)) {
    const auto value = static_cast<double>(*whole);
    color = Color{value, value, value};
  } else if (const Rgb* rgb = std::get_if<Rgb>(&property.value)) {
    color = rgb->value;
  } else if (const SpectrumData* spectrum = std::get_if<SpectrumData>(&property.value)) {
    color = color_of(*spectrum, use);
  } else if (Object* const* object = std::get_if<Object*>(&property.value);
             object && (*object)->tag == "texture") {
    color = color_of_texture(reader, **object, use);
  }
  return color ? std::optional(clamped(reader, property, *color, use)) : std::nullopt;
}

Color read_color(PropertyReader& reader, std::string_view name, double fallback, ColorUse use) {
  const Property* property = reader.find(name);
  if (property == nullptr) return {fallback, fallback, fallback};
  if (const std::optional<Color> color = read_constant_color(reader, *property, use)) return *color;
  reader.error(*property, "expected a constant colour");
  return {fallback, fallback, fallback};
}

}  // namespace tessera::client::mitsuba
