// Colours, textures and materials of Mitsuba scenes.
#include "unit/import/mitsuba_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

using MitsubaValues = MitsubaTest;

void expect_rgb(const v1::Spectrum& spectrum, double r, double g, double b, double tolerance) {
  ASSERT_TRUE(spectrum.has_rgb() || spectrum.has_in_rgb()) << spectrum.ShortDebugString();
  const v1::Rgb& rgb = spectrum.has_in_rgb() ? spectrum.in_rgb() : spectrum.rgb();
  EXPECT_NEAR(rgb.r(), r, tolerance);
  EXPECT_NEAR(rgb.g(), g, tolerance);
  EXPECT_NEAR(rgb.b(), b, tolerance);
}

// Rounding of a float near one.
constexpr double kFloat = 1e-6;
// 1000 samples, weighted as 1000 steps of 0.47 nm though they span 999: one part in 1000. The curves
// themselves are linear between their own samples and so summed exactly enough.
constexpr double kSteps = 2e-3;

TEST_F(MitsubaValues, AnEmittedUniformSpectrumIsNotGrey) {
  const ImportedScene result = scene(
      "<emitter type='constant'><spectrum name='radiance' value='2'/></emitter>"
      "<emitter type='constant'><rgb name='radiance' value='2'/></emitter>"
      "<emitter type='constant'><float name='radiance' value='2'/></emitter><emitter type='constant'/>"
      "<emitter type='constant'><spectrum name='radiance' value='360:2, 830:2'/></emitter>");
  // Rows of the XYZ to Rec.709 matrix, summed.
  expect_rgb(result.scene.lights(0).infinite().radiance(), 2 * 1.204794, 2 * 0.948291, 2 * 0.908916, kFloat);
  expect_rgb(result.scene.lights(1).infinite().radiance(), 2, 2, 2, 0);
  expect_rgb(result.scene.lights(2).infinite().radiance(), 2, 2, 2, 0);
  expect_rgb(result.scene.lights(3).infinite().radiance(), 1, 1, 1, 0);
  expect_rgb(result.scene.lights(4).infinite().radiance(), 2 * 1.204794, 2 * 0.948291, 2 * 0.908916,
             2 * 1.2 * kSteps);
}

TEST_F(MitsubaValues, AReflectedUniformSpectrumIsGrey) {
  const auto reflectance = [&](const std::string& spectrum) {
    return material("<bsdf type='diffuse'><spectrum name='reflectance' " + spectrum + "/></bsdf>")
        .diffuse()
        .reflectance()
        .constant();
  };
  expect_rgb(reflectance("value='0.25'"), 0.25, 0.25, 0.25, 0);
  expect_rgb(reflectance("value='300:0.5 900:0.5'"), 0.5, 0.5, 0.5, kSteps);
  write("grey.spd", "# comment\n300 0.5\n\n900 0.5 # end\n");
  expect_rgb(reflectance("filename='grey.spd'"), 0.5, 0.5, 0.5, kSteps);
  // Nothing beyond the samples: all that is left is red.
  const v1::Spectrum red = reflectance("value='630:1 830:1'");
  EXPECT_GT(red.in_rgb().r(), 0.2);
  EXPECT_LT(red.in_rgb().g(), 0.05);
  EXPECT_EQ(red.in_rgb().b(), 0);
  // Jobs of wavelengths get the curve.
  EXPECT_THAT(red.sampled().wavelengths_nm(), testing::ElementsAre(629.99f, 630, 830));
  EXPECT_THAT(red.sampled().values(), testing::ElementsAre(0, 1, 1));
}

TEST_F(MitsubaValues, SpectraOfPluginsAreCurves) {
  const auto radiance = [&](const std::string& spectrum) {
    return scene("<emitter type='constant'>" + spectrum + "</emitter>").scene.lights(0).infinite().radiance();
  };
  const v1::Spectrum regular = radiance(
      "<spectrum name='radiance' type='regular'><float name='wavelength_min' value='400'/>"
      "<float name='wavelength_max' value='700'/><string name='values' value='1, 2, 4'/></spectrum>");
  EXPECT_THAT(regular.sampled().wavelengths_nm(), testing::ElementsAre(399.99f, 400, 550, 700, 700.01f));
  EXPECT_THAT(regular.sampled().values(), testing::ElementsAre(0, 1, 2, 4, 0));
  const v1::Spectrum irregular = radiance(
      "<spectrum name='radiance' type='irregular'><string name='wavelengths' value='400 550 700'/>"
      "<string name='values' value='1 2 4'/></spectrum>");
  EXPECT_EQ(irregular.ShortDebugString(), regular.ShortDebugString());
  EXPECT_EQ(radiance("<spectrum name='radiance' value='400:1, 550:2, 700:4'/>").ShortDebugString(),
            regular.ShortDebugString());
  // 5000 K: 2 h c^2 / l^5 / (exp(h c / (l k T)) - 1) at 560 nm is 12762.2 W / (m^2 sr nm).
  const v1::Spectrum black = radiance(
      "<spectrum name='radiance' type='blackbody'><float name='temperature' value='5000'/></spectrum>");
  ASSERT_EQ(black.sampled().values_size(), 471);
  EXPECT_EQ(black.sampled().wavelengths_nm(200), 560);
  EXPECT_NEAR(black.sampled().values(200), 12762.2, 0.5);
  EXPECT_GT(black.in_rgb().r(), black.in_rgb().b());
}

TEST_F(MitsubaValues, DaylightIsTheColourItself) {
  const ImportedScene result = scene(
      "<emitter type='constant'><spectrum name='radiance' type='d65'><float name='scale' "
      "value='3'/></spectrum>"
      "</emitter>");
  EXPECT_FALSE(result.scene.lights(0).infinite().radiance().has_sampled());
  expect_rgb(result.scene.lights(0).infinite().radiance(), 3, 3, 3, 0);
}

TEST_F(MitsubaValues, FaultsOfSpectraAreToldAtTheirPlaces) {
  const auto fault = [&](const std::string& spectrum) {
    return error_of(import_xml(with_sensor("<emitter type='constant'>\n" + spectrum + "</emitter>")));
  };
  EXPECT_THAT(fault("<spectrum name='radiance' value='400:1, 500:-2'/>"),
              AllOf(HasSubstr("the value at 500 nm is -2, which is negative"), HasSubstr("scene.xml:4:1: ")));
  EXPECT_THAT(fault("<spectrum name='radiance' value='500:1, 400:2'/>"), HasSubstr("must ascend"));
  EXPECT_THAT(fault("<spectrum name='radiance' value='400:nan, 500:2'/>"),
              HasSubstr("expected wavelength:value"));
  EXPECT_THAT(fault("<spectrum name='radiance' value='0.4:1, 0.7:2'/>"),
              HasSubstr("none from 300 to 1000 nm"));
  EXPECT_THAT(fault("<spectrum name='radiance' type='irregular'><string name='wavelengths' value='400 500'/>"
                    "<string name='values' value='1 2 3'/></spectrum>"),
              HasSubstr("2 wavelengths and 3 values"));
  EXPECT_THAT(fault("<spectrum name='radiance' type='regular'/>"), HasSubstr("a list of numbers"));
  EXPECT_THAT(fault("<spectrum name='radiance' type='blackbody'><float name='temperature' value='-1'/>"
                    "</spectrum>"),
              HasSubstr("a temperature above 0"));
}

TEST_F(MitsubaValues, MetalsAreWhatMitsubaMakesOfThem) {
  const v1::ConductorMaterial silver =
      material("<bsdf type='conductor'><string name='material' value='Ag'/></bsdf>").conductor();
  // Numbers of another program that follows ior_from_file of Mitsuba 3; float tables on both sides.
  expect_rgb(silver.eta().constant(), 0.155276194, 0.116727956, 0.138387635, 2e-5);
  expect_rgb(silver.k().constant(), 4.828354359, 3.122222424, 2.146901131, 2e-4);
}

TEST_F(MitsubaValues, ColoursThatReflectMoreThanAllAreClamped) {
  ImportedScene whole;
  const v1::Material m =
      material("<bsdf type='diffuse'><rgb name='reflectance' value='0.5 1.5 -1'/></bsdf>", &whole);
  expect_rgb(m.diffuse().reflectance().constant(), 0.5, 1, 0, 0);
  EXPECT_THAT(warnings_of(whole),
              HasSubstr("parameter \"reflectance\" of bsdf \"diffuse\": a component is outside"));
}

TEST_F(MitsubaValues, ConstantTexturesAreColours) {
  const auto reflectance = [&](const std::string& texture) {
    return material("<bsdf type='diffuse'>" + texture + "</bsdf>").diffuse().reflectance().constant();
  };
  expect_rgb(
      reflectance("<texture name='reflectance' type='uniform'><float name='value' value='.3'/></texture>"),
      .3, .3, .3, kFloat);
  expect_rgb(
      reflectance("<spectrum name='reflectance' type='srgb'><rgb name='color' value='.1 .2 .3'/></spectrum>"),
      .1, .2, .3, kFloat);
  expect_rgb(
      reflectance(
          "<texture name='reflectance' type='rawconstant'><vector name='value' value='.1 .2 .3'/></texture>"),
      .1, .2, .3, kFloat);
}

TEST_F(MitsubaValues, BitmapsHaveTheirVTurnedOver) {
  write("a.png", "x");
  ImportedScene whole;
  const v1::Material m = material(
      "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'><string name='filename' value='a.png'/>"
      "<transform name='to_uv'><matrix value='2 3 0 5 7 11 0 13 0 0 1 0 0 0 0 1'/></transform>"
      "<string name='wrap_mode' value='mirror'/><string name='filter_type' "
      "value='nearest'/></texture></bsdf>",
      &whole);
  const v1::ImageTexture image = find_texture(whole, m.diffuse().reflectance().texture()).image();
  // u' = 2u + 3v + 5 and v' = 7u + 11v + 13 down the image, which is 1 - v' upwards.
  const v1::UvMapping& mapping = image.mapping();
  EXPECT_EQ(mapping.scale_u(), 2);
  EXPECT_EQ(mapping.u_from_v(), 3);
  EXPECT_EQ(mapping.offset_u(), 5);
  EXPECT_EQ(mapping.v_from_u(), -7);
  EXPECT_EQ(mapping.scale_v(), -11);
  EXPECT_EQ(mapping.offset_v(), -12);
  EXPECT_EQ(image.wrap(), v1::ImageTexture::MIRROR);
  EXPECT_EQ(image.filter(), v1::ImageTexture::NEAREST);
  EXPECT_EQ(image.encoding(), v1::ImageTexture::SRGB);
}

TEST_F(MitsubaValues, RawBitmapsAndFloatBitmapsAreLinear) {
  write("a.png", "x");
  write("b.exr", "x");
  ImportedScene whole;
  material(
      "<bsdf type='roughconductor'><texture name='alpha' type='bitmap'><string name='filename' "
      "value='a.png'/>"
      "<boolean name='raw' value='true'/></texture><texture name='specular_reflectance' type='bitmap'>"
      "<string name='filename' value='b.exr'/></texture></bsdf>",
      &whole);
  ASSERT_EQ(whole.scene.textures_size(), 2);
  for (const v1::Texture& texture : whole.scene.textures()) {
    EXPECT_EQ(texture.image().encoding(),
              texture.image().image().path() == "a.png" ? v1::ImageTexture::LINEAR : v1::ImageTexture::AUTO);
  }
}

TEST_F(MitsubaValues, CheckerboardsTradeTheirColoursWhenAskedForANumber) {
  ImportedScene whole;
  const v1::Material m = material(
      "<bsdf type='principled'><texture name='base_color' type='checkerboard'/>"
      "<texture name='roughness' type='checkerboard'/></bsdf>",
      &whole);
  const auto color = find_texture(whole, m.principled().base_color().texture()).checkerboard();
  const auto number = find_texture(whole, m.principled().roughness().texture()).checkerboard();
  // Mitsuba's eval gives color0 (default 0.4) where both coordinates are in the same half of a cell; its
  // eval_1, color1.
  expect_rgb(color.even().constant(), 0.4, 0.4, 0.4, kFloat);
  expect_rgb(color.odd().constant(), 0.2, 0.2, 0.2, kFloat);
  EXPECT_FLOAT_EQ(number.even().constant().constant(), 0.2f);
  EXPECT_FLOAT_EQ(number.odd().constant().constant(), 0.4f);
  EXPECT_EQ(color.mapping().scale_u(), 2);
}

TEST_F(MitsubaValues, DefaultsAreThoseOfMitsuba) {
  const v1::Material rough = material("<bsdf type='roughdielectric'/>");
  EXPECT_NEAR(rough.dielectric().eta().constant(), 1.5046 / 1.000277, kFloat);
  EXPECT_EQ(rough.dielectric().roughness().distribution(), v1::Roughness::BECKMANN);
  EXPECT_TRUE(rough.dielectric().roughness().separable_masking());
  EXPECT_TRUE(rough.dielectric().roughness().has_multiple_scattering() &&
              !rough.dielectric().roughness().multiple_scattering());
  EXPECT_FLOAT_EQ(rough.dielectric().roughness().u().constant(), 0.1f);
  EXPECT_FALSE(rough.one_sided());
  const v1::Material plastic = material("<bsdf type='plastic'/>");
  EXPECT_NEAR(plastic.plastic().eta().constant(), 1.49 / 1.000277, kFloat);
  EXPECT_FALSE(plastic.plastic().has_roughness());
  EXPECT_TRUE(plastic.one_sided());
  const v1::Material mirror = material("<bsdf type='conductor'/>");
  expect_rgb(mirror.conductor().eta().constant(), 0, 0, 0, 0);
  expect_rgb(mirror.conductor().k().constant(), 1, 1, 1, 0);
  EXPECT_FLOAT_EQ(material("<bsdf type='principledthin'/>").principled().eta(), 1.5f);
  EXPECT_TRUE(material("<bsdf type='thindielectric'/>").thin_dielectric().passes_straight());
  EXPECT_TRUE(material("<bsdf type='null'/>").has_interface());
}

TEST_F(MitsubaValues, IndicesOfRefractionHaveNames) {
  const v1::Material m = material(
      "<bsdf type='dielectric'><string name='int_ior' value='Diamond'/><float name='ext_ior' "
      "value='1.5'/></bsdf>");
  EXPECT_NEAR(m.dielectric().eta().constant(), 2.419 / 1.5, kFloat);
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<shape type='sphere'><bsdf type='dielectric'>\n"
                                      "<string name='int_ior' value='jelly'/></bsdf></shape>"))),
      HasSubstr(
          "scene.xml:4:1: parameter \"int_ior\" of bsdf \"dielectric\": \"jelly\" is not a known substance"));
}

TEST_F(MitsubaValues, RoughnessMayDifferAlongTheTangents) {
  const v1::Roughness r =
      material(
          "<bsdf type='roughconductor'><float name='alpha_u' value='.1'/><float name='alpha_v' value='.4'/>"
          "<string name='distribution' value='ggx'/></bsdf>")
          .conductor()
          .roughness();
  EXPECT_FLOAT_EQ(r.u().constant(), 0.1f);
  EXPECT_FLOAT_EQ(r.v().constant(), 0.4f);
  EXPECT_EQ(r.distribution(), v1::Roughness::GGX);
  EXPECT_THAT(error_of(import_xml(with_sensor("<shape type='sphere'><bsdf type='roughconductor'>"
                                              "<float name='alpha_u' value='.1'/></bsdf></shape>"))),
              HasSubstr("either alpha, or both alpha_u and alpha_v"));
}

TEST_F(MitsubaValues, NormalMapsMayBeAnyTexture) {
  const auto mapped = [&](const std::string& texture, ImportedScene& whole) {
    return material("<bsdf type='normalmap'>" + texture + "<bsdf type='diffuse'/></bsdf>", &whole);
  };
  ImportedScene whole;
  const v1::Material checkered = mapped(
      "<texture type='checkerboard' name='normalmap'><rgb name='color0' value='.5 .5 1'/>"
      "<rgb name='color1' value='.2 .5 2'/></texture>",
      whole);
  EXPECT_FALSE(checkered.has_normal_map());
  EXPECT_TRUE(checkered.bends_softly());
  const v1::CheckerboardTexture board = find_texture(whole, checkered.normal_texture()).checkerboard();
  EXPECT_EQ(board.even().constant().rgb().b(), 1);
  EXPECT_EQ(board.odd().constant().rgb().b(), 2) << "normals are no reflectances";
  EXPECT_EQ(warnings_of(whole), "");
  const v1::Material even = mapped(
      "<texture type='rawconstant' name='normalmap'><rgb name='value' value='.4 .5 1'/></texture>", whole);
  EXPECT_FLOAT_EQ(find_texture(whole, even.normal_texture()).constant().rgb().r(), 0.4f);
  const v1::Material meshes = mapped(
      "<texture type='mesh_attribute' name='normalmap'><string name='name' value='vertex_n'/></texture>",
      whole);
  EXPECT_EQ(find_texture(whole, meshes.normal_texture()).mesh_attribute().attribute(), "vertex_n");
}

TEST_F(MitsubaValues, BumpMapsOfOneHeightAreLeftOutWithAWarning) {
  for (const char* texture : {"<texture type='rawconstant'><float name='value' value='2'/></texture>",
                              "<texture type='uniform'><float name='value' value='2'/></texture>"}) {
    ImportedScene whole;
    const v1::Material m =
        material(std::string("<bsdf type='bumpmap'>") + texture + "<bsdf type='diffuse'/></bsdf>", &whole);
    EXPECT_TRUE(m.has_diffuse());
    EXPECT_FALSE(m.has_displacement() || m.bends_softly());
    EXPECT_THAT(warnings_of(whole), HasSubstr("a bumpmap of the same height everywhere bends nothing"));
  }
}

TEST_F(MitsubaValues, AllNamedConductors) {
  for (const char* name : {"Ag", "a-C", "W", "V_palik", "Se-e"}) {
    const v1::Material m =
        material(std::string("<bsdf type='conductor'><string name='material' value='") + name + "'/></bsdf>");
    const v1::Spectrum& eta = m.conductor().eta().constant();
    EXPECT_GT(eta.has_in_rgb() ? eta.in_rgb().g() : eta.rgb().g(), 0) << name;
    EXPECT_EQ(eta.has_sampled(), std::string(name) == "Ag") << name;
  }
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<shape type='sphere'><bsdf type='conductor'><string name='material' "
                                      "value='Xx'/></bsdf></shape>"))),
      AllOf(HasSubstr("no measurements of \"Xx\""), HasSubstr("Na_palik")));
  EXPECT_THAT(
      error_of(import_xml(with_sensor("<shape type='sphere'><bsdf type='conductor'><string name='material' "
                                      "value='CuZm'/></bsdf></shape>"))),
      HasSubstr("did you mean 'CuZn'?"));
}

TEST_F(MitsubaValues, WrappersBecomeFieldsOfWhatTheyWrap) {
  write("n.png", "x");
  ImportedScene whole;
  const v1::Material m = material(
      "<bsdf type='mask'><float name='opacity' value='.25'/><bsdf type='twosided'><bsdf type='bumpmap'>"
      "<float name='scale' value='3'/><texture type='checkerboard' name='whatever'/><bsdf type='normalmap'>"
      "<texture type='bitmap' name='normalmap'><string name='filename' value='n.png'/><boolean name='raw' "
      "value='true'/>"
      "</texture><bsdf type='plastic'/></bsdf></bsdf></bsdf></bsdf>",
      &whole);
  EXPECT_TRUE(m.has_plastic());
  EXPECT_FALSE(m.one_sided());
  EXPECT_FLOAT_EQ(m.opacity().constant(), 0.25f);
  EXPECT_EQ(m.normal_map().image().path(), "n.png");
  EXPECT_EQ(m.normal_map().encoding(), v1::ImageTexture::LINEAR);
  const v1::Texture displacement = find_texture(whole, m.displacement().texture());
  EXPECT_EQ(displacement.scale().factor().constant().constant(), 3);
  EXPECT_TRUE(find_texture(whole, displacement.scale().value().texture()).has_checkerboard());
  EXPECT_TRUE(whole.warnings.empty()) << warnings_of(whole);
}

TEST_F(MitsubaValues, TwoNestedMasksMultiply) {
  ImportedScene whole;
  const v1::Material m = material(
      "<bsdf type='mask'><float name='opacity' value='.25'/><bsdf type='mask'><bsdf "
      "type='diffuse'/></bsdf></bsdf>",
      &whole);
  const v1::Texture product = find_texture(whole, m.opacity().texture());
  EXPECT_EQ(product.scale().value().constant().constant(), 0.25f);
  EXPECT_EQ(product.scale().factor().constant().constant(), 0.5f);  // the default
}

TEST_F(MitsubaValues, TwoSidedMayHaveTwoMaterials) {
  ImportedScene whole;
  const v1::Material front =
      material("<bsdf type='twosided'><bsdf type='plastic'/><bsdf type='diffuse' id='rear'/></bsdf>", &whole);
  EXPECT_TRUE(front.has_plastic());
  EXPECT_TRUE(front.one_sided());
  EXPECT_EQ(front.back(), "rear");
  EXPECT_TRUE(find_material(whole, "rear").has_diffuse());
}

TEST_F(MitsubaValues, BlendsMixTheSecondIn) {
  ImportedScene whole;
  const v1::Material m = material(
      "<bsdf type='blendbsdf'><float name='weight' value='.75'/><bsdf type='diffuse' id='a'/>"
      "<bsdf type='twosided'><bsdf type='conductor' id='b'/></bsdf></bsdf>",
      &whole);
  EXPECT_EQ(m.mix().a(), "a");
  EXPECT_EQ(m.mix().b(), "b");
  EXPECT_FLOAT_EQ(m.mix().amount().constant(), 0.75f);
  EXPECT_TRUE(find_material(whole, "a").one_sided());
  EXPECT_FALSE(find_material(whole, "b").one_sided());
}

TEST_F(MitsubaValues, OneBsdfInTwoWrappersIsTwoMaterials) {
  const ImportedScene result = scene(
      "<bsdf type='diffuse' id='d'/><shape type='sphere'><ref id='d'/></shape><shape type='sphere'><bsdf "
      "type='twosided'>"
      "<ref id='d'/></bsdf></shape><shape type='sphere'><ref id='d'/></shape>");
  ASSERT_EQ(result.scene.materials_size(), 2);
  EXPECT_NE(result.scene.shapes(0).material(), result.scene.shapes(1).material());
  EXPECT_EQ(result.scene.shapes(0).material(), result.scene.shapes(2).material());
}

TEST_F(MitsubaValues, PrincipledThatTransmitsHasTwoSides) {
  EXPECT_TRUE(material("<bsdf type='principled'/>").one_sided());
  const v1::Material m = material(
      "<bsdf type='principled'><float name='spec_trans' value='.5'/><float name='eta' value='1'/></bsdf>");
  EXPECT_FALSE(m.one_sided());
  EXPECT_FLOAT_EQ(m.principled().eta(), 1.001f);
}

TEST_F(MitsubaValues, UnknownBsdfsAreErrorsWithChoices) {
  EXPECT_THAT(error_of(import_xml(with_sensor("<shape type='sphere'>\n<bsdf type='velvet'/></shape>"))),
              HasSubstr("scene.xml:4:1: bsdf \"velvet\" is not supported: expected diffuse, dielectric"));
}

TEST_F(MitsubaValues, PhongHasTheDefaultsOfMitsuba06) {
  const v1::PhongMaterial plain = material("<bsdf type='phong'/>").phong();
  expect_rgb(plain.diffuse().constant(), 0.5, 0.5, 0.5, kFloat);
  expect_rgb(plain.specular().constant(), 0.2, 0.2, 0.2, kFloat);
  EXPECT_EQ(plain.exponent().constant(), 30);
  EXPECT_EQ(
      material("<bsdf type='phong'><float name='exponent' value='90'/></bsdf>").phong().exponent().constant(),
      90);
}

}  // namespace
}  // namespace tessera::client
