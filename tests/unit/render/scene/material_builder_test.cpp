// Materials alone, with textures that are only names.
#include "render/scene/material/material_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "render/bsdf/kinds.h"
#include "render/scene/spectral/spectral_builder.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class MaterialBuilderTest : public testing::Test {
 protected:
  MaterialBuilderTest() {
    textures_.add_noise("clouds");
    textures_.add_constant("grey", 0.25f);
  }
  absl::Status build(const std::string& materials) {
    return builder_.build(message<v1::Scene>(materials).materials());
  }
  std::string refusal(const std::string& materials) {
    MaterialTable table;
    MaterialBuilder builder(textures_, table, warnings_);
    const auto scene = message<v1::Scene>(materials);
    return std::string(builder.build(scene.materials()).message());
  }
  /// That of a material 'm' of this kind.
  std::string refusal_of(const std::string& kind) { return refusal("materials { name: 'm' " + kind + " }"); }
  const MaterialRecord& record(const std::string& name) {
    return table_.materials[static_cast<std::size_t>(builder_.names().find(name).value())];
  }

  NamedTextures textures_;
  MaterialTable table_;
  std::vector<std::string> warnings_;
  MaterialBuilder builder_{textures_, table_, warnings_};
};

TEST_F(MaterialBuilderTest, CoatsSayWhatIndexOfSeveralTheyHave) {
  const std::string measured = "eta { named: 'glass-BK7' }", one = "eta { constant: 1.4 }";
  for (const char* kind : {"coated_diffuse", "plastic", "coated_conductor"}) {
    SCOPED_TRACE(kind);
    SpectralTables tables;
    SpectralBuilder spectral(tables);
    for (const std::string& eta : {measured, one}) {
      MaterialTable table;
      std::vector<std::string> of_wavelengths, of_rgb;
      const auto scene = message<v1::Scene>(absl::StrCat("materials { name: 'm' ", kind, " { ", eta, " } }"));
      MaterialBuilder rgb(textures_, table, of_rgb),
          builder(textures_, table, of_wavelengths, true, &spectral);
      EXPECT_TRUE(rgb.build(scene.materials()).ok());
      EXPECT_TRUE(builder.build(scene.materials()).ok());
      EXPECT_THAT(of_rgb, IsEmpty());
      if (eta == one) {
        EXPECT_THAT(of_wavelengths, IsEmpty());
      } else {
        EXPECT_THAT(of_wavelengths, ElementsAre(AllOf(HasSubstr("material 'm': its coat has the index 1.516"),
                                                      HasSubstr("1.53"), HasSubstr("at 700 nm"))));
      }
    }
  }
}

TEST_F(MaterialBuilderTest, SlotsHoldConstantsAndTextures) {
  ASSERT_EQ(build(R"(
      materials { name: 'red' diffuse { reflectance { constant { rgb { r: 1 } } } } }
      materials { name: 'cloudy' diffuse { reflectance { texture: 'clouds' } } }
      materials { name: 'grey' diffuse { reflectance { texture: 'grey' } } })"),
            absl::OkStatus());
  EXPECT_THAT(record("red").spectra[slot::kReflectance].value, ElementsAre(1, 0, 0));
  EXPECT_EQ(record("red").flags, 0);
  EXPECT_EQ(record("cloudy").spectra[slot::kReflectance].texture, *textures_.node("clouds"));
  EXPECT_TRUE(record("cloudy").flags & kHasTextures);
  // A constant texture is no texture.
  EXPECT_EQ(record("grey").spectra[slot::kReflectance].texture, -1);
  EXPECT_EQ(record("grey").spectra[slot::kReflectance].value[1], 0.25f);
  EXPECT_EQ(record("grey").flags, 0);
  // Shapes that name none get the last.
  ASSERT_EQ(table_.materials.size(), 4u);
  EXPECT_EQ(&record(""), &table_.materials[3]);
  EXPECT_EQ(record("").spectra[slot::kReflectance].value[0], 0.5f);
}

TEST_F(MaterialBuilderTest, MixesAndBacksReferToOthers) {
  ASSERT_EQ(build(R"(
      materials { name: 'both' mix { a: 'two' b: 'three' amount { constant: 0.75 } }
        opacity { constant: 0.5 } }
      materials { name: 'two' hair {} back: 'three' }
      materials { name: 'three' interface {} })"),
            absl::OkStatus());
  EXPECT_EQ(record("both").mix_a, 1);
  EXPECT_EQ(record("both").mix_b, 2);
  EXPECT_EQ(record("both").scalars[slot::kMixAmount].value, 0.75f);
  EXPECT_TRUE(record("both").flags & kMixed);
  EXPECT_TRUE(record("both").flags & kHasOpacity);
  EXPECT_EQ(record("two").back, 2);
  EXPECT_TRUE(record("two").flags & kHasBack);
  EXPECT_EQ(record("three").kind, BsdfKind::kInterface);
  EXPECT_TRUE(record("three").flags & kPassesStraight);
}

TEST_F(MaterialBuilderTest, TablesOfEnergyAreMadeOnce) {
  const auto floats_of = [&](const std::string& materials) {
    MaterialTable table;
    const auto scene = message<v1::Scene>(materials);
    EXPECT_EQ(MaterialBuilder(textures_, table, warnings_).build(scene.materials()), absl::OkStatus());
    return table.coat_tables.size();
  };
  for (const char* kind :
       {"coated_diffuse {}", "plastic { roughness { u { constant: 0.2 } v { constant: 0.2 } } }",
        "conductor { roughness { u { constant: 0.2 } v { constant: 0.2 } } }"}) {
    const std::string one = absl::StrCat("materials { name: 'a' ", kind, " }"),
                      other = absl::StrCat("materials { name: 'b' ", kind, " }");
    EXPECT_GT(floats_of(one), 0u) << kind;
    EXPECT_EQ(floats_of(one + other), floats_of(one)) << kind;
  }
}

TEST_F(MaterialBuilderTest, AFactorOfATextureIsATexture) {
  ASSERT_EQ(build(R"(materials { name: 'leaf' diffuse_transmission { scale: 0.5
                     reflectance { texture: 'clouds' } transmittance { constant { constant: 0.5 } } } })"),
            absl::OkStatus());
  ASSERT_EQ(textures_.scales.size(), 1u);
  EXPECT_EQ(textures_.scales[0], std::pair(*textures_.node("clouds"), 0.5f));
  EXPECT_EQ(record("leaf").spectra[slot::kReflectance].texture, *textures_.node("scaled"));
  EXPECT_EQ(record("leaf").spectra[slot::kTransmittance].value[0], 0.25f);
}

TEST_F(MaterialBuilderTest, MapsBendTheSurface) {
  ASSERT_EQ(build(R"(
      materials { name: 'bumpy' diffuse {} displacement { texture: 'clouds' } }
      materials { name: 'mapped' diffuse {} normal_map { image { digest: 'x' } } })"),
            absl::OkStatus());
  EXPECT_EQ(record("bumpy").bump_texture, *textures_.node("clouds"));
  EXPECT_EQ(record("bumpy").bump_step, 0.0005f);
  EXPECT_TRUE(record("bumpy").flags & kHasBump);
  EXPECT_EQ(record("mapped").normal_texture, *textures_.node("a normal map"));
}

TEST_F(MaterialBuilderTest, FurtherSlotsAreOnlyUsedWhereThereIsMoreThanLayers) {
  ASSERT_EQ(build(R"(
      materials { name: 'plain' gltf { clearcoat { constant: 1 } iridescence_ior: 2 dispersion: 1 } }
      materials { name: 'bent' gltf { clearcoat { constant: 1 } } displacement { texture: 'clouds' } }
      materials { name: 'coat' gltf { clearcoat { constant: 1 }
        clearcoat_normal_map { image { digest: 'x' } } } }
      materials { name: 'film' gltf { iridescence { constant: 1 }
        iridescence_thickness { texture: 'clouds' } } }
      materials { name: 'glass' gltf { transmission { constant: 1 } volume: true ior: 1.4 dispersion: 2 } }
      materials { name: 'wide' gltf { transmission { constant: 1 } volume: true ior: 1.4
        dispersion: 200 } })"),
            absl::OkStatus());
  const auto further = [&](const char* name) {
    return table_.extended[static_cast<std::size_t>(record(name).extended)].further;
  };
  EXPECT_FALSE(record("plain").flags & (kUsesFurther | kPrepared));
  EXPECT_TRUE(record("bent").flags & kUsesFurther);
  EXPECT_EQ(record("bent").upper_normal_texture, -1);
  EXPECT_TRUE(record("coat").flags & kUsesFurther);
  EXPECT_EQ(record("coat").upper_normal_texture, *textures_.node("a normal map"));
  EXPECT_TRUE(record("film").flags & kPrepared);
  EXPECT_EQ(further("film")[slot::kFilm].value, 1);
  EXPECT_EQ(further("film")[slot::kFilmEta].value, 1.3f);
  EXPECT_EQ(further("film")[slot::kFilmThickness].texture, *textures_.node("clouds"));
  EXPECT_FALSE(table_.film_table.empty());
  // (ior - 1) 0.025 dispersion, and never to an index of 1.
  EXPECT_NEAR(further("glass")[slot::kSpread].value, 0.02f, 1e-6);
  EXPECT_NEAR(further("wide")[slot::kSpread].value, 0.399f, 1e-6);
}

TEST_F(MaterialBuilderTest, WarnsOfWhatIsLeftOut) {
  ASSERT_EQ(build("materials { name: 'plain' coated_diffuse {} }"), absl::OkStatus());
  EXPECT_THAT(warnings_, IsEmpty());
  MaterialTable table;
  const auto scene = message<v1::Scene>(
      "materials { name: 'milky' coated_diffuse { albedo { constant { constant: 0.5 } } } }");
  EXPECT_EQ(MaterialBuilder(textures_, table, warnings_).build(scene.materials()), absl::OkStatus());
  EXPECT_THAT(warnings_, ElementsAre("material 'milky': the medium inside its coat is left out"));
}

/// Materials m0, m1 ..., each a mix of the one before it with itself.
std::string mixes(int count) {
  std::string text = "materials { name: 'm0' diffuse {} } ";
  for (int i = 1; i <= count; ++i)
    absl::StrAppend(&text, "materials { name: 'm", i, "' mix { a: 'm", i - 1, "' b: 'm", i - 1, "' } } ");
  return text;
}

TEST_F(MaterialBuilderTest, BoundsMixesOfMixes) {
  EXPECT_THAT(refusal("materials { name: 'm' mix { a: 'n' b: 'n' } } "
                      "materials { name: 'n' mix { a: 'm' b: 'm' } }"),
              HasSubstr("material 'm': it mixes itself"));
  EXPECT_THAT(refusal(mixes(100'000)), HasSubstr("more than 64 mixes within one another"));
}

TEST_F(MaterialBuilderTest, TakesMixesThatShareTheirParts) {
  // 2^40 ways lead to the first.
  EXPECT_EQ(build(mixes(40)), absl::OkStatus());
  EXPECT_EQ(table_.materials.size(), 42u);  // and the one of shapes without
}

TEST_F(MaterialBuilderTest, NamesTheMaterialAtFault) {
  EXPECT_THAT(refusal_of(""), HasSubstr("material 'm': its kind is missing"));
  EXPECT_THAT(refusal("materials { name: 'm' hair {} } materials { name: 'm' hair {} }"),
              HasSubstr("material 'm': the name is used twice"));
  EXPECT_THAT(refusal_of("mix { a: 'm' b: 'm' }"), HasSubstr("material 'm': it mixes itself"));
  EXPECT_THAT(refusal_of("mix { a: 'x' b: 'm' }"), HasSubstr("material 'm': material 'x' does not exist"));
  EXPECT_THAT(refusal_of("hair {} back: 'x'"), HasSubstr("material 'm': material 'x' does not exist"));
  EXPECT_THAT(refusal_of("diffuse { reflectance { texture: 'x' } }"),
              HasSubstr("material 'm': no texture x"));
  EXPECT_THAT(refusal_of("diffuse { reflectance { constant { constant: inf } } }"),
              HasSubstr("material 'm': spectrum: a colour is not finite"));
  EXPECT_THAT(refusal_of("dielectric { eta { constant: 1e9 } }"),
              HasSubstr("an index of refraction of 1e+09"));
  EXPECT_THAT(refusal_of("conductor { roughness { u { constant: -1 } } }"),
              HasSubstr("a roughness is below 0"));
  EXPECT_THAT(refusal_of("plastic { roughness { u { constant: 0.1 } v { constant: 0.2 } } }"),
              HasSubstr("must be constant and the same along u and v"));
  EXPECT_THAT(refusal_of("coated_diffuse { thickness: -1 }"),
              HasSubstr("the thickness of its coat is below 0"));
  EXPECT_THAT(refusal_of("principled { specular { constant: 2 } }"),
              HasSubstr("its specular is not between"));
  EXPECT_THAT(refusal_of("hair { alpha_degrees: nan }"), HasSubstr("the tilt of its scales"));
  EXPECT_THAT(refusal_of("gltf { iridescence_ior: 0.5 }"), HasSubstr("an iridescence_ior of 0.5"));
  EXPECT_THAT(refusal_of("gltf { iridescence_ior: nan }"), HasSubstr("an iridescence_ior of nan"));
  EXPECT_THAT(refusal_of("gltf { iridescence_thickness { constant: -1 } }"),
              HasSubstr("an iridescence_thickness of -1"));
  EXPECT_THAT(refusal_of("gltf { dispersion: -1 }"), HasSubstr("a dispersion of -1"));
  EXPECT_THAT(refusal_of("gltf { dispersion: inf }"), HasSubstr("a dispersion of inf"));
  EXPECT_THAT(refusal_of("dielectric { dispersion { glass: 'N-BK8' } }"),
              HasSubstr("there is no glass 'N-BK8'; did you mean 'N-BK7'? Known are N-BK7, "));
  EXPECT_THAT(refusal_of("dielectric { eta { constant: 1.5 } dispersion { glass: 'water' } }"),
              HasSubstr("eta and dispersion exclude each other"));
  EXPECT_THAT(refusal_of("thin_dielectric { dispersion {} }"), HasSubstr("a dispersion without a kind"));
  EXPECT_THAT(refusal_of("dielectric { dispersion { abbe { index: 1.5 } } }"),
              HasSubstr("an Abbe number of 0 is not above 0"));
  EXPECT_THAT(refusal_of("dielectric { dispersion { cauchy { a: -1 } } }"),
              HasSubstr("at 300 nm, an index of refraction of -1"));
  EXPECT_THAT(refusal_of("dielectric { dispersion { cauchy { a: nan } } }"), HasSubstr("of nan"));
  EXPECT_THAT(refusal_of("diffuse {} normal_map {} normal_texture: 'clouds'"),
              HasSubstr("exclude each other"));
}

}  // namespace
}  // namespace tessera::render
