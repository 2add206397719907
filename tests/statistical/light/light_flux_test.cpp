// The flux that lights emit, as scenes ask for it whose lamps are given in lumens, against closed forms.
#include <gtest/gtest.h>

#include "statistical/light/lamps.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr double kAllPi = std::numbers::pi;
constexpr std::int32_t kFluxRays = 1 << 16;

/// The flux of all lights of a lamp, each once.
std::array<double, kBands> flux_of(const Lamp& lamp) {
  std::array<double, kBands> sum{};
  for (std::size_t i = 0; i < lamp.table.lights.size(); ++i) {
    const LightRecord& light = lamp.table.lights[i];
    if (light.same_as >= 0) continue;
    const auto flux =
        light_model(light.kind).emitted_flux(lamp.table, static_cast<std::int32_t>(i), kFluxRays);
    for (std::size_t band = 0; band < flux.size(); ++band) sum[band] += flux[band];
  }
  return sum;
}

/// Each band is its radiance (or intensity) times `etendue` of the lamp.
void expect_flux(const Lamp& lamp, double etendue, double tolerance) {
  const auto flux = flux_of(lamp);
  for (std::size_t band = 0; band < flux.size(); ++band)
    EXPECT_NEAR(flux[band] / (kLampRadiance[band] * etendue), 1, tolerance) << lamp.name << ", band " << band;
}

Lamp spot_lamp(LightKind kind, LightProfile profile) {
  Lamp lamp;
  LightRecord& record = lamp.table.lights.emplace_back();
  record.kind = kind;
  record.profile = profile;
  std::copy(kLampRadiance.begin(), kLampRadiance.end(), record.radiance);
  record.position[0] = 1, record.position[1] = -2, record.position[2] = 3;
  record.radius = 0.1f;
  record.cos_inner = 0.9f, record.cos_outer = 0.6f;
  record.tan_x = 0.5f, record.tan_y = 0.3f;
  for (const std::size_t i : {0, 4, 8}) record.vertices[i] = 1;
  return lamp;
}

// Points are chosen evenly by area, so that every ray has the same flux, but for some roundings.
constexpr double kFluxRounding = 1e-5;
// 65536 points of an even sequence: the integrands are smooth, or have an edge, whose length over the points
// is less than this.
constexpr double kSequence = 5e-4;

TEST(EmittedFlux, OfSurfacesIsPiTimesAreaAndRadiance) {
  const std::vector<Point> corners = {{0, 0, 1}, {2, 0, 1}, {2, 3, 1}, {0, 3, 1}};
  expect_flux(mesh_lamp("rectangle", corners, {0, 1, 2, 0, 2, 3}, false), kAllPi * 6, kFluxRounding);
  expect_flux(mesh_lamp("two sides", corners, {0, 1, 2, 0, 2, 3}, true), kAllPi * 12, kFluxRounding);
  expect_flux(mesh_lamp("triangle", corners, {0, 1, 2}, false), kAllPi * 3, kFluxRounding);
}

TEST(EmittedFlux, OfPointsAndConesIsTheirSolidAngle) {
  expect_flux(spot_lamp(LightKind::kPoint, kPlainProfile), 4 * kAllPi, kFluxRounding);
  expect_flux(spot_lamp(LightKind::kSoftPoint, kPlainProfile), 4 * kAllPi, kFluxRounding);
  const double smooth = 2 * kAllPi * (0.1 + 0.3 / 2);
  expect_flux(spot_lamp(LightKind::kSpot, kPlainProfile), smooth, kSequence);
  expect_flux(spot_lamp(LightKind::kSoftSpot, kPlainProfile), smooth, kSequence);
  const double inner = std::acos(0.9), outer = std::acos(0.6);
  const double linear = 2 * kAllPi * (0.1 + 0.9 - (std::sin(outer) - std::sin(inner)) / (outer - inner));
  expect_flux(spot_lamp(LightKind::kSpot, kLinearAngle), linear, kSequence);
}

TEST(EmittedFlux, OfProjectionsIsTheirPyramid) {
  const double pyramid = 4 * std::asin(0.5 * 0.3 / std::sqrt(1.25 * 1.09));
  expect_flux(spot_lamp(LightKind::kProjection, kPlainProfile), pyramid, kSequence);
  expect_flux(spot_lamp(LightKind::kProjection, kEvenScreen), 4 * 0.5 * 0.3, kSequence);
}

TEST(EmittedFlux, OfTexturedLightsHasTheTexture) {
  // A slide whose left half is black and whose right half is one quarter.
  auto image = std::make_shared<TextureImage>();
  image->width = 2, image->height = 1;
  image->texels32 = {0, 0, 0, 1, 0.25f, 0.25f, 0.25f, 1};
  TextureTable textures;
  TextureNode& node = textures.nodes.emplace_back();
  node.kind = TextureKind::kImage;
  node.image = image;
  node.filter = TexelFilter::kNearest;
  node.wrap = {WrapMode::kClamp, WrapMode::kClamp};
  Lamp lamp = spot_lamp(LightKind::kProjection, kEvenScreen);
  lamp.table.textures = &textures;
  lamp.table.any_textures = true;
  lamp.table.lights[0].texture = 0;
  expect_flux(lamp, 4 * 0.5 * 0.3 / 8, kSequence);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
