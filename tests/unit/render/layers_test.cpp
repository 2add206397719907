// Layers of rendered pictures: partitions add up, both notations are one, and what a layer holds is what its
// expression says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"
#include "unit/render/layered_pictures.h"
#include "wire/algorithm.h"

namespace tessera::test::layers_of_pictures {
namespace {

/// A pixel is the mean of n samples, each a sum of light that is nowhere negative. Layers add the same
/// numbers in another order: of at most 7 events with 5 lights each, and 16 samples, every sum is off by
/// fewer than 35 + 16 + 32 roundings of 2^-24, of either side.
constexpr double kRounding = 2 * (35 + 16 + 32) * 0x1p-24;

/// The same where a pixel has light of all vertices of a pass's light paths at most, in each of 16 samples.
constexpr double kRoundingOfPasses = 2 * (kSide * kSide * 7 + 35 + 16 + 32) * 0x1p-24;

double rounding_of(const std::string& integrator) {
  return wire::find_algorithm(integrator)->layers == wire::LayerStates::kFromBothEnds ? kRoundingOfPasses
                                                                                      : kRounding;
}

const char* const kGlowingFog =
    "media { name: 'fog' extinction { constant { constant: 0.5 } } albedo { constant { constant: 0.8 } } "
    "emission { constant { constant: 0.1 } } } materials { name: 'none' interface {} } shapes { name: 'air' "
    "sphere { "
    "radius: 1.2 } material: 'none' interior_medium: 'fog' world_from_object { elements: [1,0,0,0, 0,1,0,1, "
    "0,0,1,0, 0,0,0,1] } } ";

void expect_partition(const client::Image& image, const Layers& layers, const std::string& what,
                      double rounding = kRounding) {
  for (const char* band : {"R", "G", "B"}) {
    const std::vector<float>& whole = plane(image, band);
    std::vector<double> sum(whole.size());
    for (const auto& layer : layers) {
      const std::vector<float>& part = plane(image, absl::StrCat(layer.first, ".", band));
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      ASSERT_NEAR(sum[i], whole[i], rounding * whole[i]) << what << ", " << band << " of pixel " << i;
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
    expect_partition(image, partition, absl::StrCat(GetParam(), ": ", partition.back().second),
                     rounding_of(GetParam()));
    // And nothing else changes by them.
    for (const char* band : {"R", "G", "B", "A"}) ASSERT_EQ(plane(image, band), plane(alone, band));
    if (media && partition.back().first == "fog") {
      EXPECT_GT(mean(image, "fog.R"), 0.001);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Algorithms, Partitions,
                         testing::Values("path", "volpath", "direct", "whitted", "raycast", "light", "bdpt",
                                         "vcm", "photon"),
                         [](const auto& algorithm) { return std::string(algorithm.param); });

/// All ways to make paths of up to `events` events, and the rest, as --aov strategies asks for them.
Layers strategies(std::uint32_t events) {
  Layers layers;
  for (std::uint32_t e = 0; e <= events; ++e) {
    for (std::uint32_t s = 0; s <= (e == 0 ? 0 : e + 1); ++s) {
      const std::string way = absl::StrCat("s", s, "t", e + 2 - s);
      layers.emplace_back(way, way);
    }
  }
  layers.emplace_back("longer", absl::StrCat("d", events + 1, "+"));
  return layers;
}

TEST(LayersOfPictures, StrategiesAddUpToThePicture) {
  const Layers partition = strategies(4);
  for (const bool fog : {false, true}) {
    const std::string scene = absl::StrCat(many_materials(), fog ? kGlowingFog : "");
    const client::Image image = picture({.scene = scene, .integrator = "bdpt", .layers = partition}),
                        alone = picture({.scene = scene, .integrator = "bdpt"});
    expect_partition(image, partition, fog ? "strategies in fog" : "strategies", kRoundingOfPasses);
    for (const auto& layer : partition) EXPECT_GT(mean(image, layer.first + ".R"), 0) << layer.first;
    EXPECT_EQ(plane(image, "R"), plane(alone, "R"));
  }
}

/// Strategies and expressions are asked for together, and unweighted light changes neither.
TEST(LayersOfPictures, StrategiesShareTheLightOfExpressions) {
  const Layers shares = {{"hit", "s0t*:LS+DE"}, {"sampled", "s1t*:LS+DE"}, {"traced", "s*t1:LS+DE"},
                         {"all", "LS+DE"},      {"every", "d0+:LS+DE"},    {"raw", "unweighted s*t1:LS+DE"}};
  const client::Image image =
      picture({.scene = many_materials(), .integrator = "bdpt", .layers = shares, .spp = 16});
  EXPECT_EQ(plane(image, "all.R"), plane(image, "every.R"));
  EXPECT_GT(mean(image, "hit.R"), 0);
  EXPECT_GT(mean(image, "traced.R"), 0.1 * mean(image, "all.R"));
  // A light that is seen in glass is not sampled.
  EXPECT_EQ(mean(image, "sampled.R"), 0);
  EXPECT_GT(mean(image, "raw.R"), mean(image, "traced.R"));
}

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
  for (const char* integrator : {"path", "light", "bdpt", "photon"}) {
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

/// Channels of other layers must not matter for one, nor how samples are cut into units, nor, of tiles, where
/// these are.
TEST(LayersOfPictures, HaveTheSameBitsHoweverSamplesAreCut) {
  for (const char* integrator : {"path", "bdpt", "vcm", "photon"}) {
    SCOPED_TRACE(integrator);
    const auto file = load({.scene = many_materials(),
                            .integrator = integrator,
                            .layers = {{"a", "L.*DE"}, {"b", "LS+.E"}},
                            .spp = 16});
    ASSERT_TRUE(file.ok()) << file.status();
    const client::Image whole = render_image(*file);
    render::RenderStats stats;
    const bool passes = wire::find_algorithm(integrator)->work == wire::WorkKind::kPasses;
    const std::uint32_t x0 = passes ? 0 : 8, x1 = passes ? kSide : 24, y1 = passes ? kSide : 16;
    auto first = file->scene->render_tile({x0, x0, x1, y1, 0, 8}, {}, stats),
         rest = file->scene->render_tile({x0, x0, x1, y1, 8, 16}, {}, stats);
    ASSERT_TRUE(first.ok() && rest.ok());
    const std::size_t pixels = first->pixel_count();
    wire::merge_pixel_nodes(first->channels, pixels, first->counts.data(), first->values.data(), pixels,
                            rest->counts.data(), rest->values.data(), pixels);
    for (std::size_t c = 0; c < first->channels.size(); ++c) {
      const std::vector<float>& wanted = plane(whole, first->channels[c].name);
      for (std::size_t i = 0; i < pixels; ++i) {
        const std::size_t at = (x0 + i / (x1 - x0)) * kSide + x0 + i % (x1 - x0);
        ASSERT_EQ(first->values[c * pixels + i] / 16, wanted[at]) << first->channels[c].name;
      }
    }
  }
}

/// Paths of one event more add to the picture what they add to the layers of their length, and nothing else
/// changes by them: the numbers of a path do not depend on how long others may be. But for `photon`, where
/// one photon, of whatever length, is drawn to tell whether all near it are seen: pictures are the same in
/// the mean.
TEST(LayersOfPictures, BouncesAreWhatDeeperPicturesHaveMore) {
  const std::string scene =
      absl::StrCat(kFloor, kMaterials, kLights, ball("a", "glass", -1, 0.5, -1, 0.5),
                   ball("b", "varnish", 0, 0.5, -1, 0.5), ball("c", "lacquer", 1, 0.5, -1, 0.5),
                   ball("d", "brushed", 0, 0.5, 0.5, 0.5), ball("e", "paper", 1, 0.5, 0.5, 0.5));
  constexpr std::uint32_t kDeepest = 4;
  Layers bounces;
  for (std::uint32_t i = 0; i <= kDeepest; ++i)
    bounces.emplace_back(absl::StrCat("bounce", i), i == 0 ? "LE" : absl::StrCat("L.{", i, "}E"));
  for (const char* integrator : {"path", "volpath", "light", "bdpt", "vcm", "photon"}) {
    const client::Image image = picture(
        {.scene = scene, .integrator = integrator, .layers = bounces, .spp = 4, .max_depth = kDeepest});
    Layers added;
    for (std::uint32_t depth = 0; depth <= kDeepest; ++depth) {
      added.push_back(bounces[depth]);
      const client::Image shallow =
          picture({.scene = scene, .integrator = integrator, .spp = 4, .max_depth = depth});
      for (const char* band : {"R", "G", "B"}) {
        const std::vector<float>& wanted = plane(shallow, band);
        std::vector<double> sum(wanted.size());
        for (const auto& layer : added) {
          const std::vector<float>& part = plane(image, absl::StrCat(layer.first, ".", band));
          for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
        }
        if (integrator == std::string("photon") && depth > 1) {
          // Who is drawn matters near edges alone, in a tenth of the pixels, by less than their light: of 4
          // passes and some hundred pixels less than 2 % are left in the mean.
          const double all = std::accumulate(wanted.begin(), wanted.end(), 0.0);
          ASSERT_NEAR(std::accumulate(sum.begin(), sum.end(), 0.0), all, 0.02 * all) << depth << band;
          continue;
        }
        for (std::size_t i = 0; i < sum.size(); ++i)
          ASSERT_NEAR(sum[i], wanted[i], kRoundingOfPasses * wanted[i] + 1e-30)
              << integrator << " of depth " << depth << ", " << band << " of pixel " << i;
      }
    }
    EXPECT_GT(mean(image, "bounce4.R"), 0) << integrator;
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
  for (const char* integrator : {"light", "path", "bdpt", "vcm", "photon"}) {
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
    EXPECT_EQ(mean(glass, "mirrored.R") > 0, std::string(integrator) != "light");
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

TEST(LayersOfPictures, HaveTheLightThatShinesStraightOnProbes) {
  const std::string floor = kFloor;
  const std::string scene = absl::StrCat(
      "camera { probes { probes { kind: PLANE point { x: 0.2 y: 0.1 } axis { y: 1 } pixels: ", kSide * kSide,
      " } } } film { filter { kind: BOX radius_x: 0.49 radius_y: 0.49 } } ",
      floor.substr(floor.find("materials")), kLights);
  const Layers lights = {{"key", "C.*<L.'key'>"}, {"spot", "C.*<L.'spot'>"}, {"sky", "C.*<L.'sky'>"}};
  for (const std::uint32_t depth : {0u, 3u}) {
    const client::Image image = picture({.scene = scene, .layers = lights, .max_depth = depth});
    expect_partition(image, lights, absl::StrCat("probes, depth ", depth));
    // A light at a point is met by no ray.
    EXPECT_GT(plane(image, "spot.G").front(), 0);
  }
}

}  // namespace
}  // namespace tessera::test::layers_of_pictures
