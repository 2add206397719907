// The scene language itself: parameters, includes, references, places of errors.
#include "unit/import/mitsuba_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

using MitsubaLanguage = MitsubaTest;

TEST_F(MitsubaLanguage, SubstitutesTheLongestParameterName) {
  const ImportedScene result = succeed(
      import_xml("<scene version='3.0.0'><default name='s' value='1'/><default name='spp' "
                 "value='7'/><default name='s' value='9'/>"
                 "<sensor type='perspective'><sampler type='independent'><integer name='sample_count' "
                 "value='$spp'/></sampler>"
                 "<film type='hdrfilm'><integer name='width' value='$s$spp'/></film></sensor></scene>"));
  EXPECT_EQ(result.scene.settings().spp(), 7u);
  EXPECT_EQ(result.scene.film().width(), 17u);  // the first default of a name counts
}

TEST_F(MitsubaLanguage, DefinitionsOverrideDefaultsAndAreMissedWhenNothingAsks) {
  const std::string text =
      "<scene version='3.0.0'><default name='spp' value='7'/><sensor type='perspective'><sampler "
      "type='independent'>"
      "<integer name='sample_count' value='$spp'/></sampler></sensor></scene>";
  const ImportedScene result = succeed(import_xml(text, {{"spp", "16"}, {"width", "5"}}));
  EXPECT_EQ(result.scene.settings().spp(), 16u);
  EXPECT_THAT(warnings_of(result), HasSubstr("no parameter \"width\""));
  EXPECT_EQ(result.warnings.size(), 1u);
}

TEST_F(MitsubaLanguage, AnUnknownParameterIsAnErrorAtItsElement) {
  EXPECT_THAT(error_of(import_xml(
                  with_sensor("<emitter type='constant'>\n  <rgb name='radiance' value='$x'/></emitter>"))),
              HasSubstr("scene.xml:4:3: there is no parameter $x"));
}

TEST_F(MitsubaLanguage, IncludesFilesFromSearchFolders) {
  write("parts/lights/one.xml",
        "<scene version='3.0.0'><include filename='lights/two.xml'/><emitter type='constant'/></scene>");
  write("parts/lights/two.xml", "<emitter version='3.0.0' type='point'/>");
  const ImportedScene result = scene("<path value='parts'/><include filename='lights/one.xml'/>");
  ASSERT_EQ(result.scene.lights_size(), 2);
  EXPECT_TRUE(result.scene.lights(0).has_point());
  EXPECT_TRUE(result.scene.lights(1).has_infinite());
}

TEST_F(MitsubaLanguage, ReportsErrorsInIncludedFilesThere) {
  write("part.xml", "<scene version='3.0.0'>\n\n<emitter type='sun'/></scene>");
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<include filename='part.xml'/>"))),
      AllOf(HasSubstr("part.xml:3:1: emitter \"sun\" is not supported"), HasSubstr("expected point")));
  EXPECT_THAT(error_of(import_xml(with_sensor("<include filename='none.xml'/>"))),
              HasSubstr("scene.xml:3:1: there is no file \"none.xml\""));
}

TEST_F(MitsubaLanguage, BoundsIncludesAndNesting) {
  for (int i = 0; i < 20; ++i) {
    write("level" + std::to_string(i) + ".xml",
          "<scene version='3.0.0'><include filename='level" + std::to_string(i + 1) + ".xml'/></scene>");
  }
  EXPECT_THAT(error_of(import_xml(with_sensor("<include filename='level0.xml'/>"))),
              HasSubstr("files are included more than 15 deep"));
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "<bsdf type='twosided'>";
  for (int i = 0; i < 5000; ++i) deep += "</bsdf>";
  EXPECT_THAT(error_of(import_xml(with_sensor(deep))), HasSubstr("nested more than 100 deep"));
  // Chains of references nest objects too.
  std::string chain = "<bsdf type='diffuse' id='b0'/>";
  for (int i = 1; i < 5000; ++i) {
    chain += "<bsdf type='twosided' id='b" + std::to_string(i) + "'><ref id='b" + std::to_string(i - 1) +
             "'/></bsdf>";
  }
  EXPECT_THAT(error_of(import_xml(with_sensor(chain))), HasSubstr("nested more than 150 deep"));
}

TEST_F(MitsubaLanguage, ResolvesReferencesBackwardsForwardsAndThroughAliases) {
  const ImportedScene result = scene(
      "<bsdf type='diffuse' id='a'><ref name='reflectance' id='t'/></bsdf><alias id='a' as='b'/>"
      "<texture type='checkerboard' id='t'/>"
      "<shape type='rectangle'><ref id='b'/></shape><shape type='sphere'><ref id='a' name='bsdf'/></shape>");
  EXPECT_EQ(result.scene.shapes(0).material(), "a");
  EXPECT_EQ(result.scene.shapes(1).material(), "a");
  EXPECT_EQ(result.scene.materials_size(), 1);
  EXPECT_EQ(result.scene.materials(0).diffuse().reflectance().texture(), "t");
  EXPECT_TRUE(result.warnings.empty()) << warnings_of(result);
}

TEST_F(MitsubaLanguage, RefusesReferencesThatLeadNowhereOrInCircles) {
  EXPECT_THAT(error_of(import_xml(with_sensor("<shape type='sphere'>\n<ref id='none'/></shape>"))),
              HasSubstr("scene.xml:4:1: there is no object with the id \"none\""));
  EXPECT_THAT(error_of(import_xml(with_sensor("<bsdf type='twosided' id='a'><ref id='b'/></bsdf>\n"
                                              "<bsdf type='twosided' id='b'><ref id='a'/></bsdf>"))),
              HasSubstr("contains itself"));
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<bsdf type='diffuse' id='a'/>\n<bsdf type='diffuse' id='a'/>"))),
      AllOf(HasSubstr("scene.xml:4:1: the id \"a\" is taken"), HasSubstr("scene.xml:3")));
}

TEST_F(MitsubaLanguage, BoundsIndicesOfRefraction) {
  const auto error_of_bsdf = [&](const std::string& bsdf) {
    return error_of(import_xml(with_sensor("<shape type='sphere'>\n" + bsdf + "</shape>")));
  };
  EXPECT_THAT(error_of_bsdf("<bsdf type='principled'><float name='eta' value='0'/></bsdf>"),
              HasSubstr("scene.xml:4:1: bsdf \"principled\": an index of refraction of 0 is not between"));
  EXPECT_THAT(error_of_bsdf("<bsdf type='dielectric'><float name='int_ior' value='1e4'/>"
                            "<float name='ext_ior' value='1e-4'/></bsdf>"),
              HasSubstr("an index of refraction of 1e+08"));
}

TEST_F(MitsubaLanguage, ReportsSeveralErrorsAtOnce) {
  const std::string message = error_of(import_xml(with_sensor(
      "<emitter type='point'>\n<float name='a' value='x'/>\n<rgb name='intensity' value='1 2'/>\n<foo/>\n"
      "<integer name='i' value='1.5'/>\n<float value='1'/>\n<string name='s' value='1' "
      "z='2'/>\n</emitter>")));
  EXPECT_THAT(message, HasSubstr(":4:1: expected a number from -1e18 to 1e18, found \"x\""));
  EXPECT_THAT(message, HasSubstr(":5:1: expected one or three numbers, found \"1 2\""));
  EXPECT_THAT(message, HasSubstr(":6:1: <foo> is not an element of the scene language"));
  EXPECT_THAT(message, HasSubstr(":7:1: expected an integer, found \"1.5\""));
  EXPECT_THAT(message, HasSubstr(":8:1: <float> needs the attribute \"name\""));
  EXPECT_THAT(message, HasSubstr(":9:1: <string> has no attribute \"z\""));
}

TEST_F(MitsubaLanguage, RefusesWhatIsNoScene) {
  EXPECT_THAT(error_of(import_xml("<scene version='3.0.0'>\n<shape")), HasSubstr("scene.xml:2"));
  EXPECT_THAT(error_of(import_xml("<scene/>")), HasSubstr("needs the attribute \"version\""));
  EXPECT_THAT(error_of(import_xml("<scene version='new'/>")), HasSubstr("\"new\" is not a version"));
  EXPECT_THAT(error_of(import_xml("<bsdf version='3.0.0' type='diffuse'/>")), HasSubstr("expected <scene>"));
  EXPECT_THAT(error_of(import_xml("")), HasSubstr("not well-formed"));
  EXPECT_THAT(error_of(import_xml("<scene version='3.0.0'/>")), HasSubstr("no sensor"));
}

TEST_F(MitsubaLanguage, WarnsOfWhatNothingAsksFor) {
  const ImportedScene result =
      scene("<shape type='sphere'>\n<float name='size' value='1'/><bsdf type='diffuse'/></shape>");
  EXPECT_THAT(warnings_of(result),
              HasSubstr("scene.xml:4:1: parameter \"size\" of shape \"sphere\" is not known"));
}

TEST_F(MitsubaLanguage, ConvertsNamesOfOldVersions) {
  const ImportedScene result = succeed(import_xml(
      "<scene version='0.6.0'><sensor type='perspective'><float name='nearClip' value='0.5'/><transform "
      "name='toWorld'>"
      "<lookAt origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></sensor>"
      "<shape type='rectangle'><bsdf type='diffuse'><texture type='checkerboard' name='diffuseReflectance'>"
      "<float name='uscale' value='3'/><float name='voffset' "
      "value='0.25'/></texture></bsdf></shape></scene>"));
  EXPECT_TRUE(result.warnings.empty()) << warnings_of(result);
  EXPECT_FLOAT_EQ(result.scene.camera().near_clip(), 0.5f);
  EXPECT_DOUBLE_EQ(elements_of(result.scene.camera().world_from_camera())[11], 5);
  ASSERT_EQ(result.scene.textures_size(), 1);
  // Checks are half a unit wide: everything counts twice.
  EXPECT_FLOAT_EQ(result.scene.textures(0).checkerboard().mapping().scale_u(), 6);
  EXPECT_FLOAT_EQ(result.scene.textures(0).checkerboard().mapping().offset_v(), 0.5f);
}

TEST_F(MitsubaLanguage, AppliesTransformationsInTheOrderOfTheFile) {
  const ImportedScene result = scene(
      "<shape type='rectangle'><transform name='to_world'><scale x='2' z='3'/><rotate z='1' angle='90'/>"
      "<translate value='1, 2, 3'/></transform></shape>"
      "<shape type='rectangle'><transform name='to_world'><matrix value='0 1 0 1 0 0 0 0 1'/><scale "
      "value='2'/>"
      "</transform></shape>");
  // Scaled x becomes y by the rotation; -y becomes x.
  const std::vector<double> expected = {0, -1, 0, 1, 2, 0, 0, 2, 0, 0, 3, 3, 0, 0, 0, 1};
  const std::vector<double> first = elements_of(result.scene.shapes(0).world_from_object());
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(first[i], expected[i], 1e-15) << i;
  EXPECT_THAT(elements_of(result.scene.shapes(1).world_from_object()),
              ElementsAre(0, 2, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1));
}

TEST_F(MitsubaLanguage, MatricesAndViewsActAfterWhatStandsBeforeThem) {
  const ImportedScene result = scene(
      "<shape type='rectangle'><transform name='to_world'><translate x='1'/>"
      "<matrix value='0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1'/></transform></shape>"
      "<shape type='rectangle'><transform name='to_world'><translate z='2'/>"
      "<lookat origin='0 0 5' target='1 0 5' up='0 0 1'/></transform></shape>");
  // A quarter turn about z takes the place (1, 0, 0) to (0, 1, 0).
  const std::vector<double> turned = elements_of(result.scene.shapes(0).world_from_object());
  EXPECT_THAT(std::vector<double>({turned[3], turned[7], turned[11]}), ElementsAre(0, 1, 0));
  // A point 2 before the eye is 2 along its view, which is x.
  const std::vector<double> viewed = elements_of(result.scene.shapes(1).world_from_object());
  EXPECT_NEAR(viewed[3], 2, 1e-12);
  EXPECT_NEAR(viewed[7], 0, 1e-12);
  EXPECT_NEAR(viewed[11], 5, 1e-12);
}

TEST_F(MitsubaLanguage, RefusesTransformationsThatAreNone) {
  const std::string message = error_of(import_xml(with_sensor(
      "<shape type='sphere'><transform name='to_world'>\n<rotate angle='3'/>\n<matrix value='1 "
      "2'/>\n<turn/>\n"
      "<lookat origin='0 0 0' target='0 0 0'/>\n<scale value='1' x='2'/>\n</transform></shape>")));
  EXPECT_THAT(message, HasSubstr(":4:1: the axis of the rotation is zero"));
  EXPECT_THAT(message, HasSubstr(":5:1: a matrix has 16 or 9 numbers, found 2"));
  EXPECT_THAT(message, HasSubstr(":6:1: <turn> is not a transformation"));
  EXPECT_THAT(message, HasSubstr(":7:1: lookat: origin and target coincide"));
  EXPECT_THAT(message, HasSubstr(":8:1: \"value\" and x, y, z exclude each other"));
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<shape type='sphere'><transform name='to_world'><scale value='0'/>"
                                      "</transform></shape>"))),
      HasSubstr("its transformation is singular"));
}

}  // namespace
}  // namespace tessera::client
