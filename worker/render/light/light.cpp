#include "render/light/light.h"

#include <algorithm>
#include <cmath>

#include "render/color/texture.h"
#include "render/light/light_access.h"
#include "render/light/moving_lights.h"

namespace tessera::render::TESSERA_ISA {
namespace {

LightSample no_sample() {
  return {{0.0f, 0.0f, 1.0f}, Float(0.0f), Color(0.0f), Float(0.0f), Mask::none(), Mask::none()};
}

/// The textures of area lights, at points of their surfaces.
Color texture_factor(const LightTable& table, Int light, const TexturePoint& at, Mask active) {
  Color factor(1.0f);
  const Int texture = gather_member(table.lights.data(), &LightRecord::texture, light, active);
  for_each_distinct(texture, active & (texture >= 0), [&](std::int32_t t, Mask lanes) {
    factor = select(lanes, eval_texture(*table.textures, t, at, lanes), factor);
  });
  return factor;
}

/// Hit::instance of lights on shapes; -1 where they stand still.
Int place_of_moving_lights(const LightTable& table, Int light, Mask active) {
  const Int motion = gather(table.moving->motion_of_light.data(), light, active);
  const Mask moves = active & (motion >= 0);
  return select(moves, gather_member(table.moving->motions.data(), &LightMotion::instance, motion, moves),
                Int(-1));
}

constinit ModelTable<LightModel, LightKind> models;

/// The model of all active lanes' lights, if they have one.
const LightModel* common_model(const LightTable& table, Int light, Mask active) {
  if (const LightRecord* const one = common_light(table, light, active)) return &light_model(one->kind);
  const std::optional<std::int32_t> kind = common_value(kind_of(table, light, active), active);
  return kind ? &light_model(static_cast<LightKind>(*kind)) : nullptr;
}

const LightSource& source(LightKind kind) { return light_model(kind); }

/// Points of a square for rays first, first + 1, ...: two of the four dimensions of a Kronecker sequence by
/// the powers of the root of x^5 = x + 1 [Roberts 2018].
Vec2 kronecker_points(std::int32_t first, int dimension) {
  constexpr double kRoot = 1.1673039782614187;
  Float coordinates[2];
  for (int d = 0; d < 2; ++d) {
    const double step = std::pow(kRoot, -(dimension + d + 1));
    alignas(64) float u[kWidth];
    for (int i = 0; i < kWidth; ++i) {
      const double turns = 0.5 + step * (first + i + 1.0);
      u[i] = std::min(static_cast<float>(turns - std::floor(turns)), 1 - 0x1p-24f);
    }
    coordinates[d] = Float::load(u);
  }
  return {coordinates[0], coordinates[1]};
}

std::optional<LightKind> kind_on_shape(ShapeKind shape) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto kind = static_cast<LightKind>(i);
    if (shape != ShapeKind::kCount && models[kind]->traits.surface == shape) return kind;
  }
  return std::nullopt;
}

}  // namespace

const LightModel& light_model(LightKind kind) { return *models[kind]; }

void set_model(LightKind kind, const LightModel& model) { models.set(kind, model); }

LightSources light_sources() { return {&source, &kind_on_shape}; }

LightKind add_light_model(const LightModel& model) { return models.add(model); }

std::array<double, kBands> LightModel::emitted_flux(const LightTable& table, std::int32_t light,
                                                    std::int32_t rays) const {
  std::array<double, kBands> sum{};
  for (std::int32_t first = 0; first < rays; first += kWidth) {
    const Mask active = Mask::first(rays - first);
    const Emission emission =
        emit(table, Int(light), Float(0.0f), kronecker_points(first, 0), kronecker_points(first, 2), active);
    for (int band = 0; band < kBands; ++band) {
      alignas(64) float flux[kWidth];
      select_or_zero(active & emission.valid, emission.flux.c[band]).store(flux);
      for (const float one : flux) sum[static_cast<std::size_t>(band)] += one;
    }
  }
  for (double& band : sum) band /= std::max(rays, 1);
  return sum;
}

LightSample sample_light(const LightTable& table, Int light, const Receiver& from, Vec2 u, Mask active) {
  LightSample result;
  if (const LightModel* const model = common_model(table, light, active)) {
    result = model->sample(table, light, from, u, active);
    result.valid &= active;
  } else {
    result = no_sample();
    for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
      const LightSample one = light_model(static_cast<LightKind>(kind)).sample(table, light, from, u, lanes);
      result = select(lanes, one, result);
    });
  }
  if (table.any_textures) {
    const Vec3 point = fma(result.wi, result.distance, from.p);
    const Mask lit = result.valid & active;
    result.radiance = select(
        lit, result.radiance * emission_texture(table, light, from.time, point, result.barycentric, lit),
        result.radiance);
  }
  return result;
}

Color emission_texture(const LightTable& table, Int light, Float time, Vec3 point, Vec2 barycentric,
                       Mask active) {
  const auto field = [&](std::int32_t LightRecord::*member) {
    return gather_member(table.lights.data(), member, light, active);
  };
  const Int shape = field(&LightRecord::shape);
  const Mask textured = active & (shape >= 0) & (field(&LightRecord::texture) >= 0);
  if (none(textured)) return Color(1.0f);
  // Quadrics are found again from a point near them.
  const Int place = table.moving == nullptr ? Int(-1) : place_of_moving_lights(table, light, textured);
  const Hit hit{Float(0.0f), barycentric.x, barycentric.y, field(&LightRecord::primitive),
                shape,       place,         time};
  const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
  return texture_factor(
      table, light, texture_point(surface_at(*table.shapes, hit, point, zero, textured, false)), textured);
}

Color LightLanes::texture_at(Vec2 uv, Mask wanted) const {
  return texture_factor(table, light, TexturePoint::at(uv), wanted);
}

Float light_pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
                Mask active) {
  Float result(0.0f);
  for_each_distinct(kind_of(table, light, active), active, [&](std::int32_t kind, Mask lanes) {
    const LightModel& model = light_model(static_cast<LightKind>(kind));
    result = select(lanes, model.pdf(table, light, from, wi, point, normal, lanes), result);
  });
  return result;
}

Color emitted_radiance(const LightTable& table, Int light, const Surface& surface, Vec3 wo, Mask active) {
  const LightLanes lanes{table, light, active};
  const Mask shines = lanes.shines_towards(surface.ng, wo);
  Color radiance = select_or_zero(shines, lanes.radiance());
  if (table.any_textures) radiance = radiance * texture_factor(table, light, texture_point(surface), shines);
  return radiance;
}

}  // namespace tessera::render::TESSERA_ISA
