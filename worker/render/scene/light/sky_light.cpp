// Daylight: a map of the sky and the ground, and the sun.
#include "render/scene/light/sky_light.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "photometry/sky/sky_map.h"
#include "render/light/environment.h"
#include "render/scene/light/light_amount.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/light_values.h"
#include "wire/sky_light.h"

namespace tessera::render {
namespace {

/// The axes x, y and z of light space, in the world.
Affine world_from_axes(const wire::WorldHorizon::Vector& x, const wire::WorldHorizon::Vector& y,
                       const wire::WorldHorizon::Vector& z) {
  Affine m;
  for (int row = 0; row < 3; ++row) {
    const auto i = static_cast<std::size_t>(row);
    m.m[4 * row] = static_cast<float>(x[i]), m.m[4 * row + 1] = static_cast<float>(y[i]);
    m.m[4 * row + 2] = static_cast<float>(z[i]), m.m[4 * row + 3] = 0;
  }
  return m;
}

/// Axes with y towards the sun. The sun is round, so the others are any.
Affine world_from_sun(const wire::WorldHorizon::Vector& sun) {
  const Imath::V3d y(sun[0], sun[1], sun[2]);
  const Imath::V3d aside = std::abs(y.x) < 0.5 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 1, 0);
  const Imath::V3d x = y.cross(aside).normalized(), z = x.cross(y);
  return world_from_axes({x.x, x.y, x.z}, {y.x, y.y, y.z}, {z.x, z.y, z.z});
}

/// A picture of luminances of a colour whose luminance is 1.
TextureImage picture_of(std::span<const float> luminances, std::int32_t width, const spectra::Rgb& color) {
  TextureImage image;
  image.width = width;
  image.height = static_cast<std::int32_t>(luminances.size()) / width;
  image.format = TexelFormat::kFloat;
  image.texels32.reserve(4 * luminances.size());
  for (const float luminance : luminances) {
    for (const float channel : {color.r, color.g, color.b, 1.0f})
      image.texels32.push_back(luminance * channel);
  }
  return image;
}

}  // namespace

bool has_parallel_sun(const v1::SkyLight& light) {
  return wire::has_sun(light) && wire::sun_degrees(light) == 0;
}

absl::StatusOr<spectra::Rgb> LightBuilder::color_of_sky(bool is_said, const v1::Spectrum& spectrum,
                                                        const char* field) {
  latest_ = {.color = {1, 1, 1}};
  if (!is_said) return latest_.color;
  if (auto s = check_spectrum(spectrum, field); !s.ok()) return s;
  const double luminance = luminance_of(emission(spectrum));
  if (!(luminance > 0) || !std::isfinite(luminance))
    return absl::InvalidArgumentError(absl::StrCat(field, " has no luminance"));
  if (inputs_.spectral == nullptr) {
    latest_.color = emission(spectrum);
  } else {
    latest_ = inputs_.spectral->emission_of(spectrum);
  }
  const auto factor = static_cast<float>(1 / luminance);
  return spectra::Rgb{latest_.color.r * factor, latest_.color.g * factor, latest_.color.b * factor};
}

absl::Status LightBuilder::add_map(TextureImage image, EnvironmentMapping mapping, float scale,
                                   const Affine& world_from_light) {
  LightRecord record;
  record.kind = LightKind::kInfinite;
  record.environment = static_cast<std::int32_t>(table_.environments.size());
  Environment environment;
  if (!inputs_.headers_alone) {
    auto built = build_environment(std::move(image), mapping, scale, world_from_light,
                                   !inputs_.algorithm.samples_all_light);
    if (!built.ok()) return built.status();
    environment = *std::move(built);
  }
  table_.infinite_lights.push_back(static_cast<std::int32_t>(table_.lights.size()));
  table_.environments.push_back(std::move(environment));
  table_.lights.push_back(record);
  note_curve();
  return absl::OkStatus();
}

absl::Status LightBuilder::add_sun(const v1::SkyLight& light, const photometry::Sky& sky, float scale) {
  const auto color = color_of_sky(light.has_sun_color(), light.sun_color(), "sun_color");
  if (!color.ok()) return color.status();
  const wire::WorldHorizon::Vector sun = wire::horizon_of(light).world_from_horizon(sky.sun);
  if (const double degrees = wire::sun_degrees(light); degrees > 0) {
    const photometry::SunColumn column = photometry::sun_column(degrees, sky.sun_normal_illuminance);
    std::vector<float> luminances(static_cast<std::size_t>(column.rows), 0.0f);
    std::fill_n(luminances.begin(), column.lit_rows, static_cast<float>(column.luminance));
    return add_map(picture_of(luminances, 1, *color), EnvironmentMapping::kLatitudeLongitude, scale,
                   world_from_sun(sun));
  }
  LightRecord record;
  record.kind = LightKind::kDistant;
  put(*color, static_cast<float>(sky.sun_normal_illuminance) * scale, record.radiance);
  for (std::size_t i = 0; i < 3; ++i) record.direction[i] = static_cast<float>(-sun[i]);
  table_.lights.push_back(record);
  note_curve();
  return absl::OkStatus();
}

absl::Status LightBuilder::add_sky(const v1::Light& light, float scale) {
  if (light.motion_size() > 0)
    return absl::InvalidArgumentError(
        "a sky does not move while the shutter is open; frames may have other skies");
  if (light.has_amount())
    return absl::InvalidArgumentError(
        "a sky has its brightness in diffuse_horizontal_illuminance, not in an amount");
  const auto sky = wire::sky_of(light.sky());
  if (!sky.ok()) return sky.status();
  const auto color = color_of_sky(light.sky().has_sky_color(), light.sky().sky_color(), "sky_color");
  if (!color.ok()) return color.status();
  // Luminances become radiances here.
  const auto radiance_scale = static_cast<float>(scale / inputs_.scale.cd_per_m2);
  const wire::WorldHorizon horizon = wire::horizon_of(light.sky());
  const int size = wire::sky_resolution(light.sky());
  TextureImage map;
  if (!inputs_.headers_alone) map = picture_of(photometry::sky_map(*sky, size), size, *color);
  if (auto s = add_map(std::move(map), EnvironmentMapping::kEqualAreaOctahedral, radiance_scale,
                       world_from_axes(horizon.east, horizon.north, horizon.up));
      !s.ok())
    return s;
  return wire::has_sun(light.sky()) ? add_sun(light.sky(), *sky, radiance_scale) : absl::OkStatus();
}

}  // namespace tessera::render
