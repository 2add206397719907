// A sensor that comes from outside, as CONTRIBUTING tells how to add one: no camera, but a meter of
// irradiance.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/sampling/warp.h"
#include "render/sensor/sensor.h"
#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// This part of its rays does not leave it.
constexpr float kBlocked = 0.25f;

/// The irradiance at the origin of sensor space, from the side of +z; every pixel measures it.
class IrradianceMeter final : public SensorModel {
 public:
  IrradianceMeter()
      : SensorModel({.has_lens = true, .connects = false, .has_axis = false, .may_fail = true}) {}

  LocalRay start(const SensorRecord&, Vec2, Vec2 u_lens) const override {
    const Vec2 u{(u_lens.x - kBlocked) * (1 / (1 - kBlocked)), u_lens.y};
    return {.origin = {Float(0.0f), Float(0.0f), Float(0.0f)},
            .direction = square_to_cosine_hemisphere({max(u.x, 0.0f), u.y}),
            .weight = Float(std::numbers::pi_v<float> / (1 - kBlocked)),
            .valid = u.x >= 0.0f};
  }
  Float pixel_width(const SensorRecord&, Float distance) const override { return distance; }
};

/// The meter's reading under a sky of radiance 1, beneath a black disk that hides half of its light.
double reading(const std::string& more, std::uint32_t samples) {
  static const IrradianceMeter model;
  static const SensorKind kind = add_sensor_model(model);
  EXPECT_GE(kind, SensorKind::kCount);
  const auto content = build_kernel_scene(R"(
      camera { orthographic {} }
      film { width: 1 height: 1 }
      materials { name: 'black' diffuse { reflectance { constant { rgb {} } } } }
      shapes { disk { radius: 1 height: 1 } material: 'black' }
      lights { infinite { radiance { rgb { r: 1 g: 1 b: 1 } } } })" +
                                              more,
                                          1);
  if (content == nullptr) return 0;
  SceneTables tables = content->tables;
  // A case of its own in scene/view/sensor.cpp would set this.
  tables.sensor.kind = kind;
  const wire::TileResult result = render_tile<Wavefront>(*content, tables, samples);
  // Rays that do not leave the meter have hit nothing.
  const auto coverage = static_cast<double>(result.values[3]) / samples;
  EXPECT_NEAR(coverage, (1 - kBlocked) / 2, 2e-3);
  return MeanRadiance(result, samples).of_film(1);
}

TEST(ToySensor, MeasuresIrradianceAtAPoint) {
  // The share that a disk of radius r at distance h takes of a point's irradiance is r^2 / (r^2 + h^2). A
  // (0,2)-sequence of 2^16 points errs by about its last interval on the border of the disk: 2^-8 of the sum
  // at the very most, and much less by chance.
  EXPECT_NEAR(reading("", 1 << 16), std::numbers::pi / 2, 2e-3);
}

TEST(ToySensor, AndWherePathsLookForMedia) {
  // A surface that light passes unbent, far away, is enough for that.
  const std::string far_away = R"(
      materials { name: 'nothing' interface {} }
      shapes { sphere { radius: 1 } material: 'nothing'
               world_from_object { elements: [1,0,0,50, 0,1,0,0, 0,0,1,-50, 0,0,0,1] } })";
  EXPECT_NEAR(reading(far_away, 1 << 16), std::numbers::pi / 2, 2e-3);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
