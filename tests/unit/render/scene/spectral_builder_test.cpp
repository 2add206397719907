// Colours and measured spectra as they become those of jobs of wavelengths, and what is told of colours that
// no spectrum has.
#include "render/scene/spectral/spectral_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "render/bsdf/kinds.h"
#include "spectra/upsampling/sigmoid.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SpectralBuilderTest : public testing::Test {
 protected:
  /// Warnings of a material whose reflectance is this slot.
  std::vector<std::string> warnings_of(const SpectrumSlot& slot) {
    materials_.materials.assign(1, {});
    materials_.materials[0].spectra[slot::kReflectance] = slot;
    std::vector<std::string> warnings;
    builder_.convert(materials_, textures_, {"paint"}, warnings);
    return warnings;
  }
  const SpectrumSlot& converted() const { return materials_.materials[0].spectra[slot::kReflectance]; }

  float value_of_curve(std::int32_t number, int nm) const {
    return tables_.curves[static_cast<std::size_t>(number * kCurveSamples + nm - static_cast<int>(kFirstNm))];
  }

  SpectralTables tables_;
  SpectralBuilder builder_{tables_};
  TextureTable textures_;
  MaterialTable materials_;
};

TEST_F(SpectralBuilderTest, ColoursWithinTheGamutAreReachedWithoutAWord) {
  for (const SpectrumSlot& slot :
       {SpectrumSlot{{0.2f, 0.9f, 0}}, SpectrumSlot{{0, 0, 0}}, SpectrumSlot{{2, 1, 0}}})
    EXPECT_THAT(warnings_of(slot), IsEmpty());
}

TEST_F(SpectralBuilderTest, ColoursThatNoSpectrumHasAreTold) {
  EXPECT_THAT(warnings_of({{-0.5f, 0.9f, 0.1f}}),
              ElementsAre(AllOf(HasSubstr("material 'paint': no spectrum has its colour (-0.5, 0.9, 0.1)"),
                                HasSubstr("off in CIEDE2000"))));
  // A little beyond the gamut there is one.
  EXPECT_THAT(warnings_of({{-0.01f, 0.4f, 0.3f}}), IsEmpty());
  const spectra::SigmoidCoefficients k = {converted().value[0], converted().value[1], converted().value[2]};
  for (const float nm : {400.0f, 550.0f, 700.0f}) EXPECT_GT(spectra::value(k, nm), 0);
  const auto is_told = [&](const char* light) {
    return builder_.emission_of(message<v1::Spectrum>(light)).unreached.is_told();
  };
  EXPECT_TRUE(is_told("rgb { r: -1.9 g: 2 b: 0.1 }"));
  EXPECT_TRUE(is_told("rgb { r: -3 g: 2 b: 0.1 }"));
  EXPECT_FALSE(is_told("rgb { r: 3 g: 2 b: 0.1 }"));
  EXPECT_FALSE(is_told("constant: 0"));
}

TEST_F(SpectralBuilderTest, TexelsThatNoSpectrumHasAreToldOncePerMaterial) {
  TextureNode node;
  node.kind = TextureKind::kImage;
  const auto image = std::make_shared<TextureImage>();
  image->texels32 = {0.5f, 0.5f, 0.5f, 1, 0.3f, 0.6f, -0.4f, 1, 0.3f, 0.6f, -0.1f, 1};
  node.image = image;
  textures_.nodes = {node};
  EXPECT_THAT(warnings_of({{}, 0}), ElementsAre(HasSubstr("(0.3, 0.6, -0.4)")));
  EXPECT_EQ(converted().texture, 0);
  image->texels32.resize(4);
  EXPECT_THAT(warnings_of({{}, 0}), IsEmpty());
}

TEST_F(SpectralBuilderTest, MeasuredSlotsStayCurves) {
  const auto curve = builder_.add_measured(
      message<v1::Spectrum>("sampled { wavelengths_nm: [500, 600] values: [0.2, 0.4] }"));
  ASSERT_TRUE(curve.has_value());
  EXPECT_THAT(warnings_of({{0.3f, 0.3f, 0.3f}, -1, *curve}), IsEmpty());
  EXPECT_EQ(converted().curve, *curve);
  EXPECT_EQ(converted().texture, -1);
  EXPECT_FLOAT_EQ(value_of_curve(*curve, 550), 0.3f);
  EXPECT_FALSE(builder_.add_measured(message<v1::Spectrum>("rgb { r: 1 }")).has_value());
  const auto named = builder_.add_measured(message<v1::Spectrum>("named: 'glass-BK7'"));
  ASSERT_TRUE(named.has_value());
  EXPECT_NEAR(value_of_curve(*named, 589), 1.5167f, 2e-4);
}

TEST_F(SpectralBuilderTest, AlbedosOfMediaAreAtMostOne) {
  const std::int32_t scattering = builder_.add_factor({3, 1, 0.2f}),
                     extinction = builder_.add_factor({2, 2, 2});
  const std::int32_t albedo = builder_.add_albedo(scattering, extinction);
  for (int nm = 360; nm <= 830; nm += 10) {
    const float ratio = value_of_curve(scattering, nm) / value_of_curve(extinction, nm);
    EXPECT_FLOAT_EQ(value_of_curve(albedo, nm), std::min(ratio, 1.0f));
  }
}

TEST_F(SpectralBuilderTest, MajorantsHoldAtAllWavelengths) {
  MediumTable media;
  media.grids.resize(2);
  media.grids[0].channels = 1;
  media.grids[1].channels = 3;
  MediumRecord plain, grey, colored, measured;
  plain.sigma_t = {{0.5f, 0.1f, 0.1f}, -1};
  plain.majorants = {0.5f};
  grey.sigma_t = {{2, 2, 2}, 0};
  grey.majorants = {2, 4};
  colored.sigma_t = {{1, 1, 1}, 1};
  colored.majorants = {3, 5};
  measured.sigma_t = {{0.1f, 0.1f, 0.1f},
                      -1,
                      *builder_.add_measured(message<v1::Spectrum>(
                          "sampled { wavelengths_nm: [379, 380, 381] values: [0.1, 7, 0.1] }"))};
  measured.majorants = {0.1f};
  media.media = {plain, grey, colored, measured};
  builder_.convert(media);
  EXPECT_GT(media.media[0].majorants[0], 0.5f);
  EXPECT_LE(media.media[0].majorants[0], 1);
  for (int nm = 360; nm <= 830; ++nm)
    EXPECT_LE(value_of_curve(media.media[0].sigma_t.curve, nm), media.media[0].majorants[0]);
  EXPECT_THAT(media.media[1].majorants, ElementsAre(2, 4));
  EXPECT_THAT(media.media[2].majorants, ElementsAre(6, 10));
  EXPECT_THAT(media.media[3].majorants, ElementsAre(7));
}

}  // namespace
}  // namespace tessera::render
