// Materials, textures, spectra and lights of pbrt files.
#include <map>
#include <numbers>

#include "spectra/color/rgb_space.h"
#include "spectra/color/tristimulus.h"
#include "spectra/curve.h"
#include "spectra/light/daylight.h"
#include "spectra/light/planck.h"
#include "spectra/rgb/pbrt_luminance.h"
#include "unit/import/import_fixture.h"

namespace tessera::client {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class PbrtValues : public ImportTest {
 protected:
  /// The material of a sphere that has it.
  v1::Material material(const std::string& text) {
    const ImportedScene scene = world("Material " + text + "\nShape \"sphere\"");
    warnings_ = warnings_of(scene);
    EXPECT_EQ(scene.scene.materials_size(), 1);
    return scene.scene.materials_size() > 0 ? scene.scene.materials(0) : v1::Material();
  }

  v1::Light light(const std::string& text) {
    const ImportedScene scene = world(text);
    warnings_ = warnings_of(scene);
    EXPECT_EQ(scene.scene.lights_size(), 1);
    return scene.scene.lights_size() > 0 ? scene.scene.lights(0) : v1::Light();
  }

  std::string warnings_;
};

TEST_F(PbrtValues, MaterialsHavePbrtsDefaults) {
  EXPECT_FLOAT_EQ(material("\"diffuse\"").diffuse().reflectance().constant().constant(), 0.5f);

  const v1::ConductorMaterial copper = material("\"conductor\"").conductor();
  EXPECT_EQ(copper.eta().constant().sampled().values_size(), 56);
  EXPECT_FLOAT_EQ(copper.eta().constant().sampled().values(39), 0.826f);  // copper at 563.6 nm
  EXPECT_TRUE(copper.roughness().remap());
  EXPECT_TRUE(copper.roughness().has_multiple_scattering() && !copper.roughness().multiple_scattering());
  EXPECT_EQ(copper.roughness().u().constant(), 0);

  EXPECT_FLOAT_EQ(material("\"dielectric\"").dielectric().eta().constant(), 1.5f);
  EXPECT_FLOAT_EQ(material("\"thindielectric\"").thin_dielectric().eta().constant(), 1.5f);

  const v1::CoatedDiffuseMaterial coated = material("\"coateddiffuse\"").coated_diffuse();
  EXPECT_FLOAT_EQ(coated.reflectance().constant().constant(), 0.5f);
  EXPECT_FLOAT_EQ(coated.eta().constant(), 1.5f);
  EXPECT_FLOAT_EQ(coated.thickness(), 0.01f);
  EXPECT_FALSE(coated.has_albedo());

  const v1::DiffuseTransmissionMaterial sheet = material("\"diffusetransmission\"").diffuse_transmission();
  EXPECT_FLOAT_EQ(sheet.reflectance().constant().constant(), 0.25f);
  EXPECT_FLOAT_EQ(sheet.transmittance().constant().constant(), 0.25f);
  EXPECT_EQ(warnings_, "");
}

TEST_F(PbrtValues, RoughnessFallsBackToTheCommonOne) {
  const v1::Roughness r =
      material(
          "\"dielectric\" \"float roughness\" .4 \"float vroughness\" .2 \"bool remaproughness\" "
          "false \"spectrum eta\" "
          "\"glass-SF11\"")
          .dielectric()
          .roughness();
  EXPECT_FLOAT_EQ(r.u().constant(), 0.4f);
  EXPECT_FLOAT_EQ(r.v().constant(), 0.2f);
  EXPECT_FALSE(r.remap());
  EXPECT_EQ(warnings_, "");
}

TEST_F(PbrtValues, NormalMapsMayBeTextures) {
  const ImportedScene scene = world(
      "Texture \"waves\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ .4 .5 1 ] \"rgb tex2\" [ .6 .5 1 ]\n"
      "Material \"diffuse\" \"texture normalmap\" \"waves\"\nShape \"sphere\"");
  ASSERT_EQ(scene.scene.materials_size(), 1);
  EXPECT_EQ(scene.scene.materials(0).normal_texture(), "waves");
  EXPECT_FALSE(scene.scene.materials(0).has_normal_map());
  EXPECT_EQ(warnings_of(scene), "");
  EXPECT_THAT(error_of(import_world("Material \"diffuse\" \"texture normalmap\" \"wave\"\nShape \"sphere\"")),
              testing::HasSubstr("there is no spectrum texture \"wave\""));
}

TEST_F(PbrtValues, HairTakesItsColourFromWhatIsGiven) {
  const v1::HairMaterial fallback = material("\"hair\"").hair();
  EXPECT_FLOAT_EQ(fallback.sigma_a().constant().rgb().r(), 1.3f * 0.419f);  // eumelanin 1.3
  EXPECT_FLOAT_EQ(fallback.eta(), 1.55f);
  EXPECT_FLOAT_EQ(fallback.beta_m().constant(), 0.3f);
  EXPECT_FLOAT_EQ(fallback.alpha_degrees(), 2);
  const v1::HairMaterial red = material("\"hair\" \"float pheomelanin\" 2").hair();
  EXPECT_FLOAT_EQ(red.sigma_a().constant().rgb().b(), 2 * 1.05f);
  EXPECT_TRUE(material("\"hair\" \"rgb color\" [ .1 .2 .3 ]").hair().has_reflectance());
  EXPECT_EQ(warnings_, "");
}

TEST_F(PbrtValues, PhongIsOfTextbooks) {
  const v1::PhongMaterial plain = material("\"phong\"").phong();
  EXPECT_EQ(plain.lobe(), v1::PhongMaterial::PHONG);
  EXPECT_EQ(plain.exponent().constant(), 30);
  const v1::PhongMaterial blinn =
      material("\"phong\" \"rgb specular\" [ .1 .2 .3 ] \"float exponent\" 200 \"string lobe\" \"blinn\"")
          .phong();
  EXPECT_EQ(blinn.lobe(), v1::PhongMaterial::BLINN);
  EXPECT_EQ(blinn.exponent().constant(), 200);
  EXPECT_FLOAT_EQ(blinn.specular().constant().rgb().g(), 0.2f);
}

TEST_F(PbrtValues, CoatedConductorsKeepBothLayersApart) {
  const v1::CoatedConductorMaterial coated =
      material(
          "\"coatedconductor\" \"float interface.roughness\" .04 \"float conductor.roughness\" .25 "
          "\"float interface.eta\" 1.4")
          .coated_conductor();
  EXPECT_FLOAT_EQ(coated.roughness().u().constant(), 0.04f);
  EXPECT_FLOAT_EQ(coated.conductor().roughness().v().constant(), 0.25f);
  EXPECT_FLOAT_EQ(coated.eta().constant(), 1.4f);
  EXPECT_TRUE(coated.conductor().eta().constant().has_sampled());  // copper
  EXPECT_FLOAT_EQ(coated.thickness(), 0.01f);
  EXPECT_EQ(warnings_, "");
}

TEST_F(PbrtValues, UnsupportedMaterialsBecomeNearOnes) {
  EXPECT_TRUE(material("\"measured\" \"string filename\" \"x.bsdf\"").has_diffuse());
  EXPECT_THAT(warnings_, HasSubstr("material \"measured\" is not supported yet"));
  const v1::Material milk = material("\"subsurface\" \"rgb sigma_a\" [ 0 0 0 ] \"rgb sigma_s\" [ 1 1 1 ]");
  EXPECT_FLOAT_EQ(milk.coated_diffuse().reflectance().constant().rgb().g(), 1);  // nothing is absorbed
}

TEST_F(PbrtValues, OnlyMaterialsInUseAreKept) {
  const ImportedScene scene = world(
      "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" "
      "\"dielectric\"\n"
      "MakeNamedMaterial \"unused\" \"string type\" \"hair\"\n"
      "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"b\" ] \"float amount\" "
      ".25\n"
      "NamedMaterial \"m\" Shape \"sphere\" Material \"diffuse\" Shape \"sphere\" Material \"diffuse\" Shape "
      "\"sphere\"\n");
  std::vector<std::string> names;
  for (const v1::Material& m : scene.scene.materials()) names.push_back(m.name());
  EXPECT_THAT(names, ElementsAre("a", "b", "m", "material 3"));
  EXPECT_EQ(scene.scene.materials(2).mix().a(), "a");
  EXPECT_EQ(scene.scene.materials(2).mix().b(), "b");
  EXPECT_FLOAT_EQ(scene.scene.materials(2).mix().amount().constant(), 0.25f);
  EXPECT_EQ(scene.scene.shapes(1).material(), scene.scene.shapes(2).material());
  EXPECT_EQ(warnings_of(scene), "");
}

TEST_F(PbrtValues, TexturesOfBothNameSpacesStayApart) {
  write("images/a b.png", "the bytes of a picture");
  const ImportedScene scene = world(
      "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"images/a b.png\" \"string wrap\" "
      "\"clamp\"\n"
      "  \"string encoding\" \"gamma 2.2\" \"bool invert\" true \"float scale\" 2 \"float uscale\" 3 \"float "
      "vdelta\" "
      ".5\n"
      "Texture \"t\" \"spectrum\" \"scale\" \"rgb tex\" [ .1 .2 .3 ] \"texture scale\" \"t\"\n"
      "Texture \"board\" \"spectrum\" \"checkerboard\" \"texture tex1\" \"t\" \"rgb tex2\" [ 0 0 1 ] \"float "
      "uscale\" "
      "8\n"
      "Texture \"unused\" \"float\" \"fbm\"\n"
      "Material \"diffuse\" \"texture reflectance\" \"board\" \"texture displacement\" \"t\"\n"
      "Shape \"sphere\" \"texture alpha\" \"t\"\n");
  std::vector<std::string> names;
  for (const v1::Texture& t : scene.scene.textures()) names.push_back(t.name());
  EXPECT_THAT(names, ElementsAre("t", "t (spectrum)", "board"));
  const v1::ImageTexture& image = scene.scene.textures(0).image();
  EXPECT_EQ(image.image().path(), "images/a b.png");
  EXPECT_EQ(image.wrap(), v1::ImageTexture::CLAMP);
  EXPECT_EQ(image.encoding(), v1::ImageTexture::GAMMA);
  EXPECT_FLOAT_EQ(image.gamma(), 2.2f);
  EXPECT_TRUE(image.invert());
  EXPECT_FLOAT_EQ(image.scale(), 2);
  EXPECT_FLOAT_EQ(image.mapping().scale_u(), 3);
  EXPECT_FALSE(image.mapping().has_scale_v());
  EXPECT_FLOAT_EQ(image.mapping().offset_v(), 0.5f);
  EXPECT_EQ(scene.scene.textures(1).scale().factor().texture(), "t");
  EXPECT_EQ(scene.scene.textures(2).checkerboard().even().texture(), "t (spectrum)");
  EXPECT_EQ(scene.scene.materials(0).diffuse().reflectance().texture(), "board");
  EXPECT_EQ(scene.scene.materials(0).displacement().texture(), "t");
  EXPECT_EQ(scene.scene.shapes(0).alpha().texture(), "t");
  ASSERT_THAT(scene.blobs, SizeIs(1));
  EXPECT_TRUE(scene.blobs[0].bytes.empty());  // textures stay in their files
  EXPECT_EQ(scene.blobs[0].file, (folder_ / "images/a b.png").string());
  EXPECT_EQ(warnings_of(scene), "");
}

TEST_F(PbrtValues, ReflectancesAreClampedAndConverted) {
  const v1::Spectrum clamped =
      material("\"diffuse\" \"rgb reflectance\" [ 1.5 .5 0 ]").diffuse().reflectance().constant();
  EXPECT_FLOAT_EQ(clamped.rgb().r(), 1);
  EXPECT_THAT(warnings_, HasSubstr("clamped"));
  // White is white in every space.
  const ImportedScene scene = world(
      "ColorSpace \"aces2065-1\" LightSource \"point\" \"rgb I\" [ 2 2 2 ] ColorSpace \"rec2020\" "
      "LightSource "
      "\"point\" \"rgb "
      "I\" [ 0 1 0 ]");
  for (const float c : {scene.scene.lights(0).point().intensity().rgb().r(),
                        scene.scene.lights(0).point().intensity().rgb().b()}) {
    EXPECT_NEAR(c, 2, 1e-5);  // rows of the matrix sum to 1 within its ten digits, in floats
  }
  EXPECT_NEAR(scene.scene.lights(1).point().intensity().rgb().g(), 1.1329, 1e-4);
  EXPECT_EQ(scene.scene.lights(1).point().intensity().rgb().r(), 0);  // out of gamut
}

TEST_F(PbrtValues, ColoursBeyondRec709AreKeptWhereASpectrumHasThem) {
  const ImportedScene scene = world(
      "ColorSpace \"rec2020\" MakeNamedMaterial \"teal\" \"string type\" \"diffuse\" \"rgb reflectance\" "
      "[ .1 .5 .3 ] LightSource \"point\" \"rgb I\" [ .2 1 .6 ] NamedMaterial \"teal\" Shape \"sphere\"");
  const v1::Spectrum& matter = scene.scene.materials(0).diffuse().reflectance().constant();
  const v1::Light& lamp = scene.scene.lights(0);
  EXPECT_THAT(warnings_of(scene), HasSubstr("clamped in jobs of RGB"));
  for (const v1::Spectrum* spectrum : {&matter, &lamp.point().intensity()}) {
    ASSERT_TRUE(spectrum->has_sampled());
    EXPECT_EQ(spectrum->in_rgb().r(), 0);
    EXPECT_GT(spectrum->in_rgb().g(), 0.5);
  }
  // Its brightness is that of the colour.
  EXPECT_FALSE(lamp.has_scale());
  const spectra::Curve curve{
      {matter.sampled().wavelengths_nm().begin(), matter.sampled().wavelengths_nm().end()},
      {matter.sampled().values().begin(), matter.sampled().values().end()}};
  const spectra::Triple seen =
      spectra::times(spectra::rgb_from_xyz(spectra::kRec2020),
                     spectra::tristimulus(curve, spectra::illuminant_d65(), spectra::cie1931()));
  for (const auto& [value, expected] : {std::pair(seen[0], .1), {seen[1], .5}, {seen[2], .3}})
    EXPECT_NEAR(value, expected, 2e-3);
}

TEST_F(PbrtValues, FaultsOfSpectraAreToldAtTheirPlaces) {
  const auto fault = [&](const std::string& value) {
    return error_of(import_text("WorldBegin\nMaterial \"diffuse\" \"spectrum reflectance\" " + value +
                                "\nShape \"sphere\""));
  };
  EXPECT_THAT(fault("[ 400 1 500 -1 ]"), AllOf(HasSubstr("which is negative"), HasSubstr(":2:")));
  EXPECT_THAT(fault("[ 500 1 400 1 ]"), HasSubstr("must ascend"));
  EXPECT_THAT(fault("[ .4 1 .7 1 ]"), HasSubstr("none from 300 to 1000 nm"));
  EXPECT_THAT(fault("[ 400 1 500 ]"), HasSubstr("pairs of wavelength and value"));
  EXPECT_THAT(fault("[ ]"), HasSubstr("pairs of wavelength and value"));
  EXPECT_THAT(fault("\"metal-Ag-etta\""), AllOf(HasSubstr("neither a named spectrum nor a file"),
                                                HasSubstr("did you mean 'metal-Ag-eta'?")));
  write("bad.spd", "500 1\n600 -0.5\n");
  EXPECT_THAT(fault("\"bad.spd\""), AllOf(HasSubstr("bad.spd"), HasSubstr("at 600 nm is -0.5")));
}

TEST_F(PbrtValues, SampledSpectraComeFromListsFilesAndNames) {
  write("red.spd", "# measured\n600 0.5\n700 1\n");
  const auto reflectance = [&](const std::string& value) {
    return material("\"diffuse\" \"spectrum reflectance\" " + value)
        .diffuse()
        .reflectance()
        .constant()
        .sampled();
  };
  for (const char* value : {"[ 600 .5 700 1 ]", "\"red.spd\""}) {
    const v1::SampledSpectrum s = reflectance(value);
    // Zero outside, as in pbrt: the values stand between two steps.
    EXPECT_THAT(s.values(), ElementsAre(0, 0.5f, 1, 0));
    EXPECT_THAT(s.wavelengths_nm(), ElementsAre(599.99f, 600, 700, 700.01f));
  }
  EXPECT_EQ(reflectance("\"stdillum-F1\"").values_size(), 81);
  // Indices of refraction are constant outside.
  EXPECT_EQ(material("\"dielectric\" \"spectrum eta\" [ 500 1.5 600 1.4 ]")
                .dielectric()
                .eta()
                .sampled()
                .values_size(),
            2);
}

TEST_F(PbrtValues, LightSpectraKeepPbrtsBrightness) {
  // rgb L arrives as it is.
  const v1::Light rgb = light("LightSource \"infinite\" \"rgb L\" [ 1 2 3 ] \"float scale\" .5");
  EXPECT_FLOAT_EQ(rgb.infinite().radiance().rgb().b(), 3);
  EXPECT_FLOAT_EQ(rgb.scale(), 0.5f);
  // Every other spectrum has a luminance of 1, whatever its magnitude.
  for (const char* value :
       {"\"blackbody I\" 2856", "\"spectrum I\" [ 400 7 700 9 ]", "\"spectrum I\" \"stdillum-A\""}) {
    const v1::Light l = light(std::string("LightSource \"point\" ") + value);
    const v1::Spectrum& s = l.point().intensity();
    const double y = s.has_blackbody()
                         ? spectra::pbrt_luminance([&](double nm) {
                             return spectra::relative_planck(nm, s.blackbody().kelvin());
                           })
                         : spectra::pbrt_luminance(spectra::Curve{
                               {s.sampled().wavelengths_nm().begin(), s.sampled().wavelengths_nm().end()},
                               {s.sampled().values().begin(), s.sampled().values().end()}});
    EXPECT_NEAR(y * (l.has_scale() ? l.scale() : 1), 1, 1e-6) << value;  // a float's rounding of scale
  }
  EXPECT_FLOAT_EQ(light("LightSource \"infinite\"").infinite().radiance().rgb().g(), 1);
}

TEST_F(PbrtValues, LightsStandInTheWorld) {
  const v1::Light point =
      light("Translate 1 2 3 LightSource \"point\" \"point3 from\" [ 1 0 0 ] \"float power\" 100");
  EXPECT_DOUBLE_EQ(point.point().position().x(), 2);
  EXPECT_FLOAT_EQ(point.scale(), 100 / (4 * std::numbers::pi));

  // The light travels from `from` to `to`; translations do not matter.
  const v1::Light distant = light(
      "Translate 9 9 9 Scale 1 -1 1 LightSource \"distant\" \"point3 from\" [ 0 4 0 ] \"float illuminance\" "
      "3");
  EXPECT_NEAR(distant.distant().direction().y(), 4 / std::sqrt(17.0), 1e-15);
  EXPECT_NEAR(distant.distant().direction().z(), 1 / std::sqrt(17.0), 1e-15);
  EXPECT_FLOAT_EQ(distant.scale(), 3);

  const v1::Light spot = light("Translate 0 0 1 LightSource \"spot\" \"float coneangle\" 40");
  EXPECT_DOUBLE_EQ(spot.spot().position().z(), 1);
  EXPECT_DOUBLE_EQ(spot.spot().target().z(), 2);
  EXPECT_FLOAT_EQ(spot.spot().cone_angle_degrees(), 40);
  EXPECT_FLOAT_EQ(spot.spot().cone_delta_degrees(), 5);
}

/// A PFM file of 2 x 2 pixels of one grey.
std::string grey_image(float value) {
  std::string file = "PF\n2 2\n-1.0\n";
  for (int i = 0; i < 12; ++i) file.append(reinterpret_cast<const char*>(&value), sizeof(value));
  return file;
}

TEST_F(PbrtValues, EnvironmentImagesAreBlobs) {
  write("sky.pfm", grey_image(0.5f));
  const v1::Light sky = light(
      "Rotate 90 0 0 1 LightSource \"infinite\" \"string filename\" \"sky.pfm\" \"point3 portal\" [ 0 0 0 "
      "1 0 0 1 1 0 0 1 0 ]");
  EXPECT_EQ(sky.infinite().image().path(), "sky.pfm");
  EXPECT_EQ(sky.infinite().mapping(), v1::InfiniteLight::EQUAL_AREA_OCTAHEDRAL);
  EXPECT_NEAR(sky.infinite().world_from_light().elements(4), 1, 1e-15);
  ASSERT_EQ(sky.infinite().portal_size(), 4);
  EXPECT_EQ(sky.infinite().portal(2).y(), 1);  // not turned with the light
  EXPECT_THAT(warnings_, testing::IsEmpty());
}

TEST_F(PbrtValues, ImagesOnLightsShareTheirPower) {
  write("half.pfm", grey_image(0.5f));
  const double pi = std::numbers::pi;
  const v1::Light lamp = light(
      "LightSource \"goniometric\" \"string filename\" \"half.pfm\" \"float power\" 10 \"rgb I\" [ 1 1 1 ]");
  EXPECT_FLOAT_EQ(lamp.scale(), 10 / (4 * pi * 0.5));
  EXPECT_EQ(lamp.goniometric().texture(), "half.pfm");
  EXPECT_EQ(lamp.goniometric().world_from_light().elements(6), 1);  // y and z change places

  const v1::Light slide = light(
      "LightSource \"projection\" \"string filename\" \"half.pfm\" \"float power\" 10 \"float fov\" 90");
  // Pixels at (+-1/2, +-1/2) on the plane at distance 1, which is 2 x 2: solid angles fall as (1 +
  // 1/2)^(-3/2).
  EXPECT_FLOAT_EQ(slide.scale(), 10 / (4 * 0.5 * std::pow(1.5, -1.5)));
  EXPECT_FALSE(slide.projection().has_aspect());
  EXPECT_EQ(slide.projection().world_from_light().elements(0), -1);

  const ImportedScene scene =
      world("AreaLightSource \"diffuse\" \"string filename\" \"half.pfm\" \"float power\" 6\n" +
            std::string(kTriangle));
  EXPECT_EQ(scene.scene.shapes(0).area_light().texture(), "half.pfm");
  EXPECT_FLOAT_EQ(scene.scene.shapes(0).area_light().scale(), 6 / (pi * 0.5 * 0.5));
  EXPECT_EQ(scene.scene.textures(0).image().filter(), v1::ImageTexture::BILINEAR);
}

TEST_F(PbrtValues, ImagesAreFilteredByTheirOwnWords) {
  write("half.pfm", "x");
  const auto image = [&](const std::string& parameters) {
    const ImportedScene scene =
        world("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"half.pfm\" " + parameters +
              "\n" + "Material \"diffuse\" \"texture reflectance\" \"t\"\n" + std::string(kTriangle));
    return scene.scene.textures(0).image();
  };
  EXPECT_FALSE(image("").has_filter());
  EXPECT_TRUE(image("\"string filter\" \"bilinear\"").has_filter());
  EXPECT_EQ(image("\"string filter\" \"bilinear\"").filter(), v1::ImageTexture::BILINEAR);
  EXPECT_EQ(image("\"string filter\" \"point\"").filter(), v1::ImageTexture::NEAREST);
  EXPECT_EQ(image("\"string filter\" \"trilinear\"").filter(), v1::ImageTexture::TRILINEAR);
  const std::string ewa = "\"string filter\" \"ewa\" \"float maxanisotropy\" ";
  EXPECT_EQ(image(ewa + "4").filter(), v1::ImageTexture::EWA);
  EXPECT_EQ(image(ewa + "4").max_anisotropy(), 4);
  EXPECT_FALSE(image(ewa + "0.5").has_max_anisotropy());  // it gives a warning
  EXPECT_FALSE(image(ewa + "1e9").has_max_anisotropy());
  EXPECT_FALSE(image("\"string filter\" \"sharp\"").has_filter());
}

TEST_F(PbrtValues, PowerOfAreaLightsFollowsFromTheirSize) {
  const std::string emitter = "AreaLightSource \"diffuse\" \"rgb L\" [ 1 1 1 ] \"float power\" 10\n";
  // A sphere of radius 2 under a scaling by 3: area 4 pi 36. One triangle of area 1/2, on both sides.
  const ImportedScene scene =
      world("AttributeBegin Scale 3 3 3\n" + emitter + "Shape \"sphere\" \"float radius\" 2 AttributeEnd\n" +
            "AreaLightSource \"diffuse\" \"float power\" 10 \"bool twosided\" true\n" + kTriangle);
  const double pi = std::numbers::pi;
  EXPECT_FLOAT_EQ(scene.scene.shapes(0).area_light().scale(), 10 / (pi * 4 * pi * 36));
  EXPECT_FLOAT_EQ(scene.scene.shapes(1).area_light().scale(), 10 / (2 * pi * 0.5));
  // Each of the two triangles of a square gets the power, but a patch is one light.
  const ImportedScene squares = world(
      "AreaLightSource \"diffuse\" \"float power\" 10\n"
      "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 1 1 0 0 1 0 ] \"integer indices\" [ 0 1 2 0 2 3 ]\n"
      "Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 0 ]\n");
  EXPECT_FLOAT_EQ(squares.scene.shapes(0).area_light().scale(), 2 * 10 / pi);
  EXPECT_FLOAT_EQ(squares.scene.shapes(1).area_light().scale(), 10 / pi);
}

TEST_F(PbrtValues, TexturesStandInTheirOwnSpace) {
  const ImportedScene scene = world(
      "Translate 5 0 0\n"
      "Texture \"dots\" \"spectrum\" \"dots\" \"rgb inside\" [ 1 0 0 ] \"string mapping\" \"planar\"\n"
      "  \"vector3 v1\" [ 0 2 0 ] \"float udelta\" .5\n"
      "Texture \"noise\" \"float\" \"wrinkled\" \"integer octaves\" 3\n"
      "Texture \"both\" \"spectrum\" \"directionmix\" \"texture tex1\" \"dots\" \"vector3 dir\" [ 0 0 2 ]\n"
      "Texture \"slope\" \"spectrum\" \"bilerp\"\nTexture \"cubes\" \"spectrum\" \"checkerboard\" \"integer "
      "dimension\" 3\n"
      "Material \"coateddiffuse\" \"texture reflectance\" \"both\" \"texture roughness\" \"noise\" Shape "
      "\"sphere\"\n"
      "Material \"diffuse\" \"texture reflectance\" \"slope\" Shape \"sphere\"\n"
      "Material \"diffuse\" \"texture reflectance\" \"cubes\" Shape \"sphere\"\n");
  EXPECT_EQ(warnings_of(scene), "");
  std::map<std::string, v1::Texture> textures;
  for (const v1::Texture& texture : scene.scene.textures()) textures[texture.name()] = texture;
  const v1::UvMapping& plane = textures["dots"].dots().mapping();
  EXPECT_EQ(plane.source(), v1::UvMapping::PLANAR);
  // u = 2 y + 1/2 and v = y of texture space, whose origin is at x = 5.
  EXPECT_DOUBLE_EQ(plane.texture_from_world().elements(1), 2);
  EXPECT_DOUBLE_EQ(plane.texture_from_world().elements(5), 1);
  EXPECT_FLOAT_EQ(plane.offset_u(), 0.5f);
  EXPECT_FLOAT_EQ(textures["dots"].dots().outside().constant().rgb().r(),
                  1);  // pbrt swaps inside and outside
  EXPECT_EQ(textures["noise"].noise().kind(), v1::NoiseTexture::WRINKLED);
  EXPECT_EQ(textures["noise"].noise().octaves(), 3u);
  EXPECT_DOUBLE_EQ(textures["noise"].noise().texture_from_world().elements(3), -5);
  EXPECT_DOUBLE_EQ(textures["both"].direction_mix().direction().z(), 1);
  EXPECT_FLOAT_EQ(textures["slope"].image().mapping().offset_u(), 0.25f);
  EXPECT_TRUE(textures["cubes"].checkerboard().solid());
  EXPECT_THAT(error_of(import_world(
                  "Texture \"p\" \"float\" \"ptex\" Material \"dielectric\" \"texture roughness\" \"p\" "
                  "Shape \"sphere\"")),
              HasSubstr("Ptex files are not supported"));
}

}  // namespace
}  // namespace tessera::client
