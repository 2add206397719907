// Mutations of paths vertex by vertex: what chains carry from one part of the paths to another, they carry
// back, by each strategy alone; and the discrete choices of lengths are the distributions that they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "render/integrator/mlt/path_space/grower.h"
#include "render/integrator/mlt/path_space/mutations.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kMost = 7;

TEST(LengthChoice, ChoosesEndsAsLikelyAsItSays) {
  const LengthChoice lengths(kMost);
  for (int events = 1; events <= kMost; ++events) {
    std::map<std::pair<int, int>, double> found;
    constexpr int kSteps = 1 << 16;
    for (int i = 0; i < kSteps; ++i) {
      const KeptEnds kept = lengths.choose_kept(events, (i + 0.5) / kSteps);
      ASSERT_TRUE(kept.eye >= 0 && kept.eye <= events && kept.light >= 0 && kept.removed(events) >= 0);
      found[{kept.eye, kept.light}] += 1.0 / kSteps;
    }
    double sum = 0;
    for (int eye = 0; eye <= events; ++eye) {
      for (int light = 0; light <= events + 1 - eye; ++light) {
        const double probability = lengths.kept_probability(events, {eye, light});
        // One step at either end of its interval.
        EXPECT_NEAR((found[{eye, light}]), probability, 2.0 / kSteps)
            << events << ": " << eye << ", " << light;
        sum += probability;
      }
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(LengthChoice, AddsVerticesAsLikelyAsItSays) {
  const LengthChoice lengths(kMost);
  for (int eye = 0; eye <= kMost; ++eye) {
    for (int light = 0; light <= kMost + 1 - eye; ++light) {
      for (int removed = 0; removed + eye + light <= kMost + 1; ++removed) {
        if (removed + eye + light < 2 || (light == 0 && removed == 0)) continue;  // of no path
        const KeptEnds kept{eye, light};
        std::vector<double> found(kMost + 3, 0.0);
        constexpr int kSteps = 1 << 12;
        for (int i = 0; i < kSteps; ++i) {
          const int added = lengths.choose_added(kept, removed, (i + 0.5) / kSteps);
          if (added < 0) continue;
          const int events = eye + light + added - 1;
          ASSERT_TRUE(events >= 1 && events <= kMost) << eye << ", " << light << ": " << added;
          found[static_cast<std::size_t>(added)] += 1.0 / kSteps;
        }
        for (int added = 0; added < kMost + 3; ++added) {
          EXPECT_NEAR(found[static_cast<std::size_t>(added)], lengths.added_probability(kept, removed, added),
                      2.0 / kSteps);
        }
      }
    }
  }
}

/// Glass, a mirror, something glossy and something dull, an area light, a light at a point, one far away and
/// one all around.
const char* const kScene = R"(
  materials { name: 'dull' diffuse { reflectance { constant { constant: 0.7 } } } }
  materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
  materials { name: 'glossy' conductor { reflectance { constant { constant: 0.8 } } roughness { u { constant: 0.2 } v { constant: 0.2 } } } }
  materials { name: 'coat' plastic { } }
  shapes { disk { radius: 4 } material: 'dull' }
  shapes { disk { radius: 3 } material: 'coat' world_from_object { elements: [0,0,1,-2, 0,1,0,0, -1,0,0,1, 0,0,0,1] } }
  shapes { sphere { radius: 0.6 } material: 'glass' world_from_object { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,0.8, 0,0,0,1] } }
  shapes { sphere { radius: 0.4 } material: 'glossy' world_from_object { elements: [1,0,0,-0.8, 0,1,0,0.3, 0,0,1,0.5, 0,0,0,1] } }
  shapes { sphere { radius: 0.4 } area_light { radiance { constant: 12 } }
           world_from_object { elements: [1,0,0,1, 0,1,0,1, 0,0,1,3, 0,0,0,1] } }
  lights { point { position { x: 1.5 y: -1 z: 2 } intensity { constant: 4 } } }
  lights { distant { direction { x: 0.3 y: 0.2 z: -1 } irradiance { constant: 1 } } }
  lights { infinite { radiance { constant: 0.2 } } }
  camera { perspective { fov_degrees: 50 }
           world_from_camera { elements: [1,0,0,0, 0,0.5,0.866,-4, 0,0.866,-0.5,3, 0,0,0,1] } })";

constexpr int kEvents = 6, kClasses = 8;

/// Paths by where they land, by their lengths and by their light.
int class_of(const ExplicitPath& path) {
  return (path.film_x < 8 ? 0 : 1) + (path.events < 3 ? 0 : 2) + (path.luminance < 0.02f ? 0 : 4);
}

class PathSpaceBalance : public testing::Test {
 protected:
  void SetUp() override {
    content_ = build_kernel_scene(kScene, 16, {}, "mlt");
    ASSERT_NE(content_, nullptr);
    tables_.emplace(content_->tables);
    tables_->max_depth = kEvents;
    context_.reset(new IntegratorContext{*tables_, *content_->rays, 1, stats_});
    mutations_.reset(new Mutations(*tables_));
    grower_.reset(new Grower(*context_));
  }

  ProposalNumbers numbers() {
    const auto u = [&] { return std::uniform_real_distribution<float>(0, 0.999999f)(random_); };
    return {u(), u(), u(), u(), u(), u(), u()};
  }

  /// Independent paths, so many, and what each stands for, over the measurement contribution: a sample of it.
  std::vector<double> make_candidates(std::vector<ExplicitPath>& paths, std::uint32_t key) {
    std::vector<Growth> growths;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const ProposalNumbers u = numbers();
      ExplicitPath& path = paths[i];
      path.events = 1 + static_cast<int>(u.kept * kEvents);
      path.time = 0;
      Growth growth{.path = &path, .number = static_cast<std::uint32_t>(i)};
      growth.from_light = static_cast<int>(u.way * static_cast<float>(path.events + 2));
      growth.from_eye = path.events + 1 - growth.from_light;
      mutations_->place_on_film(u, growth);
      growths.push_back(growth);
    }
    grower_->grow(growths, key);
    std::vector<double> light;
    for (const ExplicitPath& path : paths) {
      light.push_back(path.brightness > 0
                          ? kEvents * path.brightness * (path.events + 2) / density_of_ways(path, {})
                          : 0);
    }
    return light;
  }

  std::shared_ptr<const SceneContent> content_;
  std::optional<SceneTables> tables_;
  RenderStats stats_;
  std::unique_ptr<IntegratorContext> context_;
  std::unique_ptr<Mutations> mutations_;
  std::unique_ptr<Grower> grower_;
  std::mt19937 random_{1};
};

TEST_F(PathSpaceBalance, WhatGoesComesBack) {
  constexpr int kBatches = 6000;
  for (const Strategy strategy : {Strategy::kAllNew, Strategy::kBidirectional, Strategy::kLens,
                                  Strategy::kCaustic, Strategy::kMultiChain}) {
    SCOPED_TRACE(static_cast<int>(strategy));
    double sum[kClasses][kClasses] = {}, squares[kClasses][kClasses] = {};
    int pairs = 0;
    std::vector<ExplicitPath> from(kSubpaths), to(kSubpaths);
    for (std::uint32_t batch = 0; batch < kBatches; ++batch) {
      const std::vector<double> light = make_candidates(from, 2 * batch);
      std::vector<Growth> growths;
      std::vector<std::size_t> origins;
      for (std::size_t i = 0; i < from.size(); ++i) {
        if (light[i] == 0) continue;
        Growth growth = mutations_->propose(strategy, from[i], numbers(), to[growths.size()]);
        growth.number = static_cast<std::uint32_t>(i);
        if (!growth.alive) continue;
        growths.push_back(growth);
        origins.push_back(i);
      }
      grower_->grow(growths, 2 * batch + 1);
      double flow[kClasses][kClasses] = {};
      for (std::size_t i = 0; i < growths.size(); ++i) {
        const ExplicitPath &x = from[origins[i]], &y = *growths[i].path;
        const KeptEnds& kept = growths[i].kept;
        const double there = mutations_->acceptance(strategy, x, y, kept);
        if (there == 0) continue;
        ++pairs;
        flow[class_of(x)][class_of(y)] += light[origins[i]] * there / kSubpaths;
        // The equation itself, for this pair.
        const double goes = x.brightness * mutations_->density(strategy, x, y, kept) * there,
                     comes = y.brightness * mutations_->density(strategy, y, x, kept) *
                             mutations_->acceptance(strategy, y, x, kept);
        ASSERT_NEAR(goes, comes, 1e-9 * goes);
      }
      for (int a = 0; a < kClasses; ++a) {
        for (int b = 0; b < kClasses; ++b) {
          const double net = flow[a][b] - flow[b][a];
          sum[a][b] += net;
          squares[a][b] += net * net;
        }
      }
    }
    // Fewer would not fill the classes.
    EXPECT_GT(pairs, 1000);
    int filled = 0;
    for (int a = 0; a < kClasses; ++a) {
      for (int b = 0; b < a; ++b) {
        if (squares[a][b] == 0) continue;
        ++filled;
        const double mean = sum[a][b] / kBatches,
                     error = std::sqrt((squares[a][b] / kBatches - mean * mean) / (kBatches - 1));
        // Six standard errors; 140 comparisons.
        EXPECT_NEAR(mean, 0, 6 * error) << a << " and " << b;
      }
    }
    EXPECT_GT(filled, 4);
  }
}

/// Paths that are measured again, as they stand, are the same: nothing but their vertices decides.
TEST_F(PathSpaceBalance, PathsHaveTheirValuesByThemselves) {
  std::vector<ExplicitPath> paths(kSubpaths);
  const std::vector<double> light = make_candidates(paths, 77);
  const PathMeasure measure(*tables_);
  int bright = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (light[i] == 0) continue;
    ExplicitPath copy;
    copy.take(paths[i]);
    copy.brightness = 0;
    ExplicitPath* lanes[kWidth];
    std::fill_n(lanes, kWidth, &copy);
    measure.measure(lanes, Mask::first(1));
    EXPECT_EQ(copy.brightness, paths[i].brightness);
    EXPECT_EQ(density_of_ways(copy, {}), density_of_ways(paths[i], {}));
    ++bright;
  }
  EXPECT_GT(bright, 3);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
