// Moving things of glTF files: shapes, cameras and lights at a time, and while the shutter is open.
#include <algorithm>

#include "unit/import/gltf_fixture.h"

namespace tessera::client {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Pointwise;

class GltfMotion : public GltfTest {};

TEST_F(GltfMotion, StandsWhereItsAnimationsHaveItAtTheTime) {
  const auto place_at = [&](std::optional<double> time, const char* interpolation) {
    Json document = triangle();
    document["animations"][0]["samplers"][0]["interpolation"] = interpolation;
    GltfOptions options;
    options.time = time;
    return place_of(accepted(document, options).scene.shapes(0).world_from_object())[0];
  };
  EXPECT_EQ(place_at(std::nullopt, "LINEAR"), 0);
  EXPECT_EQ(place_at(0, "LINEAR"), 0);
  EXPECT_EQ(place_at(0.25, "LINEAR"), 0.5);
  EXPECT_EQ(place_at(1, "LINEAR"), 2);
  EXPECT_EQ(place_at(7, "LINEAR"), 2);
  EXPECT_EQ(place_at(0.75, "STEP"), 0);
}

TEST_F(GltfMotion, LightsMoveWhileTheShutterIsOpen) {
  Json document = triangle();
  document["extensionsUsed"] = {"KHR_lights_punctual"};
  document["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}}, {{"type", "spot"}, {"spot", Json::object()}}, {{"type", "directional"}}};
  for (int light = 0; light < 3; ++light) {
    document["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    document["nodes"][0]["children"].push_back(2 + light);
  }
  document["nodes"][0]["children"].push_back(1);
  document["scenes"][0]["nodes"] = {0};
  GltfOptions options;
  options.time = 0.25;
  options.shutter = 0.5;
  const ImportedScene moving = accepted(document, options);
  const v1::Scene& scene = moving.scene;
  EXPECT_EQ(scene.lights(0).point().position().x(), 0.5);
  EXPECT_EQ(scene.lights(2).distant().direction().z(), -1);
  for (const v1::Light& light : scene.lights()) {
    ASSERT_EQ(light.motion_size(), 1);
    EXPECT_EQ(light.motion(0).time(), 1);
    EXPECT_THAT(light.motion(0).place().elements(),
                ElementsAre(1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
  }
  options.shutter = 0;
  const ImportedScene still = accepted(document, options);
  EXPECT_EQ(still.scene.lights(0).motion_size(), 0);
}

/// A quarter of a turn about z while the shutter is open. A point's own turn is no motion.
TEST_F(GltfMotion, LightsTurnAsTheirNodesDo) {
  Json document = triangle();
  std::string keys;
  for (const float value : {0, 0, 0, 1, 0, 0, 1, 0})
    keys.append(reinterpret_cast<const char*>(&value), sizeof value);
  document["buffers"].push_back({{"byteLength", keys.size()}, {"uri", data_uri(keys)}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 32}});
  document["accessors"].push_back(
      {{"bufferView", 4}, {"componentType", 5126}, {"count", 2}, {"type", "VEC4"}});
  document["animations"][0] = Json::parse(R"({
    "samplers": [{"input": 2, "output": 4}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}]})");
  document["extensionsUsed"] = {"KHR_lights_punctual"};
  document["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}},
                                                             {{"type", "spot"}, {"spot", Json::object()}}};
  for (int light = 0; light < 2; ++light) {
    document["nodes"].push_back(
        {{"scale", {2, 3, 4}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    document["nodes"][0]["children"].push_back(2 + light);
  }
  document["nodes"][0]["children"].push_back(1);
  document["scenes"][0]["nodes"] = {0};
  GltfOptions options;
  options.time = 0;
  options.shutter = 0.5;
  const v1::Scene scene = accepted(document, options).scene;
  EXPECT_EQ(scene.lights(0).motion_size(), 0);
  ASSERT_GE(scene.lights(1).motion_size(), 1);
  const v1::MotionKey& last = scene.lights(1).motion(scene.lights(1).motion_size() - 1);
  EXPECT_EQ(last.time(), 1);
  const std::vector<double> quarter = {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  EXPECT_THAT(last.place().elements(), Pointwise(DoubleNear(1e-6), quarter));
}

/// A quarter turn about z by the middle of the way from none to a half turn; a spline without tangents eases.
TEST_F(GltfMotion, TurnsAlongTheSphereAndEasesAlongSplines) {
  Json document = triangle();
  std::string keys;
  const auto put = [&](std::initializer_list<float> values) {
    for (const float value : values) keys.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put({0, 0, 0, 1, 0, 0, 1, 0});                                // rotations
  put({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0});  // tangent, value, tangent; twice
  document["buffers"].push_back({{"byteLength", keys.size()}, {"uri", data_uri(keys)}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 32}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", 32}, {"byteLength", 72}});
  document["accessors"].push_back(
      {{"bufferView", 4}, {"componentType", 5126}, {"count", 2}, {"type", "VEC4"}});
  document["accessors"].push_back(
      {{"bufferView", 5}, {"componentType", 5126}, {"count", 6}, {"type", "VEC3"}});
  document["animations"][0] = Json::parse(R"({
    "samplers": [{"input": 2, "output": 4}, {"input": 2, "output": 5, "interpolation": "CUBICSPLINE"}],
    "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}},
                 {"sampler": 1, "target": {"node": 0, "path": "translation"}}]})");
  GltfOptions options;
  options.time = 0.5;
  const ImportedScene halfway = accepted(document, options);
  const auto& half = halfway.scene.shapes(0).world_from_object().elements();
  EXPECT_NEAR(half[0], 0, 1e-12);
  EXPECT_NEAR(half[4], 1, 1e-12);
  EXPECT_NEAR(half[3], 4, 1e-12);
  options.time = 0.25;
  // Hermite's 3 t^2 - 2 t^3, of 8.
  EXPECT_NEAR(place_of(accepted(document, options).scene.shapes(0).world_from_object())[0], 8 * 0.15625,
              1e-12);
}

/// From x = 0 at 0 s to x = 2 at 1 s.
TEST_F(GltfMotion, MovesWhileTheShutterIsOpen) {
  const auto shape_of = [&](double shutter, ShutterPosition position, const char* interpolation = "LINEAR") {
    Json document = triangle();
    document["animations"][0]["samplers"][0]["interpolation"] = interpolation;
    GltfOptions options;
    options.time = 0.5;
    options.shutter = shutter;
    options.shutter_position = position;
    return accepted(document, options).scene.shapes(0);
  };
  EXPECT_EQ(shape_of(0, ShutterPosition::kStart).motion_size(), 0);
  const v1::Shape start = shape_of(0.25, ShutterPosition::kStart);
  EXPECT_NEAR(place_of(start.world_from_object())[0], 1, 1e-6);
  ASSERT_EQ(start.motion_size(), 1);
  EXPECT_EQ(start.motion(0).time(), 1);
  EXPECT_NEAR(place_of(start.motion(0).place())[0], 1.5, 1e-6);
  EXPECT_NEAR(place_of(shape_of(0.25, ShutterPosition::kCenter).world_from_object())[0], 0.75, 1e-6);
  // Open until 1.5 s: it stands from the key at 1 s on.
  const v1::Shape stops = shape_of(1, ShutterPosition::kStart);
  const auto bend =
      std::ranges::find_if(stops.motion(), [](const v1::MotionKey& key) { return key.time() == 0.5; });
  ASSERT_NE(bend, stops.motion().end());
  EXPECT_NEAR(place_of(bend->place())[0], 2, 1e-6);
  EXPECT_NEAR(place_of(stops.motion().rbegin()->place())[0], 2, 1e-6);
  // A jump within a 128th of the time.
  const v1::Shape jumps = shape_of(1, ShutterPosition::kStart, "STEP");
  double before = 0, after = 1;
  for (const v1::MotionKey& key : jumps.motion()) {
    if (place_of(key.place())[0] < 1) before = std::max(before, key.time());
    if (place_of(key.place())[0] > 1) after = std::min(after, key.time());
  }
  EXPECT_LE(after - before, 1.0 / 128);
  EXPECT_GE(0.5, before);
  EXPECT_LE(0.5, after);
}

}  // namespace
}  // namespace tessera::client
