// Participating media alone.
#include "render/scene/medium/medium_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/render/scene/builder_inputs.h"
#include "wire/volume_blob.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class MediumBuilderTest : public testing::Test {
 protected:
  absl::Status build(const std::string& media, const wire::AlgorithmTraits& algorithm = kSeesMedia) {
    return builder_.build(message<v1::Scene>(media).media(), algorithm, warnings_);
  }
  std::string refusal(const std::string& medium) {
    MediumTable table;
    MediumBuilder builder(space_, blobs_.source, table);
    const auto scene = message<v1::Scene>("media { name: 'fog' " + medium + " }");
    return std::string(builder.build(scene.media(), kSeesMedia, warnings_).message());
  }

  const RenderSpace space_ = render_space_about({1, 0, 0});
  BlobsInMemory blobs_;
  MediumTable table_;
  std::vector<std::string> warnings_;
  MediumBuilder builder_{space_, blobs_.source, table_};
};

TEST_F(MediumBuilderTest, AHomogeneousOneHasAnAlbedo) {
  ASSERT_EQ(build(R"(media { name: 'fog' scale: 2 g: 0.5 extinction { constant { constant: 3 } }
                             sigma_s { constant { rgb { r: 3 g: 1.5 } } } })"),
            absl::OkStatus());
  ASSERT_EQ(table_.media.size(), 1u);
  const MediumRecord& fog = table_.media[0];
  EXPECT_TRUE(fog.homogeneous);
  EXPECT_FALSE(fog.emits);
  EXPECT_EQ(fog.g, 0.5f);
  EXPECT_EQ(fog.sigma_t.value[0], 6);
  EXPECT_THAT(fog.albedo.value, ElementsAre(1, 0.5f, 0));
  EXPECT_EQ(*builder_.names().find("fog"), 0);
  EXPECT_EQ(*builder_.names().find(""), -1);
  EXPECT_THAT(std::string(builder_.names().find("smoke").status().message()),
              HasSubstr("medium 'smoke' does not exist"));
}

TEST_F(MediumBuilderTest, AGridStandsInItsUnitCube) {
  const std::vector<float> samples = {0, 4};
  blobs_.add("grid", wire::encode_volume({2, 1, 1, 1, samples}));
  // A cube of side 2 whose corner is the origin of the world.
  ASSERT_EQ(build(R"(media { name: 'smoke' extinction { grid { blob { digest: 'grid' } world_from_grid {
                     elements: [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1] } } } })"),
            absl::OkStatus());
  const MediumRecord& smoke = table_.media[0];
  EXPECT_FALSE(smoke.homogeneous);
  EXPECT_EQ(smoke.sigma_t.grid, 0);
  EXPECT_EQ(table_.grids[0].size[0], 2);
  EXPECT_EQ(smoke.bounds_from_render.m[0], 0.5f);
  EXPECT_EQ(smoke.bounds_from_render.m[3], 0.5f);  // the origin of render space is (1, 0, 0)
  EXPECT_EQ(*std::max_element(smoke.majorants.begin(), smoke.majorants.end()), 4);
}

TEST_F(MediumBuilderTest, AreLeftOutWithAWarningWhereTheAlgorithmSeesNone) {
  ASSERT_EQ(build("media { name: 'fog' g: 7 }", kSurfacesAlone), absl::OkStatus());
  EXPECT_TRUE(table_.media.empty());
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("'surfaces' looks at surfaces only")));
  EXPECT_EQ(*builder_.names().find("fog"), -1);
  EXPECT_EQ(*builder_.names().find("anything"), -1);
}

TEST_F(MediumBuilderTest, NamesTheMediumAtFault) {
  EXPECT_THAT(refusal("g: 1"), HasSubstr("medium 'fog': its asymmetry g"));
  EXPECT_THAT(refusal("scale: -1"), HasSubstr("medium 'fog': its scale is negative"));
  EXPECT_THAT(refusal("extinction { constant { constant: -1 } }"),
              HasSubstr("medium 'fog': extinction: a coefficient is negative"));
  EXPECT_THAT(refusal("emission { grid { blob { digest: 'x' } } }"),
              HasSubstr("medium 'fog': emission: volume x: there is no blob x"));
  const std::vector<float> samples = {1, -1};
  blobs_.add("below", wire::encode_volume({2, 1, 1, 1, samples}));
  EXPECT_THAT(refusal("albedo { grid { blob { digest: 'below' } } }"),
              HasSubstr("scattering: a grid has a negative sample"));
  blobs_.add("two", wire::encode_volume({1, 1, 1, 2, samples}));
  EXPECT_THAT(refusal("albedo { grid { blob { digest: 'two' } } }"),
              HasSubstr("2 channels instead of 1 or 3"));
  EXPECT_THAT(refusal("extinction { constant { constant: 1e9 } } world_from_bounds {}"),
              HasSubstr("its optical depth from corner to corner"));
  EXPECT_THAT(refusal("} media { name: 'fog'"), HasSubstr("medium 'fog': the name is used twice"));
}

}  // namespace
}  // namespace tessera::render
