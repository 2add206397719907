// Lights and media of Mitsuba scenes.
#include <cmath>
#include <numbers>

#include "unit/import/mitsuba_fixture.h"
#include "wire/volume_blob.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::FloatEq;
using testing::HasSubstr;

using MitsubaScene = MitsubaTest;

/// A grid of two samples along x, in a box from (0, 0, 0) to (2, 4, 8).
std::string volume_bytes(std::uint32_t channels) {
  std::string bytes = "VOL\x03";
  for (const std::uint32_t n : {1u, 2u, 1u, 1u, channels}) append<std::uint32_t>(bytes, n);
  for (const float x : {0.f, 0.f, 0.f, 2.f, 4.f, 8.f}) append<float>(bytes, x);
  for (std::uint32_t i = 0; i < 2 * channels; ++i) append<float>(bytes, 0.5f * static_cast<float>(i));
  return bytes;
}

TEST_F(MitsubaScene, MediaHaveGridsAndColours) {
  write("a.vol", volume_bytes(1));
  const ImportedScene result = scene(
      "<shape type='sphere'><medium name='interior' type='heterogeneous'><float name='scale' value='5'/>"
      "<volume name='sigma_t' type='gridvolume'><string name='filename' value='a.vol'/>"
      "<boolean name='use_grid_bbox' value='true'/><transform name='to_world'><translate "
      "x='1'/></transform></volume>"
      "<rgb name='albedo' value='.9 .5 .1'/><phase type='hg'><float name='g' "
      "value='-.25'/></phase></medium></shape>");
  ASSERT_EQ(result.scene.media_size(), 1);
  const v1::Medium& medium = result.scene.media(0);
  EXPECT_EQ(result.scene.shapes(0).interior_medium(), medium.name());
  EXPECT_EQ(medium.scale(), 5);
  EXPECT_EQ(medium.g(), -0.25f);
  EXPECT_EQ(medium.albedo().constant().rgb().b(), 0.1f);
  EXPECT_THAT(elements_of(medium.extinction().grid().world_from_grid()),
              ElementsAre(2, 0, 0, 1, 0, 4, 0, 0, 0, 0, 8, 0, 0, 0, 0, 1));
  const auto volume =
      wire::decode_volume(find_blob(result, medium.extinction().grid().blob().digest()).bytes);
  ASSERT_TRUE(volume.ok()) << volume.status();
  EXPECT_EQ(volume->nx, 2u);
  EXPECT_THAT(volume->samples, ElementsAre(0, 0.5f));
}

TEST_F(MitsubaScene, DamagedVolumesAreErrors) {
  const auto error = [&](const std::string& bytes) {
    write("a.vol", bytes);
    return error_of(
        import_xml(with_sensor("<shape type='sdfgrid'>\n<string name='filename' value='a.vol'/></shape>")));
  };
  EXPECT_THAT(error("VOL\x04" + std::string(60, 'x')), HasSubstr("scene.xml:4:1: "));
  EXPECT_THAT(error("VOL\x04" + std::string(60, 'x')), HasSubstr("version 4: expected 3"));
  EXPECT_THAT(error("VOL"), HasSubstr("cut off in its header"));
  std::string cut = volume_bytes(1);
  cut.pop_back();
  EXPECT_THAT(error(cut), HasSubstr("2 samples do not fit"));
  EXPECT_THAT(error(volume_bytes(3)), HasSubstr("a signed distance needs one channel"));
}

TEST_F(MitsubaScene, LightsStandWhereTheyShould) {
  const ImportedScene result = scene(
      "<emitter type='point'><point name='position' x='1' y='2' z='3'/><rgb name='intensity' "
      "value='4'/></emitter>"
      "<emitter type='point'><transform name='to_world'><translate y='7'/></transform></emitter>"
      "<emitter type='directional'><transform name='to_world'><rotate y='1' "
      "angle='90'/></transform></emitter>"
      "<emitter type='directional'><vector name='direction' value='0 -1 0'/></emitter>");
  EXPECT_EQ(result.scene.lights(0).point().position().z(), 3);
  EXPECT_EQ(result.scene.lights(0).point().intensity().rgb().r(), 4);
  EXPECT_EQ(result.scene.lights(1).point().position().y(), 7);
  EXPECT_NEAR(result.scene.lights(2).distant().direction().x(), 1, 1e-15);  // +z turned to +x
  EXPECT_EQ(result.scene.lights(3).distant().direction().y(), -1);
}

TEST_F(MitsubaScene, SpotsFallOffLinearly) {
  const v1::SpotLight spot =
      scene(
          "<emitter type='spot'><transform name='to_world'><lookat origin='0 5 0' target='0 0 "
          "0' up='1 0 0'/></transform>"
          "<float name='cutoff_angle' value='40'/></emitter>")
          .scene.lights(0)
          .spot();
  EXPECT_EQ(spot.falloff(), v1::SpotLight::LINEAR);
  EXPECT_EQ(spot.cone_angle_degrees(), 40);
  EXPECT_EQ(spot.cone_delta_degrees(), 10);  // the beam is three quarters wide
  EXPECT_NEAR(spot.target().y(), 4, 1e-15);
}

TEST_F(MitsubaScene, ProjectorsShineEvenly) {
  const v1::ProjectionLight projector =
      scene(
          "<emitter type='projector'><float name='fov' value='60'/><float name='scale' value='2'/>"
          "<rgb name='irradiance' value='1 2 3'/></emitter>")
          .scene.lights(0)
          .projection();
  EXPECT_TRUE(projector.even_screen());
  EXPECT_THAT(projector.fov_degrees(), FloatEq(60));
  EXPECT_THAT(projector.intensity().rgb().b(), FloatEq(static_cast<float>(6 * std::numbers::pi)));
}

TEST_F(MitsubaScene, EnvironmentsAreLatitudeAndLongitude) {
  write("sky.exr", "x");
  const v1::Light light = scene(
                              "<emitter type='envmap'><string name='filename' value='sky.exr'/>"
                              "<float name='scale' value='3'/></emitter>")
                              .scene.lights(0);
  EXPECT_EQ(light.infinite().mapping(), v1::InfiniteLight::LATITUDE_LONGITUDE);
  EXPECT_EQ(light.infinite().scale(), 3);
  EXPECT_FALSE(light.infinite().image().digest().empty());
}

TEST_F(MitsubaScene, ThingsThatAreNotSupportedAreNamed) {
  const auto error = [&](const std::string& body) { return error_of(import_xml(with_sensor(body))); };
  EXPECT_THAT(
      error("<shape type='rectangle'>\n<emitter type='directionalarea'/></shape>"),
      HasSubstr("scene.xml:4:1: emitter \"directionalarea\" is not supported on a shape: expected area"));
  EXPECT_THAT(error("<emitter type='area'/>"), HasSubstr("must stand inside a shape"));
  EXPECT_THAT(error("<shape type='hair'/>"), HasSubstr("shape \"hair\" is not supported: expected obj, ply"));
  EXPECT_THAT(error("<integrator type='vpl'/>"), HasSubstr("integrator \"vpl\" is not supported"));
  EXPECT_THAT(
      error(
          "<shape type='sphere'><medium name='interior' type='homogeneous'><phase type='rayleigh'/></medium>"
          "</shape>"),
      HasSubstr("phase \"rayleigh\" is not supported"));
}

TEST_F(MitsubaScene, HeterogeneousMediaEndAtTheBoxOfTheirExtinction) {
  const auto medium = [&](const std::string& type, const std::string& body) {
    const ImportedScene result = scene("<shape type='sphere'><medium name='interior' type='" + type + "'>" +
                                       body + "</medium></shape>");
    EXPECT_EQ(warnings_of(result), "");
    return result.scene.media_size() == 1 ? result.scene.media(0) : v1::Medium();
  };
  const std::string moved =
      "<volume name='sigma_t' type='constvolume'><float name='value' value='2'/><transform name='to_world'>"
      "<scale x='2' y='3' z='4'/><translate x='1' y='0' z='-1'/></transform></volume>";
  const v1::Medium box = medium("heterogeneous", moved);
  EXPECT_EQ(box.extinction().constant().rgb().g(), 2);
  EXPECT_THAT(elements_of(box.world_from_bounds()),
              ElementsAre(2, 0, 0, 1, 0, 3, 0, 0, 0, 0, 4, -1, 0, 0, 0, 1));
  // Turned by 45 degrees about z: the box along the axes around it, from -sqrt(1/2) to sqrt(1/2) and from 0
  // to sqrt(2).
  const v1::Medium turned = medium("heterogeneous",
                                   "<volume name='sigma_t' type='constvolume'><transform "
                                   "name='to_world'><rotate z='1' angle='45'/></transform></volume>");
  ASSERT_EQ(turned.world_from_bounds().elements_size(), 16);
  EXPECT_NEAR(turned.world_from_bounds().elements(0), std::sqrt(2), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(3), -std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(5), std::sqrt(2), 1e-6);
  EXPECT_NEAR(turned.world_from_bounds().elements(7), 0, 1e-6);
  // A colour is a volume too: the unit cube's.
  EXPECT_THAT(elements_of(medium("heterogeneous", "<rgb name='sigma_t' value='1 2 3'/>").world_from_bounds()),
              ElementsAre(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
  EXPECT_TRUE(medium("heterogeneous", "").has_world_from_bounds());
  // A homogeneous one is wherever its shape says, and the box of an albedo bounds nothing.
  EXPECT_FALSE(medium("homogeneous", moved).has_world_from_bounds());
}

TEST_F(MitsubaScene, TurnedGridsReachAsFarAsTheBoxAroundThem) {
  const auto medium = [&](const std::string& transform) {
    write("v.vol", volume_bytes(1));
    return scene(
               "<shape type='sphere'><medium name='interior' type='heterogeneous'><volume name='sigma_t' "
               "type='gridvolume'><string name='filename' value='v.vol'/><transform name='to_world'>" +
               transform + "</transform></volume></medium></shape>")
        .scene.media(0);
  };
  EXPECT_FALSE(medium("<scale value='3'/><translate x='5'/>").has_world_from_bounds());
  EXPECT_FALSE(medium("<rotate z='1' angle='90'/>").has_world_from_bounds());
  EXPECT_TRUE(medium("<rotate z='1' angle='30'/>").has_world_from_bounds());
}

}  // namespace
}  // namespace tessera::client
