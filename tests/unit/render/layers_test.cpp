// Layers of rendered pictures: partitions add up, both notations are one, and what a layer holds is what its
// expression says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"
#include "wire/algorithm.h"

namespace tessera::test::layers_of_pictures {
namespace {

using Layers = std::vector<std::pair<std::string, std::string>>;

constexpr std::uint32_t kSide = 32;

std::string ball(const char* name, const char* material, double x, double y, double z, double radius) {
  return absl::StrCat(" shapes { name: '", name, "' sphere { radius: ", radius, " } material: '", material,
                      "' world_from_object { elements: [1,0,0,", x, ",0,1,0,", y, ",0,0,1,", z,
                      ",0,0,0,1] } }");
}

/// A floor in white paint seen from above, along -y.
const char* const kFloor =
    "camera { perspective { fov_degrees: 50 } world_from_camera { elements: [1,0,0,0, 0,0,-1,4, 0,1,0,0, "
    "0,0,0,1] } } "
    "materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } } "
    "shapes { name: 'floor' disk { radius: 9 } material: 'white' world_from_object { elements: [1,0,0,0, "
    "0,0,1,0, 0,-1,0,0, 0,0,0,1] } } ";

const char* const kMaterials =
    "materials { name: 'glass' dielectric { eta { constant: 1.5 } } } "
    "materials { name: 'pane' thin_dielectric { eta { constant: 1.5 } passes_straight: true } } "
    "materials { name: 'brushed' conductor { reflectance { constant { constant: 0.8 } } roughness { u { "
    "constant: 0.3 } v { constant: 0.3 } } } } "
    "materials { name: 'lacquer' coated_diffuse { reflectance { constant { constant: 0.5 } } eta { constant: "
    "1.5 } roughness { u { constant: 0.2 } v { constant: 0.2 } } } } "
    "materials { name: 'plastic' plastic { reflectance { constant { constant: 0.4 } } } } "
    "materials { name: 'varnish' phong { diffuse { constant { constant: 0.4 } } specular { constant { "
    "constant: 0.4 } } exponent { constant: 30 } } } "
    "materials { name: 'disney' principled { base_color { constant { constant: 0.6 } } spec_trans { "
    "constant: 0.3 } sheen { constant: 0.5 } clearcoat { constant: 0.5 } } } "
    "materials { name: 'paper' diffuse_transmission { reflectance { constant { constant: 0.4 } } "
    "transmittance { constant { constant: 0.3 } } } } "
    "materials { name: 'mixed' mix { a: 'varnish' b: 'glass' amount { constant: 0.4 } } } "
    "materials { name: 'lace' diffuse { reflectance { constant { constant: 0.5 } } } opacity { constant: 0.5 "
    "} } ";

const char* const kLights =
    "shapes { name: 'lamp' sphere { radius: 0.2 } material: 'white' area_light { radiance { constant: 40 } "
    "group: 'key' } world_from_object { elements: [1,0,0,0.9, 0,1,0,1.6, 0,0,1,0.9, 0,0,0,1] } } "
    "lights { name: 'spot' point { position { x: -2 y: 3 z: -1 } intensity { constant: 6 } } } "
    "lights { name: 'sky' infinite { radiance { constant: 0.3 } } } ";

/// One ball of each material under three kinds of light.
std::string many_materials() {
  std::string scene = absl::StrCat(kFloor, kMaterials, kLights);
  int i = 0;
  for (const char* material :
       {"glass", "pane", "brushed", "lacquer", "plastic", "varnish", "disney", "paper", "mixed", "lace"}) {
    absl::StrAppend(
        &scene, ball(absl::StrCat("ball ", material).c_str(), material, i % 4 - 1.5, 0.4, i / 4 - 1.0, 0.38));
    ++i;
  }
  return scene;
}

struct Request {
  std::string scene;
  std::string integrator = "path";
  Layers layers = {};
  std::uint32_t spp = 8;
  std::uint32_t max_depth = 6;
  double noise = 0;
  v1::DirectLight direct_light{};
  std::vector<v1::AOV> aovs = {};
};

absl::StatusOr<LoadedFile> load(const Request& request) {
  SceneJob job;
  job.width = job.height = kSide;
  job.settings.set_integrator(request.integrator);
  job.settings.set_spp(request.spp);
  job.settings.set_max_depth(request.max_depth);
  job.settings.set_noise(request.noise);
  job.settings.set_direct_light(request.direct_light);
  job.aovs = request.aovs;
  for (const auto& [name, expression] : request.layers) {
    v1::Layer& layer = *job.settings.add_layers();
    layer.set_name(name);
    layer.set_expression(expression);
  }
  return load_scene_text(request.scene, job, render::supported_isas().front());
}

client::Image picture(const Request& request, std::uint64_t seed = 0) {
  const auto file = load(request);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file, seed) : client::Image{};
}

const std::vector<float>& plane(const client::Image& image, const std::string& name) {
  static const std::vector<float> none(kSide * kSide, std::numeric_limits<float>::quiet_NaN());
  const client::Channel* const channel = image.find(name);
  EXPECT_NE(channel, nullptr) << name;
  return channel == nullptr ? none : channel->values;
}

double mean(const client::Image& image, const std::string& name) {
  double sum = 0;
  for (const float value : plane(image, name)) sum += value;
  return sum / (kSide * kSide);
}

/// A pixel is the mean of n samples, each a sum of light that is nowhere negative. Layers add the same
/// numbers in another order: of at most 7 events with 5 lights each, and 16 samples, every sum is off by
/// fewer than 35 + 16 + 32 roundings of 2^-24, of either side.
constexpr double kRounding = 2 * (35 + 16 + 32) * 0x1p-24;

void expect_partition(const client::Image& image, const Layers& layers, const std::string& what) {
  for (const char* band : {"R", "G", "B"}) {
    const std::vector<float>& whole = plane(image, band);
    std::vector<double> sum(whole.size());
    for (const auto& layer : layers) {
      const std::vector<float>& part = plane(image, absl::StrCat(layer.first, ".", band));
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      ASSERT_NEAR(sum[i], whole[i], kRounding * whole[i]) << what << ", " << band << " of pixel " << i;
  }
}

const Layers kPartitions[] = {
    {{"bounce0", "LE"}, {"bounce1", "L.E"}, {"bounce2", "L.{2}E"}, {"more", "L.{3,}E"}},
    {{"seen", "LE"}, {"diffuse", "L.*DE"}, {"glossy", "L.*GE"}, {"specular", "L.*SE"}, {"fog", "L.*VE"}},
    {{"key", "C.*<L.'key'>"},
     {"spot", "C.*<L.'spot'>"},
     {"sky", "C.*B"},
     {"rest", "C.*<[^B].[^'key' 'spot']>"}},
    {{"pane", "C.*<..m'pane'>.*L"}, {"others", "C[^<..m'pane'>]*L"}},
    {{"floor", "C<..o'floor'>.*L"}, {"other", "C<..o[^'floor']>.*L"}, {"seen", "CL"}},
    {{"caustics", "LS+DE"}, {"rest", "CL|C[^D].*L|CDL|CD[^S].*L|CDS+[^SL].*L"}},
};

class Partitions : public testing::TestWithParam<const char*> {};

TEST_P(Partitions, AddUpToThePicture) {
  Request request{.scene = many_materials(), .integrator = GetParam()};
  const bool media = wire::find_algorithm(GetParam())->media;
  if (media) {
    absl::StrAppend(
        &request.scene,
        "media { name: 'fog' extinction { constant { constant: 0.5 } } albedo { constant { constant: "
        "0.8 } } } materials { name: 'none' interface {} } shapes { name: 'air' sphere { radius: 1.2 "
        "} material: 'none' interior_medium: 'fog' world_from_object { elements: [1,0,0,0, 0,1,0,1, "
        "0,0,1,0, 0,0,0,1] } } ");
  }
  Request plain = request;
  const client::Image alone = picture(plain);
  for (const Layers& partition : kPartitions) {
    request.layers = partition;
    const client::Image image = picture(request);
    expect_partition(image, partition, absl::StrCat(GetParam(), ": ", partition.back().second));
    // And nothing else changes by them.
    for (const char* band : {"R", "G", "B", "A"}) ASSERT_EQ(plane(image, band), plane(alone, band));
    if (media && partition.back().first == "fog") {
      EXPECT_GT(mean(image, "fog.R"), 0.001);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Algorithms, Partitions,
                         testing::Values("path", "volpath", "direct", "whitted", "raycast", "light"),
                         [](const auto& algorithm) { return std::string(algorithm.param); });

TEST(LayersOfPictures, AddUpWhereNoiseDecidesOnSamples) {
  const Layers partition = kPartitions[1];
  const client::Image image =
      picture({.scene = many_materials(), .layers = partition, .spp = 32, .noise = 0.2});
  expect_partition(image, partition, "noise");
}

TEST(LayersOfPictures, AddUpBesideTheItemBuffer) {
  const Layers partition = kPartitions[1];
  const client::Image image = picture({.scene = many_materials(),
                                       .layers = partition,
                                       .spp = 32,
                                       .noise = 0.2,
                                       .aovs = {v1::AOV_ALBEDO, v1::AOV_ID}});
  expect_partition(image, partition, "noise, beside numbers that are not summed");
}

TEST(LayersOfPictures, AreTheSameInBothNotations) {
  for (const char* integrator : {"path", "light"}) {
    const client::Image image = picture(
        {.scene = many_materials(),
         .integrator = integrator,
         .layers = {{"a", "LS+DE"}, {"b", "C<.D><.S>+<L.>"}, {"c", "L(S|D)*E"}, {"d", "C([<.D>S])*L"}}});
    for (const char* band : {".R", ".G", ".B"}) {
      EXPECT_EQ(plane(image, absl::StrCat("a", band)), plane(image, absl::StrCat("b", band)));
      EXPECT_EQ(plane(image, absl::StrCat("c", band)), plane(image, absl::StrCat("d", band)));
    }
    EXPECT_GT(mean(image, "a.R"), 0) << integrator;
  }
}

/// Channels of other layers must not matter for one, nor how samples are cut into units.
TEST(LayersOfPictures, HaveTheSameBitsHoweverSamplesAreCut) {
  const auto file = load({.scene = many_materials(), .layers = {{"a", "L.*DE"}, {"b", "LS+.E"}}, .spp = 16});
  ASSERT_TRUE(file.ok()) << file.status();
  const client::Image whole = render_image(*file);
  render::RenderStats stats;
  auto left = file->scene->render_tile({8, 8, 24, 16, 0, 8}, {}, stats),
       right = file->scene->render_tile({8, 8, 24, 16, 8, 16}, {}, stats);
  ASSERT_TRUE(left.ok() && right.ok());
  const std::size_t pixels = left->pixel_count();
  wire::merge_pixel_nodes(left->channels, pixels, left->counts.data(), left->values.data(), pixels,
                          right->counts.data(), right->values.data(), pixels);
  for (std::size_t c = 0; c < left->channels.size(); ++c) {
    const std::vector<float>& wanted = plane(whole, left->channels[c].name);
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::size_t at = (8 + i / 16) * kSide + 8 + i % 16;
      ASSERT_EQ(left->values[c * pixels + i] / 16, wanted[at]) << left->channels[c].name;
    }
  }
}

/// Where all is diffuse, the light of one event is what `direct` renders.
TEST(LayersOfPictures, DirectLightIsThatOfTheAlgorithm) {
  const std::string scene = absl::StrCat(kFloor, kLights, ball("b", "white", 0, 0.6, 0, 0.6));
  const client::Image path = picture({.scene = scene, .layers = {{"direct", "LE|LDE"}, {"lit", "LDE"}}}),
                      direct = picture({.scene = scene, .integrator = "direct"});
  for (const char* band : {"R", "G", "B"}) {
    EXPECT_EQ(plane(path, absl::StrCat("direct.", band)), plane(direct, band));
    EXPECT_NE(plane(path, absl::StrCat("direct.", band)), plane(path, band));
  }
  EXPECT_GT(mean(path, "lit.R"), 0.1);
}

TEST(LayersOfPictures, CausticsComeOfGlassAlone) {
  const Layers layers = {{"caustics", "LS+DE"}, {"direct", "LDE"}, {"seen", "LE"}, {"mirrored", "L.*SE"}};
  const std::string under_lamp = absl::StrCat(kFloor, kMaterials, kLights);
  for (const char* integrator : {"light", "path"}) {
    const client::Image glass = picture({.scene = under_lamp + ball("b", "glass", 0, 0.8, 0, 0.6),
                                         .integrator = integrator,
                                         .layers = layers,
                                         .spp = 32}),
                        clay = picture({.scene = under_lamp + ball("b", "white", 0, 0.8, 0, 0.6),
                                        .integrator = integrator,
                                        .layers = layers,
                                        .spp = 32});
    EXPECT_GT(mean(glass, "caustics.R"), 0.01) << integrator;
    EXPECT_EQ(mean(clay, "caustics.R"), 0) << integrator;
    EXPECT_EQ(mean(clay, "mirrored.R"), 0) << integrator;
    EXPECT_GT(mean(clay, "direct.R"), 0.1) << integrator;
    EXPECT_GT(mean(clay, "seen.R"), 0) << integrator;  // the lamp is in the picture
    // Light tracing joins no mirror to the camera.
    EXPECT_EQ(mean(glass, "mirrored.R") > 0, std::string(integrator) == "path");
  }
}

/// The layers of a group are all the light that its lights give: without them nothing is left.
TEST(LayersOfPictures, KnowLightsAndObjectsByName) {
  const Layers layers = {{"key", "C.*<L.'key'>"},
                         {"lamp", "C.*<O'lamp'>"},
                         {"spot", "C.*<L.'spot'>"},
                         {"floor", "C<..'floor'>.*L"},
                         {"nobody", "C.*<L.'nobody'>"}};
  const client::Image all = picture({.scene = many_materials(), .layers = layers});
  EXPECT_EQ(plane(all, "key.R"), plane(all, "lamp.R"));
  EXPECT_GT(mean(all, "key.R"), 0.01);
  EXPECT_GT(mean(all, "spot.R"), 0.01);
  EXPECT_EQ(mean(all, "nobody.R"), 0);
  // In the middle of the picture is the second ball of the second row, at the edge the floor.
  EXPECT_GT(plane(all, "floor.R")[0], 0);
  const std::string scene = many_materials();
  const std::string dark =
      scene.substr(0, scene.find("lights { name: 'spot'")) + scene.substr(scene.find("lights { name: 'sky'"));
  const client::Image without = picture({.scene = dark, .layers = layers});
  EXPECT_EQ(mean(without, "spot.R"), 0);
  EXPECT_GT(mean(without, "key.R"), 0.01);
}

/// Lobes are told apart alike when lights are sampled and when they are hit: means over the picture of 16
/// independent images each way differ by less than six standard errors.
TEST(LayersOfPictures, LobesAreTheSameHoweverLightIsFound) {
  const std::string scene =
      absl::StrCat(kFloor, kMaterials, "lights { infinite { radiance { constant: 1 } } }",
                   ball("a", "lacquer", -1, 0.5, -1, 0.5), ball("b", "varnish", 0, 0.5, -1, 0.5),
                   ball("c", "disney", 1, 0.5, -1, 0.5), ball("d", "mixed", 0, 0.5, 0.5, 0.5));
  const char* const names[] = {"d.R", "g.R"};
  const auto measure = [&](v1::DirectLight way, const char* name) {
    constexpr int kImages = 16;
    const auto file = load({.scene = scene,
                            .layers = {{"d", "LDE"}, {"g", "LGE"}},
                            .spp = 16,
                            .max_depth = 2,
                            .direct_light = way});
    EXPECT_TRUE(file.ok()) << file.status();
    double sum = 0, squares = 0;
    for (int i = 0; i < kImages; ++i) {
      const double value = mean(render_image(*file, static_cast<std::uint64_t>(i) + 1), name);
      sum += value, squares += value * value;
    }
    const double average = sum / kImages;
    const double variance = std::max(squares / kImages - average * average, 1e-14) / (kImages - 1);
    return std::pair(average, variance);
  };
  for (const char* name : names) {
    const auto [mis, mis_variance] = measure(v1::DIRECT_LIGHT_MIS, name);
    const auto [bsdf, bsdf_variance] = measure(v1::DIRECT_LIGHT_BSDF, name);
    EXPECT_GT(mis, 0.005) << name;
    EXPECT_NEAR(mis, bsdf, 6 * std::sqrt(mis_variance + bsdf_variance)) << name;
  }
}

}  // namespace
}  // namespace tessera::test::layers_of_pictures
