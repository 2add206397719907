// Layers of algorithms that find light by different ways are the same in the mean.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/render_image.h"
#include "unit/render/layered_pictures.h"

namespace tessera::test::layers_that_agree {
namespace {

using namespace layers_of_pictures;  // NOLINT(google-build-using-namespace): its pictures are all of this

/// Mean of pictures by independent seeds, with its variance.
struct Measured {
  double mean = 0, variance = 0;
};

constexpr int kPictures = 16;
constexpr int kParts = 5;  // the film's quarters, and the whole

/// Measures the green channel of layers, part by part of the film.
std::map<std::string, std::vector<Measured>> measure(const Request& request, std::uint64_t first_seed) {
  const auto file = load(request);
  EXPECT_TRUE(file.ok()) << file.status();
  std::map<std::string, std::vector<Measured>> result;
  if (!file.ok()) return result;
  for (const auto& layer : request.layers) result[layer.first].resize(kParts);
  for (int k = 0; k < kPictures; ++k) {
    const client::Image image = render_image(*file, first_seed + static_cast<std::uint64_t>(k));
    for (auto& [name, parts] : result) {
      const std::vector<float>& values = plane(image, name + ".G");
      double means[kParts] = {};
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t quarter = i / kSide / (kSide / 2) * 2 + i % kSide / (kSide / 2);
        means[quarter] += 4.0 * values[i] / (kSide * kSide);
        means[4] += values[i] / double{kSide * kSide};
      }
      for (int q = 0; q < kParts; ++q) {
        parts[static_cast<std::size_t>(q)].mean += means[q] / kPictures;
        parts[static_cast<std::size_t>(q)].variance += means[q] * means[q] / kPictures;
      }
    }
  }
  for (auto& [name, parts] : result) {
    for (Measured& part : parts)
      part.variance = std::max(part.variance - part.mean * part.mean, 0.0) / (kPictures - 1);
  }
  return result;
}

/// Six standard errors with 15 degrees of freedom each: one comparison in 200,000. Where the other algorithm
/// is only consistent, its bias may be this share of a layer's mean besides.
void expect_agreement(const Request& request, const Request& other, double bias = 0) {
  const auto expected = measure(request, 100), found = measure(other, 200);
  for (const auto& [name, parts] : expected) {
    for (std::size_t q = 0; q < parts.size(); ++q) {
      const Measured& a = parts[q];
      const Measured& b = found.at(name)[q];
      EXPECT_NEAR(b.mean, a.mean, 6 * std::sqrt(a.variance + b.variance) + bias * a.mean)
          << other.integrator << ": " << name << ", part " << q;
    }
    EXPECT_GT(parts[4].mean, 4 * std::sqrt(parts[4].variance)) << name << " is too noisy to tell anything";
  }
}

/// Automata of all of them would be too large.
const Layers kLengthsAndLobes = {
    {"bounce0", "LE"},      {"bounce1", "L.E"},    {"bounce2", "L.{2}E"},
    {"bounce3", "L.{3}E"},  {"bounce4", "L.{4}E"}, {"diffuse", "L.*DE"},
    {"glossy", "L.*GE"},    {"specular", "L.*SE"}, {"diffuse_then_glossy", "L.*GDE"},
    {"glossy_lit", "LG.*E"}};
const Layers kNames = {{"through", "C.*T.*L"},
                       {"key", "C.*<L.'key'>"},
                       {"spot", "C.*<L.'spot'>"},
                       {"sky", "C.*B"},
                       {"varnish", "C.*<..m'varnish'>.*L"},
                       {"floor_by_ball", "C.*<..'floor'><.[DG]['a' 'b']>.*L"}};

/// Matter and lights without small bright caustics, whose pictures of few samples have no standard error, and
/// without lights at points, whose reflections in mirrors path does not find. The scene is small, so that
/// paths from lights come to what is seen.
std::string scene_of_agreement() {
  std::string floor = kFloor;
  floor.replace(floor.find("radius: 9"), 9, "radius: 3");
  return absl::StrCat(
      floor, kMaterials,
      "materials { name: 'mirror' conductor { reflectance { constant { constant: 0.8 } } } } "
      "shapes { name: 'lamp' disk { radius: 0.9 } material: 'white' area_light { radiance { constant: 2 } "
      "two_sided: true group: 'key' } world_from_object { elements: [1,0,0,1.3, 0,0,1,2.6, 0,-1,0,1.2, "
      "0,0,0,1] } } "
      "shapes { name: 'spot' sphere { radius: 0.5 } area_light { radiance { constant: 4 } } "
      "world_from_object { elements: [1,0,0,-2, 0,1,0,3, 0,0,1,-1, 0,0,0,1] } } "
      "lights { name: 'sky' infinite { radiance { constant: 0.3 } } } ",
      ball("a", "lacquer", -1, 0.5, -1, 0.5), ball("b", "varnish", 0, 0.5, -1, 0.5),
      ball("c", "paper", 1, 0.5, -1, 0.5), ball("d", "brushed", -1, 0.5, 0.3, 0.5),
      ball("e", "mirror", 0, 0.4, 0.3, 0.4));
}

const char* const kFog =
    "media { name: 'fog' extinction { constant { constant: 0.5 } } albedo { constant { constant: 0.8 } } } "
    "materials { name: 'none' interface {} } shapes { name: 'air' sphere { radius: 1.4 } material: 'none' "
    "interior_medium: 'fog' world_from_object { elements: [1,0,0,0, 0,1,0,1.2, 0,0,1,0, 0,0,0,1] } } ";

class LayersThatAgree : public testing::TestWithParam<const Layers*> {
 protected:
  static Request by(const char* integrator) {
    return {.scene = scene_of_agreement(),
            .integrator = integrator,
            .layers = *GetParam(),
            .spp = 8,
            .max_depth = 4};
  }
};

TEST_P(LayersThatAgree, OfBdptAndPath) { expect_agreement(by("path"), by("bdpt")); }

TEST_P(LayersThatAgree, OfBdptAndVolpathInMedia) {
  Request volpath = by("volpath"), bdpt = by("bdpt");
  for (Request* const request : {&volpath, &bdpt}) {
    request->scene += kFog;
    request->layers.push_back({"fog", "L.*VE"});
  }
  expect_agreement(volpath, bdpt);
}

/// Vertices are merged within 0.003 of the scene's radius, 0.01, where balls have 0.5. On their edges light
/// comes from what is less lit: one part in a hundred.
TEST_P(LayersThatAgree, OfVcmAndPath) { expect_agreement(by("path"), by("vcm"), 0.01); }

/// The same within 0.05, of a tenth of the balls' radius: one part in twenty.
TEST_P(LayersThatAgree, OfPhotonAndPath) {
  Request photon = by("photon");
  photon.photon_radius = 0.05;
  photon.spp = 4;
  photon.photons = 16'384;  // enough for rare ones to come to each part of the film
  expect_agreement(by("path"), photon, 0.05);
}

INSTANTIATE_TEST_SUITE_P(All, LayersThatAgree, testing::Values(&kLengthsAndLobes, &kNames),
                         [](const auto& layers) {
                           return std::string(layers.param == &kNames ? "Names" : "LengthsAndLobes");
                         });

/// A disk and two balls apart from each other, under a lamp: joins of vertices have a finite variance.
std::string scene_of_strategies() {
  return absl::StrCat(
      "camera { perspective { fov_degrees: 60 lens_radius: 0.05 focal_distance: 3 } world_from_camera { "
      "elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } } ",
      kMaterials,
      "materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } } "
      "shapes { disk { radius: 3 } material: 'white' world_from_object { elements: [1,0,0,0, 0,1,0,0, "
      "0,0,-1,1, 0,0,0,1] } } "
      "shapes { disk { radius: 0.9 } area_light { radiance { constant: 2 } two_sided: true } "
      "world_from_object { elements: [1,0,0,0.2, 0,0,-1,1.6, 0,1,0,0, 0,0,0,1] } } ",
      ball("a", "varnish", -0.7, -0.4, 0, 0.6), ball("b", "white", 0.8, -0.2, 0, 0.5));
}

TEST(LayersOfStrategies, AgreeWithPathByThemselves) {
  for (int events = 1; events <= 3; ++events) {
    const std::string expression = absl::StrCat("L.{", events, "}E");
    Request path{.scene = scene_of_strategies(), .spp = 16, .max_depth = 3},
        bdpt{.scene = path.scene, .integrator = "bdpt", .spp = 16, .max_depth = 3};
    for (int s = 0; s <= events + 1; ++s) {
      const std::string way = absl::StrCat("s", s, "t", events + 2 - s);
      path.layers.emplace_back(way, expression);
      bdpt.layers.emplace_back(way, "unweighted " + way);
    }
    expect_agreement(path, bdpt);
  }
}

/// A floor, a lamp, and a ball that throws its shadow on what the camera sees, but is not seen itself.
std::string scene_of_shadow(const std::string& lights, bool ball_is_there) {
  return absl::StrCat(kFloor, lights, ball_is_there ? ball("ball", "white", 2.5, 2.5, 0, 0.5) : "");
}

const Layers kShadow = {{"lit", "L.E"}, {"shadow", "shadow:L.E"}};

TEST(Shadows, AreTheLightThatIsMissing) {
  const std::string light = "lights { point { position { x: 4 y: 4 z: 0 } intensity { constant: 20 } } } ";
  for (const char* integrator : {"path", "volpath", "direct", "whitted", "raycast", "bdpt", "vcm"}) {
    const Request there{.scene = scene_of_shadow(light, true),
                        .integrator = integrator,
                        .layers = kShadow,
                        .spp = 4,
                        .max_depth = 1};
    Request open = there;
    open.scene = scene_of_shadow(light, false);
    const client::Image shadowed = picture(there), lit = picture(open);
    const std::vector<float>&arrives = plane(shadowed, "lit.G"), &blocked = plane(shadowed, "shadow.G"),
          &all = plane(lit, "lit.G");
    int dark = 0, bright = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      dark += arrives[i] == 0;
      bright += blocked[i] == 0;
      // Weights of other ways to find the light differ where these are blocked: with bdpt and vcm in the
      // mean.
      if (std::string(integrator) == "bdpt" || std::string(integrator) == "vcm") continue;
      ASSERT_NEAR(arrives[i] + blocked[i], all[i], 1e-6 * all[i]) << integrator << ", pixel " << i;
    }
    EXPECT_GT(dark, 10) << integrator;
    EXPECT_GT(bright, 100) << integrator;
    EXPECT_EQ(mean(lit, "shadow.G"), 0) << integrator;
    EXPECT_EQ(plane(shadowed, "G"),
              plane(picture({.scene = there.scene, .integrator = integrator, .spp = 4, .max_depth = 1}), "G"))
        << integrator;
  }
}

/// With light that arrives they are all light there would be, whatever is in the way of it: six standard
/// errors of 15 degrees of freedom each.
TEST(Shadows, AndWhatArrivesAreAllLightThereIs) {
  const std::string lights =
      "shapes { sphere { radius: 0.8 } material: 'white' area_light { radiance { constant: 10 } } "
      "world_from_object { elements: [1,0,0,4, 0,1,0,4, 0,0,1,0, 0,0,0,1] } } "
      "lights { infinite { radiance { constant: 0.3 } } } "
      "materials { name: 'varnish' phong { diffuse { constant { constant: 0.4 } } specular { constant { "
      "constant: 0.4 } } exponent { constant: 5 } } } ";
  for (const char* integrator : {"path", "volpath", "bdpt", "whitted"}) {
    SCOPED_TRACE(integrator);
    const bool fog = std::string(integrator) == "volpath" || std::string(integrator) == "bdpt";
    const auto request = [&](bool ball_is_there) {
      std::string scene = scene_of_shadow(absl::StrCat(lights, fog ? kFog : ""), ball_is_there);
      scene.replace(scene.find("material: 'white'"), 17, "material: 'varnish'");  // the floor
      return Request{.scene = scene, .integrator = integrator, .layers = kShadow, .spp = 8, .max_depth = 1};
    };
    const auto with = measure(request(true), 300), without = measure(request(false), 400);
    for (std::size_t q = 0; q < kParts; ++q) {
      double sum = 0, variance = 0;
      for (const char* name : {"lit", "shadow"}) {
        sum += with.at(name)[q].mean - without.at(name)[q].mean;
        // They are not independent: standard errors are added.
        variance += 2 * (with.at(name)[q].variance + without.at(name)[q].variance);
      }
      EXPECT_NEAR(sum, 0, 6 * std::sqrt(variance)) << "part " << q;
    }
    // The lamp, too, is in the way of the sky.
    EXPECT_GT(with.at("shadow")[4].mean, 1.1 * without.at("shadow")[4].mean);
  }
}

}  // namespace
}  // namespace tessera::test::layers_that_agree
