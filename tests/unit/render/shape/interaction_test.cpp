// From materials to BSDFs: sides, mixes, bent normals.
#include "render/integrator/interaction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/color/mip_pyramid.h"

namespace tessera::render::TESSERA_ISA {
namespace {

MaterialRecord diffuse(float reflectance) {
  MaterialRecord record;
  for (float& v : record.spectra[0].value) v = reflectance;
  return record;
}

MaterialRecord mix(int a, int b, float amount) {
  MaterialRecord record;
  record.kind = BsdfKind::kMix;
  record.flags = kMixed;
  record.mix_a = a, record.mix_b = b;
  record.scalars[0].value = amount;
  return record;
}

/// A point of the plane z = 0 with material 0.
Surface surface() {
  Surface s{};
  s.p = {Float(0.0f), Float(0.0f), Float(0.0f)};
  s.ng = s.ns = {Float(0.0f), Float(0.0f), Float(1.0f)};
  s.uv = {Float(0.5f), Float(0.5f)};
  s.dpdu = {Float(1.0f), Float(0.0f), Float(0.0f)};
  s.dpdv = {Float(0.0f), Float(1.0f), Float(0.0f)};
  s.material = Int(0);
  return s;
}

Vec3 unit(float x, float y, float z) {
  const float l = std::sqrt(x * x + y * y + z * z);
  return {Float(x / l), Float(y / l), Float(z / l)};
}

class InteractionTest : public testing::Test {
 protected:
  /// f |cos| of light from wi to wo; `u` picks parts of mixes of mixes.
  float f_cos(Vec3 wo, Vec3 wi, float u = 0.5f) {
    Interaction at;
    interact(scene_, surface(), wo, Float(u), Spectra(), Mask::all(), at);
    return eval_bsdf(at, wo, wi, Mask::all()).f_cos.c[0].lane(0);
  }

  SceneArrays arrays_;
  SceneTables scene_{arrays_};
  const Vec3 above_ = unit(0.3f, 0, 1), above2_ = unit(-0.2f, 0.4f, 1), below_ = unit(0.3f, 0, -1),
             below2_ = unit(-0.2f, 0.4f, -1);
  const float cos_over_pi_ = above2_.z.lane(0) / 3.14159265f;
  static constexpr float kRounding = 1e-6f;
};

TEST_F(InteractionTest, LambertianPacketsHaveTheSameBitsAsAnyOther) {
  arrays_.materials.materials = {diffuse(0.7f)};
  Surface bent = surface();
  bent.ns = unit(0.1f, -0.2f, 1);
  Interaction at;
  interact(scene_, bent, above_, Float(0.5f), Spectra(), Mask::all(), at);
  ASSERT_TRUE(at.lambertian);
  for (const Vec3& wi : {above2_, below2_}) {
    const BsdfEval quick = eval_bsdf(at, above_, wi, Mask::first(15)),
                   any_kind = eval_any_bsdf(at, above_, wi, Mask::first(15), Transport::kImportance);
    for (int i = 0; i < kWidth; ++i) {
      EXPECT_EQ(quick.f_cos.c[1].lane(i), any_kind.f_cos.c[1].lane(i));
      EXPECT_EQ(quick.pdf.lane(i), any_kind.pdf.lane(i));
    }
  }
}

TEST_F(InteractionTest, PacketsWithAnotherMaterialAreNotLambertian) {
  MaterialRecord glass;
  glass.kind = BsdfKind::kInterface;
  arrays_.materials.materials = {diffuse(0.7f), glass};
  Surface s = surface();
  s.material = select(Mask::first(15), Int(0), Int(1));
  Interaction at;
  interact(scene_, s, above_, Float(0.5f), Spectra(), Mask::all(), at);
  EXPECT_FALSE(at.lambertian);
  interact(scene_, s, above_, Float(0.5f), Spectra(), Mask::first(15), at);
  EXPECT_TRUE(at.lambertian);
}

TEST_F(InteractionTest, OneSidedMaterialsAreBlackFromBehind) {
  arrays_.materials.materials = {diffuse(0.5f)};
  EXPECT_NEAR(f_cos(below_, below2_), 0.5f * cos_over_pi_, kRounding);
  arrays_.materials.materials[0].flags |= kOneSided;
  EXPECT_NEAR(f_cos(above_, above2_), 0.5f * cos_over_pi_, kRounding);
  EXPECT_EQ(f_cos(below_, below2_), 0);
  Interaction at;
  interact(scene_, surface(), below_, Float(0.5f), Spectra(), Mask::all(), at);
  EXPECT_TRUE(none(sample_bsdf(at, below_, Float(0.5f), {Float(0.5f), Float(0.3f)}, Mask::all()).valid));
}

TEST_F(InteractionTest, TheBackIsSeenFromBehind) {
  scene_.any_mix = true;
  arrays_.materials.materials = {diffuse(0.5f), diffuse(0.25f)};
  MaterialRecord &front = arrays_.materials.materials[0], &back = arrays_.materials.materials[1];
  front.flags |= kOneSided | kHasBack;
  front.back = 1;
  back.flags |= kOneSided;  // the front of `back`, which is turned to the back here
  EXPECT_NEAR(f_cos(above_, above2_), 0.5f * cos_over_pi_, kRounding);
  EXPECT_NEAR(f_cos(below_, below2_), 0.25f * cos_over_pi_, kRounding);
}

TEST_F(InteractionTest, MixesAddTheirParts) {
  scene_.any_mix = true;
  arrays_.materials.materials = {mix(1, 2, 0.25f), diffuse(0.8f), diffuse(0.4f)};
  EXPECT_NEAR(f_cos(above_, above2_), (0.75f * 0.8f + 0.25f * 0.4f) * cos_over_pi_, kRounding);
  Interaction at;
  interact(scene_, surface(), above_, Float(0.5f), Spectra(), Mask::all(), at);
  EXPECT_NE(at.flags.lane(0) & kMixed, 0);
  // Either part, with weight and density of both.
  for (const float u_lobe : {0.1f, 0.9f}) {
    const BsdfSample s = sample_bsdf(at, above_, Float(u_lobe), {Float(0.6f), Float(0.3f)}, Mask::all());
    const BsdfEval e = eval_bsdf(at, above_, s.wi, Mask::all());
    EXPECT_NEAR(s.pdf.lane(0), e.pdf.lane(0), kRounding);
    EXPECT_NEAR(s.weight.c[0].lane(0), 0.7f, kRounding);
  }
}

TEST_F(InteractionTest, DeltaPartsOfMixesKeepTheirOwnWeight) {
  scene_.any_mix = true;
  MaterialRecord glass;
  glass.kind = BsdfKind::kInterface;
  glass.flags = kAllDelta;
  arrays_.materials.materials = {mix(1, 2, 0.25f), diffuse(0.8f), glass};
  EXPECT_NEAR(f_cos(above_, above2_), 0.75f * 0.8f * cos_over_pi_, kRounding);
  Interaction at;
  interact(scene_, surface(), above_, Float(0.5f), Spectra(), Mask::all(), at);
  EXPECT_EQ(at.flags.lane(0) & kAllDelta, 0);
  const BsdfSample through = sample_bsdf(at, above_, Float(0.2f), {Float(0.6f), Float(0.3f)}, Mask::all());
  EXPECT_TRUE(all(through.specular & through.transmission & through.valid));
  EXPECT_EQ(through.weight.c[0].lane(0), 1);
  EXPECT_EQ(through.wi.z.lane(0), -above_.z.lane(0));
  const BsdfSample spread = sample_bsdf(at, above_, Float(0.3f), {Float(0.6f), Float(0.3f)}, Mask::all());
  EXPECT_TRUE(none(spread.specular));
  EXPECT_NEAR(spread.weight.c[0].lane(0), 0.8f, kRounding);
}

TEST_F(InteractionTest, MixesOfMixesPickAPartOfEach) {
  scene_.any_mix = true;
  arrays_.materials.materials = {mix(1, 4, 0.5f), mix(2, 3, 0.25f), diffuse(0.8f), diffuse(0.4f),
                                 diffuse(0.2f)};
  EXPECT_NEAR(f_cos(above_, above2_, 0.2f), 0.5f * (0.4f + 0.2f) * cos_over_pi_, kRounding);
  EXPECT_NEAR(f_cos(above_, above2_, 0.3f), 0.5f * (0.8f + 0.2f) * cos_over_pi_, kRounding);
}

TEST_F(InteractionTest, BumpsTiltTheNormalAndShadowThemselves) {
  // A slope of 0.5 along u: two texels, 0 and 0.25, half a unit of u apart.
  auto image = std::make_shared<TextureImage>();
  image->width = 2, image->height = 1;
  image->texels32 = {0, 0, 0, 1, 0.25f, 0.25f, 0.25f, 1};
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = image;
  arrays_.textures.nodes = {node};
  scene_.any_tangents = true;
  arrays_.materials.materials = {diffuse(1)};
  MaterialRecord& bumpy = arrays_.materials.materials[0];
  bumpy.flags |= kHasBump | kBendsSoftly;
  bumpy.bump_texture = 0;
  bumpy.bump_step = 1.0f / 64;

  Interaction at;
  interact(scene_, surface(), above_, Float(0.5f), Spectra(), Mask::all(), at);
  const float nz = 1 / std::sqrt(1.25f);
  EXPECT_NEAR(at.frame.z.x.lane(0), -0.5f * nz,
              1e-5f);  // differences over 1/64 of values that are right to 6e-8
  EXPECT_NEAR(at.frame.z.z.lane(0), nz, 1e-5f);
  // tan^2 of the tilt is 0.25, so alpha^2 = 1/32 [Estevez et al. 2019].
  const float z = above2_.z.lane(0), tan2 = (1 - z * z) / (z * z);
  const float shadow = 2 / (1 + std::sqrt(1 + tan2 / 32));
  const float cosine = (-0.5f * above2_.x.lane(0) + z) * nz;
  EXPECT_NEAR(f_cos(above_, above2_), shadow * cosine / 3.14159265f, 1e-5f);
  // Light from below the surface does not get through, though it is above the bent one.
  const Vec3 grazing = unit(-1, 0, -0.1f);
  EXPECT_EQ(f_cos(above_, grazing), 0);

  // pbrt's bumps only bend the normal.
  bumpy.flags &= ~kBendsSoftly;
  EXPECT_NEAR(f_cos(above_, above2_), cosine / 3.14159265f, 1e-5f);
}

TEST_F(InteractionTest, BumpsHaveTheSlopeOfWhatAPixelCovers) {
  // Heights rise by 1/64 a texel, with a ripple of 1/4 from texel to texel. The camera is 8 above.
  TextureImage image;
  image.width = image.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    const float height = static_cast<float>(i % 64) / 64 + 0.25f * static_cast<float>(i % 2);
    image.texels32.insert(image.texels32.end(), {height, height, height, 1});
  }
  ASSERT_TRUE(make_pyramid(image, "ripple").ok());
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.filter = TexelFilter::kEwa;
  node.image = std::make_shared<const TextureImage>(std::move(image));
  arrays_.textures.nodes = {node};
  scene_.any_tangents = scene_.any_filtered = true;
  scene_.footprint.on = true;
  for (int i = 0; i < 3; ++i) scene_.footprint.x[i] = i == 0, scene_.footprint.y[i] = i == 1;
  scene_.footprint.z[2] = -1, scene_.footprint.place[2] = 8;
  arrays_.materials.materials = {diffuse(1)};
  arrays_.materials.materials[0].flags |= kHasBump;
  arrays_.materials.materials[0].bump_texture = 0;
  arrays_.materials.materials[0].bump_step = 0.0005f;
  const auto slope_along_u = [&](float half_axis) {
    scene_.footprint.spread_x = scene_.footprint.spread_y = half_axis / 8;
    Interaction at;
    interact(scene_, surface(), above_, Float(0.5f), Spectra(), Mask::all(), at);
    return -at.frame.z.x.lane(3) / at.frame.z.z.lane(3);
  };
  // Averages of 8 texels, without the ripple: the step of 2 texels is along the slope of 1.
  EXPECT_NEAR(slope_along_u(4.0f / 64), 1, 1e-4);
  // Far below a texel, from one to the next at u = 1/2: the ripple, down by 1/4, and up by 1/64.
  EXPECT_NEAR(slope_along_u(0.01f / 64), 1 + 64 * 0.25f * -1, 0.1);
  // Without a camera to see it, over the record's step.
  scene_.footprint.on = false;
  Interaction at;
  interact(scene_, surface(), above_, Float(0.5f), Spectra(), Mask::all(), at);
  EXPECT_NEAR(-at.frame.z.x.lane(3) / at.frame.z.z.lane(3), 1 - 16, 0.1);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
