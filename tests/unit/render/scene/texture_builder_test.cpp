// Textures and values over meshes alone: nodes, and which images are read.
#include "render/scene/texture/texture_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "render/scene/texture/mesh_attributes.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class TextureBuilderTest : public testing::Test {
 protected:
  absl::Status build(const std::string& textures) {
    scene_ = message<v1::Scene>(textures);
    return builder_.build(scene_.textures());
  }
  std::string refusal(const std::string& textures) {
    TextureTable table;
    TextureImages images;
    TextureBuilder builder(space_, images, table);
    const auto scene = message<v1::Scene>(textures);
    return std::string(builder.build(scene.textures()).message());
  }
  const TextureNode& node(const std::string& name) {
    const auto found = builder_.node(name);
    EXPECT_TRUE(found.ok()) << found.status();
    return table_.nodes[static_cast<std::size_t>(found.value_or(0))];
  }

  const RenderSpace space_ = render_space_about({1, 2, 3});
  TextureTable table_;
  TextureImages images_;
  v1::Scene scene_;
  TextureBuilder builder_{space_, images_, table_};
};

/// One texel in the portable float format.
std::string one_texel(float r, float g, float b) { return "PF\n1 1\n-1.0\n" + bytes_of<float>({r, g, b}); }

TEST_F(TextureBuilderTest, WhatIsMadeOfConstantsIsOne) {
  ASSERT_EQ(build(R"(
      textures { name: 'product' scale { value { texture: 'grey' } factor { constant { constant: 0.5 } } } }
      textures { name: 'grey' constant { constant: 0.5 } }
      textures { name: 'between' mix { a { texture: 'grey' } b { constant { constant: 1 } }
                                       amount { constant: 0.5 } } })"),
            absl::OkStatus());
  EXPECT_EQ(node("product").kind, TextureKind::kConstant);
  EXPECT_EQ(node("product").value[1], 0.25f);
  EXPECT_EQ(node("between").kind, TextureKind::kConstant);
  EXPECT_EQ(node("between").value[2], 0.75f);
}

TEST_F(TextureBuilderTest, InputsStandBeforeWhatUsesThem) {
  ASSERT_EQ(build(R"(
      textures { name: 'board' checkerboard { even { texture: 'clouds' } mapping { scale_u: 3 } } }
      textures { name: 'clouds' noise { octaves: 3 } })"),
            absl::OkStatus());
  const int board = *builder_.node("board");
  const TextureNode& made = node("board");
  EXPECT_EQ(made.scale_u, 3);
  EXPECT_EQ(made.scale_v, 1);
  EXPECT_EQ(made.inputs[0], *builder_.node("clouds"));
  for (const int i : {0, 1}) EXPECT_LT(made.inputs[i], board);
  EXPECT_EQ(table_.nodes[static_cast<std::size_t>(made.inputs[1])].value[0], 0);  // black
  // The space of a texture is the world's: render space's origin is (1, 2, 3) there.
  EXPECT_EQ(made.texture_from_render.m[3], 1);
  EXPECT_EQ(made.texture_from_render.m[11], 3);
}

TEST_F(TextureBuilderTest, OnlyImagesThatAreAskedForAreRead) {
  ASSERT_EQ(build(R"(
      textures { name: 'used' image { image { digest: 'a' path: 'a.pfm' } } }
      textures { name: 'same file' image { image { digest: 'a' } wrap: CLAMP wrap_v: MIRROR } }
      textures { name: 'other encoding' image { image { digest: 'a' } encoding: SRGB } }
      textures { name: 'unused' image { image { digest: 'b' } } })"),
            absl::OkStatus());
  EXPECT_EQ(node("used").image, node("same file").image);
  EXPECT_EQ(node("same file").wrap.u, WrapMode::kClamp);
  EXPECT_EQ(node("same file").wrap.v, WrapMode::kMirror);
  BlobsInMemory blobs({{"a", one_texel(1, 2, 3)}, {"c", one_texel(4, 5, 6)}});
  const auto map = builder_.normal_map(scene_.textures(0).image());
  ASSERT_TRUE(map.ok());
  ASSERT_EQ(images_.decode(blobs.source, 2), absl::OkStatus());
  EXPECT_THAT(blobs.asked(), ElementsAre("a"));
  EXPECT_EQ(node("used").image->texels32.size(), 4u);
  EXPECT_EQ(node("used").image->texels32[1], 2);
  EXPECT_EQ(table_.nodes[static_cast<std::size_t>(*map)].image, node("used").image);
}

TEST_F(TextureBuilderTest, ImagesAreFilteredByTheirUse) {
  TextureBuilder builder(space_, images_, table_, TexelFilter::kTrilinear);
  scene_ = message<v1::Scene>(R"(
      textures { name: 'unsaid' image { image { digest: 'a' } } }
      textures { name: 'plain' image { image { digest: 'a' } filter: BILINEAR } }
      textures { name: 'near' image { image { digest: 'a' } filter: NEAREST } }
      textures { name: 'long' image { image { digest: 'a' } filter: EWA max_anisotropy: 16 } }
      textures { name: 'half' scale { value { texture: 'unsaid' }
        factor { constant { constant: 0.5 } } } })");
  ASSERT_EQ(builder.build(scene_.textures()), absl::OkStatus());
  const auto node = [&](const absl::StatusOr<int>& found) -> const TextureNode& {
    EXPECT_TRUE(found.ok()) << found.status();
    return table_.nodes[static_cast<std::size_t>(found.value_or(0))];
  };
  EXPECT_EQ(node(builder.node("unsaid")).filter, TexelFilter::kTrilinear);
  EXPECT_EQ(node(builder.node("plain")).filter, TexelFilter::kBilinear);
  EXPECT_EQ(node(builder.node("long")).filter, TexelFilter::kEwa);
  EXPECT_EQ(node(builder.node("long")).max_anisotropy, 16);
  // A texture that is so already is not made again.
  EXPECT_EQ(*builder.exact_node("plain"), *builder.node("plain"));
  EXPECT_EQ(*builder.filtered_node("long"), *builder.node("long"));
  for (const char* const name : {"unsaid", "long"}) {
    EXPECT_EQ(node(builder.exact_node(name)).filter, TexelFilter::kBilinear);
    EXPECT_EQ(node(builder.exact_node(name)).image, node(builder.node("plain")).image);
  }
  EXPECT_EQ(node(builder.filtered_node("plain")).filter, TexelFilter::kEwa);
  EXPECT_EQ(node(builder.filtered_node("near")).filter, TexelFilter::kNearest);
  // Through what is made of images.
  const int half = *builder.exact_node("half"),
            input = table_.nodes[static_cast<std::size_t>(half)].inputs[0];
  EXPECT_NE(half, *builder.node("half"));
  EXPECT_EQ(input, *builder.exact_node("unsaid"));
  EXPECT_EQ(*builder.exact_node("half"), half);
  // The file is read once for texels and once for a pyramid, which replaces them.
  BlobsInMemory blobs({{"a", one_texel(1, 2, 3)}});
  ASSERT_EQ(images_.decode(blobs.source, 2), absl::OkStatus());
  EXPECT_THAT(blobs.asked(), ElementsAre("a", "a"));
  EXPECT_EQ(node(builder.node("plain")).image->texels32.size(), 4u);
  EXPECT_TRUE(node(builder.node("unsaid")).image->texels32.empty());
  EXPECT_EQ(node(builder.node("unsaid")).image->pyramid.levels.size(), 1u);
}

TEST_F(TextureBuilderTest, AnImageThatIsNotThereIsNamed) {
  ASSERT_EQ(build("textures { name: 'wood' image { image { digest: 'w' path: 'wood.png' } } }"),
            absl::OkStatus());
  ASSERT_TRUE(builder_.node("wood").ok());
  BlobsInMemory none;
  EXPECT_THAT(std::string(images_.decode(none.source, 1).message()),
              HasSubstr("image 'wood.png': there is no blob w"));
}

TEST_F(TextureBuilderTest, AScaledNodeIsAProduct) {
  ASSERT_EQ(build("textures { name: 'clouds' noise {} }"), absl::OkStatus());
  const int clouds = *builder_.node("clouds");
  const TextureNode& product = table_.nodes[static_cast<std::size_t>(builder_.scaled(clouds, 0.25f))];
  EXPECT_EQ(product.kind, TextureKind::kScale);
  EXPECT_EQ(product.inputs[0], clouds);
  EXPECT_EQ(table_.nodes[static_cast<std::size_t>(product.inputs[1])].value[0], 0.25f);
}

TEST_F(TextureBuilderTest, BoundsTexturesOfTextures) {
  // The last comes first, so that building it asks for all others.
  const auto chain = [](int count, const char* second) {
    std::string text;
    for (int i = count; i > 0; --i)
      absl::StrAppend(
          &text, "textures { name: 't", i, "' scale { value { texture: 't", i - 1, "' } ",
          second == nullptr ? std::string() : absl::StrCat(second, " { texture: 't", i - 1, "' }"), " } } ");
    return text + "textures { name: 't0' noise {} }";
  };
  EXPECT_THAT(refusal(chain(100'000, nullptr)), HasSubstr("more than 64 textures within one another"));
  EXPECT_THAT(refusal(chain(40, "factor")), HasSubstr("it takes more than 4096 look-ups"));
}

TEST_F(TextureBuilderTest, NamesTheTextureAtFault) {
  EXPECT_THAT(refusal("textures { name: 't' noise {} } textures { name: 't' noise {} }"),
              HasSubstr("texture 't': the name is used twice"));
  EXPECT_THAT(
      refusal("textures { name: 't' scale { value { texture: 'u' } } } textures { name: 'u' scale { value { "
              "texture: 't' } } }"),
      HasSubstr("texture 't': it refers to itself"));
  EXPECT_THAT(refusal("textures { name: 't' scale { value { texture: 'u' } } }"),
              HasSubstr("texture 't': texture 'u' does not exist"));
  EXPECT_THAT(refusal("textures { name: 't' }"), HasSubstr("texture 't': its kind is missing"));
  EXPECT_THAT(refusal("textures { name: 't' noise { octaves: 65 } }"), HasSubstr("65 octaves, more than 64"));
  EXPECT_THAT(refusal("textures { name: 't' direction_mix { direction {} } }"),
              HasSubstr("direction is zero"));
  EXPECT_THAT(refusal("textures { name: 't' image { scale: nan } }"), HasSubstr("scale is not finite"));
  for (const char* const anisotropy : {"0.5", "65", "nan", "-1"}) {
    EXPECT_THAT(refusal(absl::StrCat("textures { name: 't' image { max_anisotropy: ", anisotropy, " } }")),
                HasSubstr("1 to 64 was expected"));
  }
  EXPECT_THAT(std::string(builder_.node("none").status().message()),
              HasSubstr("texture 'none' does not exist"));
}

class MeshAttributesTest : public testing::Test {
 protected:
  MeshAttributesTest() {
    textures_.attribute_names = 2;
    shapes_.shapes.resize(3);
    ShapeRecord& quad = shapes_.shapes[2];
    quad.first_triangle = 1;
    quad.triangle_count = 2;
    quad.vertex_count = 4;
    shapes_.triangles.insert(shapes_.triangles.end(), {9, 9, 9, 0, 1, 2, 0, 2, 3});
  }
  absl::Status add(const std::string& mesh) {
    return attributes_.add(message<v1::TriangleMesh>(mesh), shapes_, 2);
  }

  const std::map<std::string, int> names_{{"dirt", 0}, {"rust", 1}};
  BlobsInMemory blobs_{{{"four", bytes_of<float>({1, 2, 3, 4})}, {"nan", bytes_of<float>({1, NAN})}}};
  ShapeTable shapes_;
  TextureTable textures_;
  MeshAttributes attributes_{names_, blobs_.source, textures_};
};

TEST_F(MeshAttributesTest, VertexValuesBecomeThoseOfCorners) {
  ASSERT_EQ(add("attributes { name: 'rust' blob { digest: 'four' } channels: 1 }"), absl::OkStatus());
  EXPECT_THAT(textures_.attribute_of_shape, ElementsAre(-1, -1, -1, -1, -1, 0));
  EXPECT_THAT(textures_.attributes[0].values, ElementsAre(1, 2, 3, 1, 3, 4));
}

TEST_F(MeshAttributesTest, WhatNoTextureLooksUpIsNotRead) {
  EXPECT_EQ(add("attributes { name: 'paint' blob { digest: 'four' } channels: 1 }"), absl::OkStatus());
  EXPECT_TRUE(blobs_.asked().empty());
}

TEST_F(MeshAttributesTest, NamesTheAttributeAtFault) {
  const auto refusal = [&](const char* mesh) { return std::string(add(mesh).message()); };
  EXPECT_THAT(refusal("attributes { name: 'dirt' blob { digest: 'none' } channels: 1 }"),
              HasSubstr("attribute 'dirt': there is no blob none"));
  EXPECT_THAT(refusal("attributes { name: 'dirt' blob { digest: 'four' } channels: 3 }"),
              HasSubstr("16 bytes are not 4 values of 3 channels"));
  EXPECT_THAT(refusal("attributes { name: 'dirt' blob { digest: 'nan' } channels: 1 per_face: true }"),
              HasSubstr("attribute 'dirt': a value is not finite"));
}

}  // namespace
}  // namespace tessera::render
