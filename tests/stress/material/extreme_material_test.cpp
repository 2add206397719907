// Parameters at and beyond the ends of their range, for every kind of material: a finite picture, or an error
// that names the material.
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "support/picture/scene_file.h"

namespace tessera::test {
namespace {

constexpr const char* kScene = R"( film { width: 16 height: 16 filter { kind: BOX } }
  camera { perspective { fov_degrees: 40 } }
  lights { infinite { radiance { rgb { r: 0.5 g: 1 b: 2 } } } }
  lights { point { position { x: 3 y: 3 z: 0 } intensity { constant: 20 } } }
  shapes { sphere { radius: 1.2 } material: 'm'
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,4, 0,0,0,1] } }
  shapes { disk { radius: 5 } material: 'm'
    world_from_object { elements: [1,0,0,0, 0,0,-1,-1.3, 0,1,0,4, 0,0,0,1] } } )";

/// Every kind of material; ROUGH stands for a number or a texture, ETA for an index.
struct Kind {
  const char* name;
  const char* material;
};
constexpr Kind kKinds[] = {
    {"conductor",
     "conductor { roughness { u { ROUGH } v { ROUGH } } eta { constant { constant: ETA } } k { constant { "
     "constant: 2 "
     "} } }"},
    {"conductor_k",
     "conductor { roughness { u { ROUGH } v { constant: 0.2 } } eta { constant { constant: 0.5 } } k { "
     "constant { "
     "constant: ETA } } }"},
    {"metal",
     "conductor { roughness { u { ROUGH } v { ROUGH } distribution: BECKMANN } reflectance { constant { "
     "constant: ETA "
     "} } }"},
    {"dielectric", "dielectric { roughness { u { ROUGH } v { ROUGH } } eta { constant: ETA } }"},
    {"dielectric_turned",
     "dielectric { roughness { u { ROUGH } v { constant: 0.5 } separable_masking: true } eta { constant: ETA "
     "} }"},
    {"dielectric_single",
     "dielectric { roughness { u { ROUGH } v { ROUGH } multiple_scattering: false distribution: BECKMANN } "
     "eta { "
     "constant: ETA } }"},
    {"thin_dielectric", "thin_dielectric { eta { constant: ETA } }"},
    {"coated_diffuse", "coated_diffuse { roughness { u { ROUGH } v { ROUGH } } eta { constant: ETA } }"},
    {"plastic", "plastic { roughness { u { ROUGH } v { ROUGH } } eta { constant: ETA } nonlinear: true }"},
    {"coated_conductor",
     R"(coated_conductor { roughness { u { ROUGH } v { ROUGH } } eta { constant: ETA } thickness: 0.1
       conductor { roughness { u { ROUGH } v { ROUGH } } reflectance { constant { constant: 0.8 } } } })"},
    {"hair", "hair { eta: ETA beta_m { ROUGH } beta_n { ROUGH } alpha_degrees: 2 }"},
    {"principled",
     "principled { eta: ETA roughness { ROUGH } anisotropic { ROUGH } spec_trans { constant: 0.5 } clearcoat "
     "{ ROUGH } "
     "}"},
    {"principled_parts",
     "principled { roughness { constant: 0.3 } metallic { ROUGH } spec_trans { ROUGH } sheen { ROUGH } "
     "flatness { "
     "ROUGH } clearcoat_gloss { ROUGH } }"},
    {"principled_thin",
     "principled { thin: true eta: ETA roughness { ROUGH } spec_trans { constant: 0.5 } diff_trans { ROUGH } "
     "}"},
    {"diffuse", "diffuse { reflectance { constant { constant: ETA } } }"},
    {"diffuse_transmission",
     "diffuse_transmission { reflectance { constant { constant: ETA } } transmittance { constant { constant: "
     "ETA } } "
     "}"},
};

/// The outcome of one scene: an error must name the material, a picture must be finite and have lost no
/// sample.
void expect_sound(const std::string& text, const TestBlobs& blobs, int& pictures) {
  test::SceneJob job;
  job.settings.set_spp(16);
  job.settings.set_max_depth(8);
  v1::Scene parsed;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &parsed)) << text;
  const auto file = load_scene_text(text, job, render::supported_isas().front(), blobs);
  if (!file.ok()) {
    EXPECT_TRUE(absl::StrContains(file.status().message(), "'m'") ||
                absl::StrContains(file.status().message(), "materials"))
        << file.status();
    return;
  }
  ++pictures;
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({0, 0, 16, 16, 0, 16}, {}, stats);
  ASSERT_TRUE(tile.ok()) << tile.status();
  EXPECT_EQ(stats.dropped_samples, 0u);
  for (const float value : tile->values) ASSERT_TRUE(std::isfinite(value));
}

class ExtremeMaterial : public testing::TestWithParam<Kind> {
 protected:
  static std::string scene(const std::string& rough, const std::string& eta) {
    return absl::StrCat(kScene, "materials { name: 'm' ",
                        absl::StrReplaceAll(GetParam().material, {{"ROUGH", rough}, {"ETA", eta}}), " }");
  }
};

TEST_P(ExtremeMaterial, ConstantsGiveAPictureOrAnError) {
  int pictures = 0;
  for (const char* rough :
       {"0", "1e-42", "1e-8", "0.00099", "0.001", "0.3", "1", "1.5", "1e6", "-0.1", "nan", "inf"}) {
    for (const char* eta : {"1.5", "1"}) {
      SCOPED_TRACE(absl::StrCat("roughness ", rough, ", eta ", eta));
      expect_sound(scene(absl::StrCat("constant: ", rough), eta), {}, pictures);
    }
  }
  for (const char* eta : {"1.000001", "0.999999", "0", "-0", "-1", "1e-42", "1e-30", "1e-3", "0.5", "100",
                          "1e6", "1e30", "inf", "nan"}) {
    for (const char* rough : {"0", "0.3"}) {
      SCOPED_TRACE(absl::StrCat("roughness ", rough, ", eta ", eta));
      expect_sound(scene(absl::StrCat("constant: ", rough), eta), {}, pictures);
    }
  }
  EXPECT_GT(pictures, 10);
}

TEST_P(ExtremeMaterial, TexturesGiveAPicture) {
  // Every texel another bad number.
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const float values[16] = {0,    -0.0f, 1e-42f, 1e-8f,  9.9e-4f, 0.3f, 1,    1.5f,
                            1e6f, 3e38f, -0.1f,  -3e38f, nan,     inf,  -inf, 0.7f};
  std::string pfm = "Pf\n16 1\n-1.0\n";
  pfm.append(reinterpret_cast<const char*>(values), sizeof(values));
  const std::string texture =
      "textures { name: 'r' image { image { digest: 'map' path: 'map.pfm' } encoding: LINEAR filter: NEAREST "
      "mapping { "
      "scale_u: 3 } } } ";
  int pictures = 0;
  expect_sound(texture + scene("texture: 'r'", "1.5"), {{"map", pfm}}, pictures);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ExtremeMaterial, testing::ValuesIn(kKinds),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tessera::test
