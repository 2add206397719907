// Light from all around: a colour or a map of it, perhaps through a portal.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/color/texture_load.h"
#include "render/light/environment.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/light_values.h"
#include "render/scene/light/moving_light.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

/// Mean over all directions of the luminance of a map, whose negative texels count as zero.
double mean_luminance(const TextureImage& image, EnvironmentMapping mapping) {
  double sum = 0, weights = 0;
  for (std::int32_t y = 0; y < image.height; ++y) {
    // The area of a row of an equal-area map is that of any other.
    const double weight = mapping == EnvironmentMapping::kLatitudeLongitude
                              ? std::sin(std::numbers::pi * (y + 0.5) / image.height)
                              : 1;
    for (std::int32_t x = 0; x < image.width; ++x) {
      const std::size_t texel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      double rgb[3];
      for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = image.format == TexelFormat::kFloat
                     ? double{image.texels32[4 * texel + c]}
                     : double{image.decode[image.texels8[texel] >> (8 * c) & 255]};
      for (double& band : rgb) band = std::max(band, 0.0);
      sum += weight * (0.212671 * rgb[0] + 0.715160 * rgb[1] + 0.072169 * rgb[2]);
    }
    weights += weight * image.width;
  }
  return weights > 0 ? sum / weights : 0;
}

}  // namespace

absl::Status LightBuilder::set_portal(const v1::InfiniteLight& light, Environment& environment) const {
  if (light.portal().empty()) return absl::OkStatus();
  if (light.portal_size() != 4) return absl::InvalidArgumentError("a portal has four corners");
  const Imath::V3d p0 = point_of(light.portal(0));
  const Imath::V3d u = point_of(light.portal(1)) - p0, v = point_of(light.portal(3)) - p0;
  const double area = u.cross(v).length();
  if (!(area > 0) || !std::isfinite(area)) return absl::InvalidArgumentError("its portal has no area");
  const Imath::V3d corner = p0 - inputs_.space.origin;
  int i = 0;
  for (const Imath::V3d& row : {corner, u, v}) {
    for (const double x : {row.x, row.y, row.z}) environment.portal[i++] = static_cast<float>(x);
  }
  environment.portal_area = static_cast<float>(area);
  return absl::OkStatus();
}

absl::StatusOr<Environment> LightBuilder::environment_of(const v1::InfiniteLight& light, float scale,
                                                         std::optional<double> mean) const {
  auto world_from_light = Transform::from_proto(light.world_from_light());
  if (!world_from_light.ok()) return world_from_light.status();
  Transform light_from_world;
  if (!world_from_light->invert(light_from_world))
    return absl::InvalidArgumentError("its transform is singular");
  // Paths from lights and portals have no other way to what is not sampled.
  const bool compensate = !inputs_.algorithm.samples_all_light && light.portal().empty();
  if (!light.has_image()) {
    Environment even;
    even.sampled_share = compensate ? 0.0f : 1.0f;
    return even;
  }
  const std::string where = absl::StrCat("image '", light.image().path(), "'");
  const auto bytes = inputs_.blobs(light.image().digest());
  if (!bytes.ok()) return located(bytes.status(), where);
  const EnvironmentMapping mapping = light.mapping() == v1::InfiniteLight::LATITUDE_LONGITUDE
                                         ? EnvironmentMapping::kLatitudeLongitude
                                         : EnvironmentMapping::kEqualAreaOctahedral;
  if (inputs_.headers_alone) {
    const auto size = check_texture_image(bytes->bytes, light.image().path());
    if (!size.ok()) return size.status();
    if (auto s = check_environment_size(size->width, size->height, mapping); !s.ok())
      return located(s, where);
    return Environment{};
  }
  auto image = load_texture_image(bytes->bytes, light.image().path());
  if (!image.ok()) return image.status();
  if (mean) {
    const double own = mean_luminance(*image, mapping);
    if (!(own > 0) && *mean > 0)
      return located(absl::InvalidArgumentError("amount: it is black, of which there is no amount"), where);
    scale = own > 0 ? static_cast<float>(*mean / own) : 0;
  }
  auto built =
      build_environment(*std::move(image), mapping, scale, world_from_light->to_affine(), compensate);
  if (!built.ok()) return located(built.status(), where);
  return built;
}

absl::Status LightBuilder::add_infinite(const v1::Light& message, float scale) {
  const v1::InfiniteLight& light = message.infinite();
  if (light.has_scale()) scale *= light.scale();
  const auto way = way_of_sky(light, message.motion());
  if (!way.ok()) return way.status();
  LightRecord record;
  record.kind = LightKind::kInfinite;
  if (auto s = set_color(light.radiance(), message.has_amount() ? 1 : scale, "radiance", record); !s.ok())
    return s;
  if (light.has_image()) latest_ = {};
  std::optional<double> radiance;
  if (message.has_amount()) {
    const auto amount = read_amount(message.amount(), message);
    if (!amount.ok()) return amount.status();
    // Images are of daylight, as far as their colours are.
    if (light.has_image()) latest_.color = {1, 1, 1};
    const auto brightness = brightness_of(*amount);
    latest_ = light.has_image() ? SpectralEmission{} : latest_;
    if (!brightness.ok()) return brightness.status();
    // A surface in the open gets pi times an even radiance.
    radiance = *brightness / (amount->quantity == photometry::Quantity::kIrradiance ? std::numbers::pi : 1);
  }
  auto environment = environment_of(light, scale, radiance);
  if (!environment.ok()) return environment.status();
  if (auto s = set_portal(light, *environment); !s.ok()) return s;
  const std::size_t first = table_.lights.size();
  if (way->moves()) {
    environment->light_from_render = environment->render_from_light = Affine{};
    std::vector<Environment>& own = moving().still.environments;
    record.environment = static_cast<std::int32_t>(own.size());
    own.push_back(*std::move(environment));
    if (auto s = add_moving_light(*way, record); !s.ok()) return s;
  } else {
    record.environment = static_cast<std::int32_t>(table_.environments.size());
    table_.infinite_lights.push_back(static_cast<std::int32_t>(table_.lights.size()));
    table_.environments.push_back(*std::move(environment));
    table_.lights.push_back(record);
  }
  note_curve();
  if (radiance && !light.has_image()) return scale_lights(first, table_.lights.size(), *radiance);
  return absl::OkStatus();
}

}  // namespace tessera::render
