// Neighbouring pixels that share light have the means that they have alone, and less noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "render/scene/sharing_pilot.h"
#include "support/long_form.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"

namespace tessera::test::path_sharing_test {
namespace {

using testing::Each;
using testing::Truly;

// A film whose size is no multiple of a group's, and a tile that begins within one.
constexpr std::uint32_t kWidth = 18, kHeight = 14, kX0 = 3, kY0 = 1;
constexpr std::size_t kPixels = (kWidth - kX0) * (kHeight - kY0);
constexpr std::uint32_t kSamples = 4;

constexpr const char* kLamp = R"(
  shapes { sphere { radius: 0.4 } material: 'lamp' area_light { radiance { constant: 5 } }
           world_from_object { elements: [1,0,0,-2, 0,1,0,1.5, 0,0,1,0, 0,0,0,1] } }
)";

constexpr const char* kRoom = R"(
  lights { point { position { x: 1 y: 2 z: -1 } intensity { constant: 6 } } }
  shapes { sphere { radius: 5 } material: 'walls' }
)";

constexpr const char* kCoatedRoom = R"(
  lights { point { position { x: 1 y: 2 z: -1 } intensity { constant: 6 } } }
  shapes { sphere { radius: 5 } material: 'coated' }
)";

/// Where most light is found by samples of BSDFs and of the sky alike. Below is varnish, above is a wall.
constexpr const char* kSky = R"(
  lights { infinite { radiance { rgb { r: 0.9 g: 0.5 b: 0.2 } } } }
  shapes { sphere { radius: 20 } material: 'varnish'
           world_from_object { elements: [1,0,0,0, 0,1,0,-21.2, 0,0,1,0, 0,0,0,1] } }
  shapes { sphere { radius: 3 } material: 'walls'
           world_from_object { elements: [1,0,0,0, 0,1,0,5, 0,0,1,0, 0,0,0,1] } }
)";

/// Three bubbles about the camera: surfaces that can be joined to others are met at the fourth event, where
/// Russian roulette has begun. Beside them is a mirror, which puts some off further.
constexpr const char* kBubbles = R"(
  lights { point { position { x: 1 y: 2 z: -1 } intensity { constant: 6 } } }
  shapes { sphere { radius: 5 } material: 'dark' }
  shapes { sphere { radius: 0.5 } material: 'glass'
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
  shapes { sphere { radius: 0.7 } material: 'glass'
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
  shapes { sphere { radius: 0.9 } material: 'glass'
    world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
  shapes { sphere { radius: 0.9 } material: 'mirror'
    world_from_object { elements: [1,0,0,2, 0,1,0,1.5, 0,0,1,0.5, 0,0,0,1] } }
)";

/// A triangle whose vertices agree on a normal that is not its own.
constexpr const char* kLeaningLamp = R"(
  shapes { mesh { blob { digest: 'triangle' } } material: 'lamp'
           area_light { radiance { constant: 9 } two_sided: true interpolated_normal_pick: 0.5 } }
)";
TestBlobs leaning_triangle() {
  wire::MeshData mesh;
  mesh.positions = {-2.5f, 1.2f, -0.5f, -1.5f, 1.6f, -0.5f, -2, 1.5f, 0.6f};
  for (int i = 0; i < 3; ++i) mesh.normals.insert(mesh.normals.end(), {0.3f, -0.9f, 0.3f});
  mesh.indices = {0, 1, 2};
  return {{"triangle", wire::encode_mesh(mesh)}};
}

/// Two panes, one before the camera.
constexpr const char* kPanes = R"(
  shapes { disk { radius: 1 } material: 'pane'
    world_from_object { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,-1.5, 0,0,0,1] } }
  shapes { disk { radius: 1.5 } material: 'pane'
    world_from_object { elements: [1,0,0,0, 0,0,1,-1, 0,1,0,0, 0,0,0,1] } }
)";

constexpr const char* kFog =
    " media { name: 'fog' extinction { constant { constant: 1 } } albedo { constant { constant: 0.5 } } }";

/// A ball that goes from the right to the left.
constexpr const char* kMovingBall = R"(
  shapes { sphere { radius: 0.8 } material: 'metal'
    world_from_object { elements: [1,0,0,1.2, 0,1,0,-0.5, 0,0,1,0, 0,0,0,1] }
           world_from_object_end { elements: [1,0,0,-0.6, 0,1,0,-0.5, 0,0,1,0, 0,0,0,1] } }
)";

/// A film and materials for `things`, which include the lights and the surroundings.
std::string scene_text(const std::string& things, const std::string& filter) {
  return absl::StrCat(R"(
  camera { perspective { fov_degrees: 70 }
    world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
  textures { name: 'tiles' checkerboard { mapping { scale_u: 5 scale_v: 3 } } }
  materials { name: 'walls' diffuse { reflectance { constant { constant: 0.7 } } } }
  materials { name: 'painted' diffuse { reflectance { texture: 'tiles' } } }
  materials { name: 'lamp' diffuse { reflectance { constant { constant: 0 } } } }
  materials { name: 'metal' conductor { reflectance { constant { constant: 0.8 } }
                                        roughness { u { constant: 0.3 } v { constant: 0.3 } } } }
  materials { name: 'varnish' coated_diffuse { reflectance { constant { constant: 0.5 } }
                                               roughness { u { constant: 0.2 } v { constant: 0.2 } } } }
  materials { name: 'dark' diffuse { reflectance { constant { rgb { r: 0.3 g: 0.2 b: 0.15 } } } } }
  materials { name: 'mirror' conductor { reflectance { constant { constant: 0.9 } } } }
  materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
  materials { name: 'frosted' dielectric { eta { constant: 1.5 }
    roughness { u { constant: 0.4 } v { constant: 0.4 } } } }
  materials { name: 'pane' thin_dielectric { eta { constant: 1.5 } passes_straight: true } }
  materials { name: 'gauze' diffuse { reflectance { constant { constant: 0.8 } } } opacity { constant: 0.4 } }
  materials { name: 'coated' coated_conductor { conductor { reflectance { constant { constant: 0.8 } }
                                                            roughness { u { constant: 0.3 }
                                                              v { constant: 0.3 } } }
                                                eta { constant: 1.5 } roughness { u { constant: 0.3 }
                                                  v { constant: 0.3 } } } }
  materials { name: 'both' mix { a: 'metal' b: 'walls' amount { constant: 0.5 } } }
)",
                      things, "film { width: ", kWidth, " height: ", kHeight, " filter { ", filter, " } }");
}

std::string ball(const char* material, double x, double y, const char* more = "") {
  return absl::StrCat("shapes { sphere { radius: 0.8 } material: '", material, "' ", more,
                      " world_from_object { elements: [1,0,0,", x, ", 0,1,0,", y,
                      ", 0,0,1,0, 0,0,0,1] } }\n");
}

/// Means over renders of other seeds, of R and B of each pixel and of the whole, and the variances and
/// largest values of renders.
struct Values {
  std::vector<double> mean = std::vector<double>(2 * kPixels + 2), variance = mean, largest = mean;

  double noise() const {
    double sum = 0;
    for (std::size_t i = 0; i < 2 * kPixels; ++i) sum += variance[i];
    return sum;
  }
};

struct Case {
  const char* name;
  std::string things;
  // Variance alone over that with 8 neighbours: less than half of the gain that was measured. Lamps that
  // first surfaces see are not shared, and few bright samples make most of the variance where there is one:
  // there only a loss would show.
  double least_gain;
  std::uint32_t depth = 5;
  const char* integrator = "path";
  v1::GlassShadows glass_shadows = v1::GLASS_SHADOWS_TRACED;
};

Values measure(const std::string& text, const Case& one, v1::PathSharing sharing, int renders) {
  SceneJob job;
  job.settings.set_integrator(one.integrator);
  job.settings.set_path_sharing(sharing);
  job.settings.set_glass_shadows(one.glass_shadows);
  job.settings.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  job.settings.set_spp(kSamples);
  job.settings.set_max_depth(one.depth);
  const auto file = load_scene_text(text, job, render::supported_isas().front(), leaning_triangle());
  EXPECT_TRUE(file.ok()) << file.status();
  Values result;
  if (!file.ok()) return result;
  EXPECT_THAT(file->scene->warnings(), Each(Truly(is_of_blindness)));
  for (int i = 0; i < renders; ++i) {
    render::RenderStats stats;
    // Neither shares a seed with the other.
    const std::uint64_t seed = 8 * static_cast<std::uint64_t>(i) + static_cast<std::uint64_t>(sharing);
    const auto tile = file->scene->render_tile({kX0, kY0, kWidth, kHeight, 0, kSamples, seed}, {}, stats);
    EXPECT_TRUE(tile.ok()) << tile.status();
    if (!tile.ok()) break;
    EXPECT_EQ(stats.dropped_samples, 0u);
    EXPECT_EQ(stats.samples, kPixels * kSamples);
    double whole[2] = {};
    for (std::size_t v = 0; v < result.mean.size(); ++v) {
      const bool pixel = v < 2 * kPixels;
      const std::size_t band = pixel ? v / kPixels : v - 2 * kPixels;
      double value = whole[band] / kPixels;
      if (pixel) whole[band] += value = tile->values[2 * band * kPixels + v % kPixels] / kSamples;
      result.largest[v] = std::max(result.largest[v], value);
      const double step = value - result.mean[v];  // [Welford 1962]
      result.mean[v] += step / (i + 1);
      result.variance[v] += step * (value - result.mean[v]);
    }
  }
  for (double& variance : result.variance) variance /= renders - 1;
  return result;
}

/// Pixels that share differ from their means together: the sum of squares is held against what a sixteenth as
/// many independent ones would have.
void expect_same_means(const Values& a, const Values& b, int renders) {
  const auto error = [&](std::size_t v) { return std::sqrt((a.variance[v] + b.variance[v]) / renders); };
  double chi2 = 0;
  int noisy = 0;
  for (std::size_t v = 0; v < 2 * kPixels; ++v) {
    if (a.variance[v] == 0 && b.variance[v] == 0) {  // an even sky, seen straight
      EXPECT_EQ(a.mean[v], b.mean[v]) << "value " << v;
      continue;
    }
    ++noisy;
    chi2 += std::pow((a.mean[v] - b.mean[v]) / error(v), 2);
    // 390 values: once in thousands of runs at 5.5 standard errors. Renders are skewed, and one of two
    // pictures may lack what is rare and bright: Bernstein's inequality has 2/3 of the logarithm for the
    // largest.
    const double rare = 10 * std::max(a.largest[v], b.largest[v]) / renders;
    EXPECT_NEAR(a.mean[v], b.mean[v], 5.5 * error(v) + rare) << "value " << v;
  }
  ASSERT_GT(noisy, kPixels);
  EXPECT_NEAR(chi2 / noisy, 1, 5 * std::sqrt(2.0 * 16 * 2 / noisy));
  for (std::size_t v = 2 * kPixels; v < a.mean.size(); ++v) {
    EXPECT_NEAR(a.mean[v], b.mean[v], 4.5 * error(v)) << "the whole";
    EXPECT_LT(error(v), 0.01 * a.mean[v]) << "too noisy to tell anything";
  }
}

std::vector<Case> cases() {
  return {
      {"diffuse", kRoom + ball("walls", 0.9, -0.5) + ball("painted", -1, 0.4), 1.35},
      {"glossy", kRoom + (kLamp + ball("metal", 0.9, -0.5)) + ball("varnish", -1, 0.4), 0.8},
      {"mixed", kRoom + (kLamp + ball("both", 0.9, -0.5)) + ball("glass", -1, 0.4), 0.8},
      {"sky", kSky + (kLamp + ball("metal", 0.9, -0.5)) + ball("frosted", -1, 0.4), 0.8},
      {"behind", kBubbles + ball("metal", 0.9, -0.5) + ball("varnish", -1, 0.4), 0.8, 9},
      // Some first surfaces are the last, others not.
      {"short_behind", kBubbles + ball("metal", 0.9, -0.5) + ball("varnish", -1, 0.4), 0.8, 5},
      // Its densities are estimates: it shares nothing.
      {"coated", kCoatedRoom + (kLamp + ball("coated", 0.9, -0.5)) + ball("walls", -1, 0.4), 0.8},
      // Chance lets light through, each ray by itself.
      {"open", kRoom + (kLamp + ball("gauze", 0.9, -0.5)) + ball("metal", -1, 0.4, "alpha { constant: 0.5 }"),
       0.8},
      {"passing", kRoom + (kLamp + ball("gauze", 0.9, -0.5)) + ball("metal", -1, 0.4) + kPanes, 0.8, 5,
       "volpath"},
      {"straight", kSky + (kLamp + ball("metal", 0.9, -0.5)) + ball("glass", -1, 0.4) + kPanes, 0.8, 6,
       "path", v1::GLASS_SHADOWS_STRAIGHT},
      {"moving", kRoom + (kLamp + ball("varnish", -1, 0.4)) + kMovingBall, 0.8},
      {"leaning", kRoom + (kLeaningLamp + ball("metal", 0.9, -0.5)) + ball("varnish", -1, 0.4), 0.8},
      // The third surface is the last.
      {"short", kRoom + (kLamp + ball("metal", 0.9, -0.5)) + ball("varnish", -1, 0.4), 0.8, 2}};
}

TEST(PathSharing, HasTheSameMeansAndLessNoise) {
  const int renders = long_form() ? 2048 : 256;
  constexpr const char* kFilters[] = {"kind: BOX", "kind: TRIANGLE radius_x: 1 radius_y: 1"};
  const std::vector<Case> all = cases();
  for (const char* filter : kFilters) {
    for (const Case& one : all) {
      // One tells what another filter does.
      if (!long_form() && filter != kFilters[0] && &one != &all.front()) continue;
      const std::string text = scene_text(one.things, filter);
      const Values alone = measure(text, one, v1::PATH_SHARING_UNSPECIFIED, renders);
      for (const v1::PathSharing sharing : {v1::PATH_SHARING_4, v1::PATH_SHARING_8, v1::PATH_SHARING_16}) {
        SCOPED_TRACE(absl::StrCat(one.name, ", ", filter, ", ", v1::PathSharing_Name(sharing)));
        const Values shared = measure(text, one, sharing, renders);
        expect_same_means(alone, shared, renders);
        const double gain = alone.noise() / shared.noise();
        RecordProperty(absl::StrCat("gain_", one.name, "_", v1::PathSharing_Name(sharing)),
                       std::to_string(gain));
        if (sharing == v1::PATH_SHARING_8) {
          EXPECT_GT(gain, one.least_gain);
        }
      }
    }
  }
}

/// Scenes in which paths see more than what neighbours have in common keep their bits, and say why: who has
/// asked by name is warned.
TEST(PathSharing, IsLeftOutWherePathsSeeMore) {
  const std::string text =
      scene_text(kRoom + ball("walls", 0.9, -0.5, "interior_medium: 'fog'"), "kind: BOX") + kFog;
  SceneJob job;
  job.settings.set_integrator("volpath");
  job.settings.set_spp(kSamples);
  const auto rendered = [&](v1::PathSharing sharing) {
    job.settings.set_path_sharing(sharing);
    auto file = load_scene_text(text, job, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    render::RenderStats stats;
    const auto tile = file->scene->render_tile({0, 0, kWidth, kHeight, 0, kSamples}, {}, stats);
    return std::tuple(tile->values, file->scene->notes(), file->scene->warnings());
  };
  using Lines = std::vector<std::string>;
  const Lines because{"pixels do not share light: the scene has media"};
  const auto [alone, no_notes, no_warnings] = rendered(v1::PATH_SHARING_UNSPECIFIED);
  EXPECT_EQ(rendered(v1::PATH_SHARING_8), std::tuple(alone, no_notes, because));
  EXPECT_EQ(no_warnings, Lines{});
  const auto [by_itself, notes, warnings] = rendered(v1::PATH_SHARING_AUTO);
  EXPECT_EQ(std::tuple(by_itself, warnings), std::tuple(alone, no_warnings));
  ASSERT_FALSE(notes.empty());
  EXPECT_EQ(notes.back(), because.front());
}

/// A group's time is that of its first pixel, though a tile begins behind that.
TEST(PathSharing, AMovingThingHasTheSameBitsInAllTiles) {
  SceneJob job;
  job.settings.set_spp(kSamples);
  job.settings.set_path_sharing(v1::PATH_SHARING_16);
  const auto file = load_scene_text(scene_text(kRoom + std::string(kMovingBall), "kind: BOX"), job,
                                    render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  render::RenderStats stats;
  const auto whole = file->scene->render_tile({0, 0, kWidth, kHeight, 0, kSamples}, {}, stats),
             part = file->scene->render_tile({kX0, kY0, kWidth, kHeight, 0, kSamples}, {}, stats);
  ASSERT_TRUE(whole.ok() && part.ok());
  for (std::size_t i = 0; i < kPixels; ++i) {
    const std::size_t x = kX0 + i % (kWidth - kX0), y = kY0 + i / (kWidth - kX0);
    ASSERT_EQ(part->values[i], whole->values[y * kWidth + x]) << "pixel " << x << ", " << y;
  }
}

/// Number of rays of paths of up to `depth` events in the empty room, shared, over that of pixels alone.
double bounce_rays_of_sharing(std::uint32_t depth) {
  const auto bounce_rays = [depth](v1::PathSharing sharing) {
    SceneJob job;
    job.settings.set_spp(64);
    job.settings.set_max_depth(depth);
    job.settings.set_path_sharing(sharing);
    const auto file = load_scene_text(scene_text(kRoom, "kind: BOX"), job, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    render::RenderStats stats;
    EXPECT_TRUE(file->scene->render_tile({0, 0, kWidth, kHeight, 0, 64}, {}, stats).ok());
    return static_cast<double>(stats.bounce_rays);
  };
  return bounce_rays(v1::PATH_SHARING_16) / bounce_rays(v1::PATH_SHARING_OFF);
}

/// Groups end with the film: no more paths are followed than pixels have alone. Whole cells would have 1.5
/// times as many. Too few events for roulette.
TEST(PathSharing, FollowsNoPathsBeyondTheFilm) { EXPECT_NEAR(bounce_rays_of_sharing(3), 1, 0.1); }

/// Light that sixteen pixels share is worth longer paths than that of one, the more so where there is little
/// noise.
TEST(PathSharing, FollowsPathsForLonger) {
  EXPECT_GT(bounce_rays_of_sharing(32), 1.15);
  EXPECT_FLOAT_EQ((render::SharingPilot{.noise = 0.2, .alone = 4}.caution()), 1.25f);
  EXPECT_EQ((render::SharingPilot{.noise = 1, .alone = 1e3}.caution()), 1);
  EXPECT_EQ((render::SharingPilot{.noise = 0.1, .alone = 0.1}.caution()), 3);
  EXPECT_EQ((render::SharingPilot{.noise = 1, .alone = 0}.caution()), 1);
}

/// Media that nothing leads to do not count: the bits are those of a scene without them.
TEST(PathSharing, GoesOnBesideMediaThatNobodyMeets) {
  const std::string text = scene_text(kRoom + ball("walls", 0.9, -0.5), "kind: BOX");
  const auto rendered = [&](const std::string& scene, const char* integrator) {
    SceneJob job;
    job.settings.set_integrator(integrator);
    job.settings.set_spp(kSamples);
    job.settings.set_path_sharing(v1::PATH_SHARING_16);
    auto file = load_scene_text(scene, job, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    EXPECT_THAT(file->scene->warnings(), Each(Truly(is_of_blindness)));
    render::RenderStats stats;
    return file->scene->render_tile({0, 0, kWidth, kHeight, 0, kSamples}, {}, stats)->values;
  };
  EXPECT_EQ(rendered(text, "path"), rendered(text + kFog, "volpath"));
}

TEST(PathSharing, APilotKnowsHowMuchOfAGroupABlockHas) {
  // Side by side, a pixel at each place of the block as often as any: the chance of being in its cell, times
  // that of being in the block, summed over the three others of a cell of 2 x 2.
  const double apart = (1 - 1 / 8.0) * 0.5;
  EXPECT_NEAR(render::others_in_block({2, 2, 1}), (1 + 2 * apart) * (1 + 2 * apart) - 1, 1e-12);
  // Spread wider, fewer are near.
  EXPECT_LT(render::others_in_block({4, 4, 2}), render::others_in_block({4, 4, 1}));
  EXPECT_LT(render::others_in_block({4, 4, 4}), 15 / 4.0);
  EXPECT_EQ(render::others_in_block({1, 1, 1}), 0);
}

/// Where all pixels see the same, the squared difference of two pixels two apart is the same at all places of
/// a grid of 8, and pixels two apart agree no more than neighbours do: nothing shows of groups.
TEST(PathSharing, LeavesNoStructure) {
  constexpr std::uint32_t kSide = 34, kPhases = 8;
  const int renders = long_form() ? 256 : 24;
  // A light near a wall behind the camera: what pixels see hardly differs, and what lies behind that does.
  const std::string text = absl::StrCat(R"(
  camera { perspective { fov_degrees: 4 }
    world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } }
  materials { name: 'walls' diffuse { reflectance { constant { constant: 0.7 } } } }
  lights { point { position { x: 0.3 y: 0.2 z: -0.7 } intensity { constant: 6 } } }
  shapes { sphere { radius: 1 } material: 'walls' }
  film { width: )",
                                        kSide, " height: ", kSide, " filter { kind: BOX } }");
  for (const std::uint32_t samples : {4u, 16u}) {
    SceneJob job;
    job.settings.set_spp(samples);
    job.settings.set_max_depth(4);
    job.settings.set_path_sharing(v1::PATH_SHARING_16);
    const auto file = load_scene_text(text, job, render::supported_isas().front());
    ASSERT_TRUE(file.ok()) << file.status();
    std::vector<std::vector<double>> pictures;
    double mean = 0;
    for (int i = 0; i < renders; ++i) {
      render::RenderStats stats;
      const auto tile = file->scene->render_tile(
          {0, 0, kSide, kSide, 0, samples, static_cast<std::uint64_t>(i)}, {}, stats);
      ASSERT_TRUE(tile.ok()) << tile.status();
      pictures.emplace_back(tile->values.begin(), tile->values.begin() + kSide * kSide);
      for (const double value : pictures.back()) mean += value / (renders * double{kSide} * kSide);
    }
    // Over pictures: squared differences by axis and phase, and how much better pixels agree two apart.
    std::vector<double> sum(2 * kPhases + 2), squares = sum;
    for (const std::vector<double>& picture : pictures) {
      std::vector<double> values(sum.size());
      for (const std::size_t axis : {0u, 1u}) {
        const auto at = [&](std::uint32_t along, std::uint32_t across) {
          return picture[axis == 0 ? across * kSide + along : along * kSide + across] - mean;
        };
        constexpr std::uint32_t kPlaces = (kSide - 2) / kPhases * kPhases;
        for (std::uint32_t across = 0; across < kSide; ++across) {
          for (std::uint32_t along = 0; along < kPlaces; ++along) {
            const double here = at(along, across), next = at(along + 1, across),
                         second = at(along + 2, across);
            values[axis * kPhases + along % kPhases] += (second - here) * (second - here);
            values[2 * kPhases + axis] += here * (second - next);
          }
        }
      }
      for (std::size_t i = 0; i < values.size(); ++i)
        sum[i] += values[i], squares[i] += values[i] * values[i];
    }
    const auto mean_of = [&](std::size_t i) { return sum[i] / renders; };
    const auto error_of = [&](std::size_t i) {
      return std::sqrt((squares[i] / renders - mean_of(i) * mean_of(i)) / (renders - 1));
    };
    for (const std::size_t axis : {0u, 1u}) {
      double all = 0;
      for (std::size_t k = 0; k < kPhases; ++k) all += mean_of(axis * kPhases + k) / kPhases;
      EXPECT_GT(all, 0);
      for (std::size_t k = 0; k < kPhases; ++k) {
        // 32 values: once in thousands of runs at 4.5 standard errors, of 23 degrees of freedom.
        EXPECT_NEAR(mean_of(axis * kPhases + k), all, 4.5 * error_of(axis * kPhases + k))
            << samples << " samples, axis " << axis << ", phase " << k;
        EXPECT_LT(error_of(axis * kPhases + k), 0.1 * all) << "too noisy to tell anything";
      }
      EXPECT_LT(mean_of(2 * kPhases + axis), 4.5 * error_of(2 * kPhases + axis)) << "a weave";
    }
  }
}

/// Without being asked, light is shared where it pays: a convex thing under the sky has no second surfaces.
TEST(PathSharing, APilotDecides) {
  const auto rendered = [](const std::string& things, v1::PathSharing sharing) {
    SceneJob job;
    job.settings.set_spp(kSamples);
    job.settings.set_path_sharing(sharing);
    // Pixels of so small a film that looks at all of a room have little in common: it looks at a part.
    const std::string text =
        absl::StrReplaceAll(scene_text(things, "kind: BOX"), {{"fov_degrees: 70", "fov_degrees: 15"}});
    auto file = load_scene_text(text, job, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    render::RenderStats stats;
    const auto tile = file->scene->render_tile({0, 0, kWidth, kHeight, 0, kSamples}, {}, stats);
    const std::vector<std::string> notes = file->scene->notes();
    return std::pair(tile->values, notes.empty() ? "" : notes.back());
  };
  const std::string room = kRoom + ball("walls", 0.9, -0.5),
                    open = "lights { infinite { radiance { constant: 0.3 } } }" + ball("walls", 0, 0);
  const auto decided = rendered(room, v1::PATH_SHARING_AUTO), alone = rendered(open, v1::PATH_SHARING_AUTO);
  EXPECT_EQ(decided, rendered(room, v1::PATH_SHARING_8));
  EXPECT_NE(decided.first, rendered(room, v1::PATH_SHARING_OFF).first);
  EXPECT_EQ(alone.first, rendered(open, v1::PATH_SHARING_OFF).first);
  EXPECT_EQ(alone.second,
            "pixels do not share light: a pilot finds 1.00 times the efficiency (standard error 0 %)");
  // Pilots found these: for 8 pixels in coffee and in cornell-box, and by chance in first-light, whose
  // gain is 0.7. What is gained for pixels may be lost for means over blocks.
  EXPECT_FALSE((render::SharingPilot{.noise = 0.968, .rays = 1.325}.pays()));
  EXPECT_GT((render::SharingPilot{.noise = 0.180, .rays = 1.695, .noise_of_blocks = 0.7}.gain()), 1.6);
  EXPECT_TRUE((render::SharingPilot{.noise = 0.180, .rays = 1.695, .error = 0.3}.pays()));
  EXPECT_FALSE((render::SharingPilot{.noise = 0.686, .rays = 1.19, .error = 0.37}.pays()));
  EXPECT_FALSE((render::SharingPilot{.noise = 0.5, .rays = 1.4, .noise_of_blocks = 1.1}.pays()));
  // 16 pixels and 8, as pilots found them: 16 only where that is clearly more.
  const auto sixteen_beats_eight = [](const render::SharingPilot& sixteen,
                                      const render::SharingPilot& eight) { return sixteen.beats(eight); };
  EXPECT_TRUE(sixteen_beats_eight({.noise = 0.066, .rays = 1.174, .noise_of_blocks = 0.419, .error = 0.12},
                                  {.noise = 0.141, .rays = 1.085, .noise_of_blocks = 0.626, .error = 0.09}))
      << "door-ajar";
  EXPECT_FALSE(sixteen_beats_eight({.noise = 0.167, .rays = 2.109, .noise_of_blocks = 0.522, .error = 0.16},
                                   {.noise = 0.268, .rays = 1.533, .noise_of_blocks = 0.680, .error = 0.10}))
      << "staircase";
}

}  // namespace
}  // namespace tessera::test::path_sharing_test
