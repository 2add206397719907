#include "render/textbook/preview/lighting.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>

#include "render/core/constants.h"
#include "render/light/light.h"
#include "render/light/light_access.h"
#include "render/light/light_build.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr double kPi64 = std::numbers::pi;
/// Share of light that walls reflect, where it has to be guessed.
constexpr double kWallReflectance = 0.5;

/// Emitting primitives that are taken together.
struct Patch {
  LightBounds bounds;
  double area = 0, power = 0;
  vec64::Vec vector_area;  // sum of area times normal, of what is flat
  vec64::Vec light;        // radiance times area
};

Patch patch_of(const LightTable& table, std::span<const std::int32_t> lights) {
  Patch patch;
  for (const std::int32_t i : lights) {
    const LightRecord& light = table.lights[static_cast<std::size_t>(i)];
    const LightBounds one = table.sources(light.kind).bounds(table, light);
    patch.bounds.add(one.low);
    patch.bounds.add(one.high);
    patch.bounds.two_sided = one.two_sided;
    patch.area += light.area;
    patch.power += sampled_power(table, light);
    if (one.angle == 0) patch.vector_area = patch.vector_area + one.axis * light.area;
    // A texture counts as it is in the middle of the primitive.
    const vec64::Vec middle = (one.low + one.high) * 0.5;
    const Float third(1.0f / 3);
    const Spectrum factor =
        emission_texture(table, Int(i),
                         {Float(static_cast<float>(middle[0])), Float(static_cast<float>(middle[1])),
                          Float(static_cast<float>(middle[2]))},
                         {third, third}, Mask::all());
    const Vec3 rgb = vec3_of(factor);
    const float factors[3] = {rgb.x.lane(0), rgb.y.lane(0), rgb.z.lane(0)};
    for (std::size_t c = 0; c < 3; ++c) patch.light[c] += double{light.radiance[c]} * factors[c] * light.area;
  }
  return patch;
}

void set(float (&to)[3], const vec64::Vec& from) {
  for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(from[c]);
}

/// A lamp of each group of neighbours among a shape's lights that is about as long as it is wide.
void add_patches(const LightTable& table, std::span<std::int32_t> lights, std::vector<Lamp>& lamps) {
  const Patch patch = patch_of(table, lights);
  const vec64::Vec extent = patch.bounds.high - patch.bounds.low;
  // A square's diagonal is 1.4 times the root of its area, a sphere's box's 1.0 times.
  constexpr double kLongest = 2;
  if (lights.size() > 1 && vec64::length(extent) > kLongest * std::sqrt(patch.area)) {
    const std::size_t axis = static_cast<std::size_t>(std::max_element(extent.v, extent.v + 3) - extent.v);
    const auto centre = [&](std::int32_t i) {
      const LightRecord& light = table.lights[static_cast<std::size_t>(i)];
      const LightBounds b = table.sources(light.kind).bounds(table, light);
      return std::pair(b.low[axis] + b.high[axis], i);
    };
    const auto middle = static_cast<std::ptrdiff_t>(lights.size() / 2);
    std::nth_element(lights.begin(), lights.begin() + middle, lights.end(),
                     [&](std::int32_t a, std::int32_t b) { return centre(a) < centre(b); });
    add_patches(table, lights.first(static_cast<std::size_t>(middle)), lamps);
    add_patches(table, lights.subspan(static_cast<std::size_t>(middle)), lamps);
    return;
  }
  if (!(patch.area > 0)) return;
  Lamp lamp;
  lamp.shape = table.lights[static_cast<std::size_t>(lights.front())].shape;
  set(lamp.place, (patch.bounds.low + patch.bounds.high) * 0.5);
  set(lamp.axis, vec64::unit(patch.vector_area));
  const double flat = vec64::length(patch.vector_area), round = std::max(patch.area - flat, 0.0) / 4;
  lamp.flat_area = static_cast<float>(flat);
  lamp.round_area = static_cast<float>(round);
  lamp.two_sided = patch.bounds.two_sided;
  lamp.cone = static_cast<float>(lamp.two_sided || round > 1e-6 * flat ? kPi64 : kPi64 / 2);
  lamp.radius = static_cast<float>(std::sqrt((flat + round) / kPi64));
  lamp.power = patch.power;
  set(lamp.radiance, patch.light * (1 / patch.area));
  lamps.push_back(lamp);
}

/// A light without a surface.
Lamp lamp_of(const LightTable& table, std::int32_t index) {
  const LightRecord& light = table.lights[static_cast<std::size_t>(index)];
  Lamp lamp;
  lamp.light = index;
  lamp.power = sampled_power(table, light);
  lamp.at_infinity = table.sources(light.kind).traits.at_infinity;
  if (lamp.at_infinity) {
    set(lamp.axis, vec64::unit(vec64::vec(light.direction)));
    return lamp;
  }
  const LightBounds bounds = table.sources(light.kind).bounds(table, light);
  set(lamp.place, (bounds.low + bounds.high) * 0.5);
  set(lamp.axis, vec64::unit(bounds.axis));
  lamp.cone = static_cast<float>(std::min(bounds.angle + bounds.reach, kPi64));
  if (table.sources(light.kind).traits.extended) lamp.radius = light.radius;
  return lamp;
}

/// The harmonics at a direction [Ramamoorthi & Hanrahan 2001].
template <class T, class Result>
void harmonics(T x, T y, T z, Result (&to)[9]) {
  to[0] = Result(0.282095f);
  to[1] = 0.488603f * y, to[2] = 0.488603f * z, to[3] = 0.488603f * x;
  to[4] = 1.092548f * (x * y), to[5] = 1.092548f * (y * z), to[7] = 1.092548f * (x * z);
  to[6] = 0.315392f * (3.0f * (z * z) - 1.0f);
  to[8] = 0.546274f * (x * x - y * y);
}

/// Adds the irradiance from one environment, as it is about the middle of the scene.
void add_environment(const LightTable& table, std::int32_t light, double (&sum)[9][kBands]) {
  // Factors that the cosine has for each order.
  constexpr double kCosine[9] = {kPi64,     2 * kPi64 / 3, 2 * kPi64 / 3, 2 * kPi64 / 3, kPi64 / 4,
                                 kPi64 / 4, kPi64 / 4,     kPi64 / 4,     kPi64 / 4};
  constexpr int kRoot = 64;  // samples on a side of the unit square
  const Vec3 centre{Float(table.scene_centre[0]), Float(table.scene_centre[1]), Float(table.scene_centre[2])};
  for (int i = 0; i < kRoot * kRoot; i += kWidth) {
    const Int n = Int::iota(i);
    const Int row = shift_right<6>(n);
    const Vec2 u{(to_float(n - row * kRoot) + 0.5f) * (1.0f / kRoot),
                 (to_float(row) + 0.5f) * (1.0f / kRoot)};
    const LightSample sample = sample_light(table, Int(light), centre, u, Mask::all());
    const Mask valid = sample.valid & (sample.pdf > 0.0f);
    const Vec3 rgb = vec3_of(sample.radiance * (1.0f / select(valid, sample.pdf, 1.0f)));
    Float basis[9];
    harmonics(sample.wi.x, sample.wi.y, sample.wi.z, basis);
    const Float bands[kBands] = {rgb.x, rgb.y, rgb.z};
    for (int k = 0; k < 9; ++k) {
      for (int c = 0; c < kBands; ++c) {
        const Float product = select_or_zero(valid & is_finite(bands[c]), bands[c] * basis[k]);
        for (int lane = 0; lane < kWidth; ++lane)
          sum[k][c] += kCosine[k] / (kRoot * kRoot) * double{product.lane(lane)};
      }
    }
  }
}

}  // namespace

Lighting lighting_of(const SceneTables& scene) {
  const LightTable& table = scene.lights;
  Lighting lighting;
  double ambient[9][kBands] = {};
  std::map<std::int32_t, std::vector<std::int32_t>> emitters;  // lights by shape
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(table.lights.size()); ++i) {
    const LightRecord& light = table.lights[static_cast<std::size_t>(i)];
    if (light.environment >= 0) {
      add_environment(table, i, ambient);
    } else if (!(sampled_power(table, light) > 0)) {
      continue;
    } else if (light.shape >= 0) {
      emitters[light.shape].push_back(i);
    } else {
      lighting.lamps.push_back(lamp_of(table, i));
    }
  }
  for (auto& [shape, lights] : emitters) add_patches(table, lights, lighting.lamps);
  std::stable_sort(lighting.lamps.begin(), lighting.lamps.end(),
                   [](const Lamp& a, const Lamp& b) { return a.power > b.power; });

  // In a closed room, light of power P on walls of area A makes an irradiance of P rho / (A (1 - rho)) by
  // all further reflections; at the first one, P / A more. The sphere about the scene stands for the walls.
  const double walls = 4 * kPi64 * table.scene_radius * table.scene_radius;
  const double further = kWallReflectance / (1 - kWallReflectance);
  constexpr double kConstant = 0.282095;  // the first harmonic
  for (std::size_t i = 0; i < lighting.lamps.size() && walls > 0; ++i) {
    const Lamp& lamp = lighting.lamps[i];
    const float* const colour =
        lamp.light < 0 ? lamp.radiance : table.lights[static_cast<std::size_t>(lamp.light)].radiance;
    const double mean = (double{colour[0]} + colour[1] + colour[2]) / 3;
    const double irradiance = lamp.power / walls * (further + (i < kMostLamps ? 0 : 1));
    for (int c = 0; c < kBands && mean > 0; ++c) ambient[0][c] += irradiance * colour[c] / mean / kConstant;
  }
  if (lighting.lamps.size() > kMostLamps) lighting.lamps.resize(kMostLamps);
  for (int k = 0; k < 9; ++k) {
    for (int c = 0; c < kBands; ++c)
      lighting.ambient[k][c] = static_cast<float>(double{scene.preview.ambient} * ambient[k][c]);
  }
  return lighting;
}

Spectrum Lighting::ambient_irradiance(Vec3 n) const {
  Float basis[9];
  harmonics(n.x, n.y, n.z, basis);
  const Spectrum sum = color_of([&](int band) {
    Float value(0.0f);
    for (int k = 0; k < 9; ++k) value = fma(basis[k], Float(ambient[k][band]), value);
    return value;
  });
  return max(sum, 0.0f);  // series that end may swing below
}

LampLight light_of(const SceneTables& scene, const Lamp& lamp, Vec3 p, Mask active) {
  LampLight result;
  if (lamp.light >= 0) {
    // The middle of a light with an extent.
    const LightSample sample =
        sample_light(scene.lights, Int(lamp.light), p, {Float(0.0f), Float(0.5f)}, active);
    result.wi = sample.wi;
    result.irradiance = sample.radiance * (1.0f / select(sample.valid, sample.pdf, 1.0f));
    result.most = Float(std::numeric_limits<float>::infinity());
    result.lit = active & sample.valid;
    if (lamp.radius > 0) {
      // A surface across wi has what the sphere sends, most of it askew, not what as large a middle would.
      const Vec3 to{Float(lamp.place[0]) - p.x, Float(lamp.place[1]) - p.y, Float(lamp.place[2]) - p.z};
      const Float sine_squared = sqr(lamp.radius) / max(length_squared(to), sqr(lamp.radius));
      result.irradiance *= 0.5f * (1.0f + sqrt(1.0f - sine_squared));
      result.most = result.irradiance.max_component() / (kPi * sine_squared);
    }
    return result;
  }
  const Vec3 to{Float(lamp.place[0]) - p.x, Float(lamp.place[1]) - p.y, Float(lamp.place[2]) - p.z};
  const Float distance2 = length_squared(to);
  const Mask apart = active & (distance2 > 0.0f);
  result.wi = to * (1.0f / sqrt(select(apart, distance2, 1.0f)));
  const Float along = -dot(result.wi, {Float(lamp.axis[0]), Float(lamp.axis[1]), Float(lamp.axis[2])});
  const Float flat = (lamp.two_sided ? abs(along) : max(along, 0.0f)) * lamp.flat_area;
  // Near a disk, along its axis, irradiance goes by 1 / (r^2 + R^2).
  const Float spread = distance2 + flat * kInvPi;
  const Float solid_angle = (flat + lamp.round_area) / select(apart, spread, 1.0f);
  result.irradiance = color_of(lamp.radiance) * solid_angle;
  result.most = color_of(lamp.radiance).max_component();
  result.lit = apart & (solid_angle > 0.0f);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
