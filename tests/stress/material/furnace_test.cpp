// White furnaces: what stands in a uniform light of radiance 1 and absorbs nothing is not seen. And what
// loses energy by the definition of its format loses just that.
#include <gtest/gtest.h>

#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/boundary_scatter.h"
#include "render/bsdf/tables/boundary_energy.h"
#include "support/picture/render_image.h"

namespace tessera::test {
namespace {

constexpr const char* kFurnace =
    "lights { infinite { radiance { constant: 1 } } } film { width: 32 height: 32 filter { kind: BOX } } ";

/// The film's pixels, R only; light is found by scattering alone, so that nothing but the materials makes
/// noise.
std::vector<double> render(const std::string& scene, std::uint32_t spp, std::uint32_t max_depth) {
  test::SceneJob job;
  job.settings.set_spp(spp);
  job.settings.set_max_depth(max_depth);
  job.settings.set_direct_light(v1::DIRECT_LIGHT_BSDF);
  const auto file = load_scene_text(absl::StrCat(kFurnace, scene), job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  const client::Image image = render_image(*file);
  const client::Channel* red = image.find("R");
  return red == nullptr ? std::vector<double>() : std::vector<double>(red->values.begin(), red->values.end());
}

double mean(const std::vector<double>& pixels) {
  double sum = 0;
  for (const double p : pixels) sum += p;
  return sum / static_cast<double>(pixels.size());
}

/// Standard error of the mean of pixels that are all alike but for noise.
double standard_error(const std::vector<double>& pixels) {
  double squares = 0;
  for (const double p : pixels) squares += (p - mean(pixels)) * (p - mean(pixels));
  return std::sqrt(squares) / static_cast<double>(pixels.size());
}

/// A ball that fills most of the picture.
std::string ball(const std::string& material) {
  return absl::StrCat(
      "camera { perspective { fov_degrees: 40 } } materials { name: 'm' ", material,
      " } shapes { sphere { radius: 1.2 } material: 'm' world_from_object { elements: [1,0,0,0, "
      "0,1,0,0, 0,0,1,4, 0,0,0,1] } }");
}

/// A cup with its opening to the camera: light goes to and fro in it.
std::string cup(const std::string& material) {
  return absl::StrCat(
      "camera { perspective { fov_degrees: 40 } } materials { name: 'm' ", material,
      " } shapes { cylinder { radius: 1.2 z_min: 0 z_max: 4 } material: 'm' world_from_object { "
      "elements: [1,0,0,0, 0,1,0,0, 0,0,1,4, 0,0,0,1] } }"
      " shapes { disk { radius: 1.2 } material: 'm' world_from_object { elements: [1,0,0,0, 0,1,0,0, "
      "0,0,1,8, 0,0,0,1] } }");
}

std::string roughness(double u, double v, const std::string& more = "") {
  return absl::StrCat(" roughness { u { constant: ", u, " } v { constant: ", v, " } ", more, " }");
}
/// eta = 0: reflects all.
std::string white_metal(const std::string& rough) {
  return absl::StrCat("conductor { eta { constant { constant: 0 } } k { constant { constant: 1 } } ", rough,
                      " }");
}
std::string glass(double eta, const std::string& rough) {
  return absl::StrCat("dielectric { eta { constant: ", eta, " } ", rough, " }");
}

TEST(Furnace, DiffuseSurfacesVanish) {
  // All weights are 1, up to a rounding of 6e-8 each: every pixel is 1, and the number of bounces is all but
  // unlimited.
  for (const std::string& scene : {ball("diffuse { reflectance { constant { constant: 1 } } }"),
                                   cup("diffuse { reflectance { constant { constant: 1 } } }"),
                                   cup("diffuse_transmission { reflectance { constant { constant: 0.5 } } "
                                       "transmittance { constant { constant: 0.5 } } }")}) {
    for (const double pixel : render(scene, 64, 2000)) ASSERT_NEAR(pixel, 1, 1e-4);
  }
}

struct Microfacets {
  const char* name;
  std::string scene;
};
class MicrofacetFurnace : public testing::TestWithParam<Microfacets> {};

TEST_P(MicrofacetFurnace, Vanish) {
  // No more can be asked of a mean than its noise allows: inside of rough glass weights multiply, bounce by
  // bounce.
  const std::vector<double> pixels = render(GetParam().scene, 1024, 1000);
  ASSERT_FALSE(pixels.empty());
  EXPECT_LT(standard_error(pixels), 7e-4);
  EXPECT_NEAR(mean(pixels), 1, 2e-3);
}

INSTANTIATE_TEST_SUITE_P(
    Balls, MicrofacetFurnace,
    testing::Values(
        Microfacets{"SmoothMetal", ball(white_metal(""))},
        Microfacets{"Metal01", ball(white_metal(roughness(0.1, 0.1)))},
        Microfacets{"Metal05", ball(white_metal(roughness(0.5, 0.5)))},
        Microfacets{"Metal1", ball(white_metal(roughness(1, 1)))},
        Microfacets{"MetalTurned", ball(white_metal(roughness(0.1, 0.7)))},
        Microfacets{"MetalBeckmann", ball(white_metal(roughness(0.5, 0.5, "distribution: BECKMANN")))},
        Microfacets{"MetalSeparable", ball(white_metal(roughness(0.5, 0.5, "separable_masking: true")))},
        Microfacets{"MetalCup", cup(white_metal(roughness(0.15, 0.15)))},
        Microfacets{"SmoothGlass", ball(glass(1.5, ""))},
        Microfacets{"Glass01", ball(glass(1.5, roughness(0.1, 0.1)))},
        Microfacets{"Glass03", ball(glass(1.5, roughness(0.3, 0.3)))},
        Microfacets{"GlassDense", ball(glass(1.8, roughness(0.15, 0.15)))},
        Microfacets{"GlassThin", ball(glass(1.1, roughness(0.3, 0.3)))},
        Microfacets{"GlassTurned", ball(glass(1.5, roughness(0.1, 0.3)))},
        Microfacets{"Bubble", ball(glass(0.75, roughness(0.3, 0.3)))}),
    [](const auto& test) { return test.param.name; });

TEST(Furnace, TexturedRoughnessVanishesToo) {
  const std::string textured = R"( roughness { u { texture: 'r' } v { texture: 'r' } } )";
  const std::string texture =
      R"(textures { name: 'r' checkerboard { even { constant { constant: 0.1 } }
        odd { constant { constant: 0.3 } }
                                                                     mapping { scale_u: 9 scale_v: 9 } } } )";
  for (const std::string& material : {white_metal(textured), glass(1.5, textured)}) {
    // Between the rows of the table, which stand for 25 roughnesses, a little more may be off.
    EXPECT_NEAR(mean(render(texture + ball(material), 1024, 1000)), 1, 3e-3) << material;
  }
}

TEST(Furnace, ColouredMetalLosesLittleByRoughness) {
  // Nearly all of gold's red comes back however rough it is; much of its blue is absorbed, and twice by what
  // scatters twice: the energy stays between what single scattering keeps and the smooth metal's.
  const auto gold = [](const std::string& rough) {
    return ball(absl::StrCat("conductor { reflectance { constant { constant: 0.6 } } ", rough, " }"));
  };
  const double smooth = mean(render(gold(""), 256, 1000)),
               rough = mean(render(gold(roughness(1, 1)), 256, 1000));
  const double single = mean(render(gold(roughness(1, 1, "multiple_scattering: false")), 256, 1000));
  EXPECT_LT(rough, smooth - 0.01);
  EXPECT_GT(rough, single + 0.05);
}

/// A disk across all of the view of an orthographic camera, its normal turned by `degrees` from the line of
/// sight.
std::string sheet(const std::string& material, double degrees) {
  const double c = std::cos(degrees * M_PI / 180), s = std::sin(degrees * M_PI / 180);
  return absl::StrCat(
      "camera { orthographic { } screen_window: [-0.1, 0.1, -0.1, 0.1] } materials { name: 'm' ", material,
      " } shapes { disk { radius: 9 } material: 'm' world_from_object { elements: [", c, ",0,", -s,
      ",0, 0,1,0,0, ", s, ",0,", c, ",20, 0,0,0,1] } }");
}

struct Loss {
  const char* name;
  std::string flags;
  render::BoundaryFacets facets;
};

TEST(Furnace, ModelsOfOtherFormatsLoseWhatTheirDefinitionLoses) {
  // Seen from either side of the disk: what is reflected, and what is refracted with radiance divided by
  // eta^2. 2^20 even samples of weights up to 1 against quadrature over 4181 points: 1e-3 is what either may
  // be off.
  const Loss models[] = {
      {"pbrt", "multiple_scattering: false", {0.6}},
      {"Mitsuba GGX", "multiple_scattering: false separable_masking: true", {0.6, false, true}},
      {"Mitsuba Beckmann",
       "multiple_scattering: false separable_masking: true distribution: BECKMANN",
       {0.6, true, true}}};
  for (const Loss& model : models) {
    // The masking of Beckmann's facets is approximate, its samples are not.
    const double tolerance = model.facets.beckmann ? 5e-3 : 1e-3;
    for (const double degrees : {0.0, 60.0, 120.0}) {
      SCOPED_TRACE(absl::StrCat(model.name, " at ", degrees));
      const double cosine = std::abs(std::cos(degrees * M_PI / 180));
      // Light rays meet the disk from the side of its normal for angles beyond 90 degrees.
      const double eta = degrees > 90 ? 1.5 : 1 / 1.5;
      const render::BoundaryEnergy energy =
          render::boundary_energy(cosine, model.facets, eta, render::Quadrature::kFine);
      const double seen = mean(render(sheet(glass(1.5, roughness(0.6, 0.6, model.flags)), degrees), 1024, 4));
      EXPECT_NEAR(seen, energy.reflected + energy.transmitted / (eta * eta),
                  tolerance * std::max(1.0, 1 / (eta * eta)));

      double kept = 0;
      const render::ScatteringFacets facets{0.6, 0.6, model.facets.beckmann, model.facets.separable_masking};
      const render::HalfDisk disk(4181, 2584);
      render::scatter_once(std::sqrt(1 - cosine * cosine), 0, cosine, facets, 0, disk.points, false,
                           [&](double, double, double, double part) { kept += part; });
      EXPECT_NEAR(mean(render(sheet(white_metal(roughness(0.6, 0.6, model.flags)), degrees), 1024, 4)), kept,
                  tolerance);
    }
  }
}

}  // namespace
}  // namespace tessera::test
