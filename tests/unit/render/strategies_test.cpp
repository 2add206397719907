// Every strategy of bidirectional path tracing by itself, each of its paths with a weight of 1: all that can
// find the light of so many events find the same, and as much as the path tracer does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "render/transport/bdpt/bidirectional.h"
#include "render/transport/bdpt/merging.h"
#include "render/transport/path/wavefront.h"
#include "support/kernel/kernel_scene.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr std::uint32_t kSide = 16, kBatches = 16;

/// Means of the four quarters of a film and of the whole, green, with their standard errors.
struct Quarters {
  double mean[5] = {}, error[5] = {};
};

/// Measures pictures of batches of samples that share no paths.
template <class MakePicture>
Quarters measure(std::uint32_t samples, MakePicture&& make_picture) {
  double sum[5] = {}, squares[5] = {};
  for (std::uint32_t b = 0; b < kBatches; ++b) {
    const wire::TileResult picture = make_picture(b * samples, (b + 1) * samples);
    double means[5] = {};
    for (std::size_t pixel = 0; pixel < kSide * kSide; ++pixel) {
      const std::size_t q = pixel / kSide / (kSide / 2) * 2 + pixel % kSide / (kSide / 2);
      const double value = double{picture.values[kSide * kSide + pixel]} / samples / (kSide * kSide);
      means[q] += 4 * value;
      means[4] += value;
    }
    for (std::size_t q = 0; q < 5; ++q) {
      sum[q] += means[q];
      squares[q] += means[q] * means[q];
    }
  }
  Quarters result;
  for (int q = 0; q < 5; ++q) {
    result.mean[q] = sum[q] / kBatches;
    const double variance = std::max(0.0, squares[q] / kBatches - result.mean[q] * result.mean[q]);
    result.error[q] = std::sqrt(variance / (kBatches - 1));
  }
  return result;
}

wire::TileResult range_of_samples(const SceneContent& content, std::uint32_t begin, std::uint32_t end) {
  wire::TileResult result = empty_picture(content.tables, end);
  result.sample_begin = begin;
  return result;
}

class Strategies : public testing::Test {
 protected:
  /// `motion`: of the wall.
  void load(const std::string& lights, const std::string& motion = "") {
    content_ = build_kernel_scene(R"(
      camera { perspective { fov_degrees: 60 lens_radius: 0.05 focal_distance: 3 }
               world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
      film { width: 16 height: 16 filter { kind: BOX radius_x: 0.5 radius_y: 0.5 } }
      materials { name: 'paint' diffuse { reflectance { constant { constant: 0.7 } } } }
      materials { name: 'metal' conductor { reflectance { constant { constant: 0.8 } }
                                            roughness { u { constant: 0.5 } v { constant: 0.5 } } } }
      shapes { disk { radius: 3 } material: 'paint'
        world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,-1,1, 0,0,0,1] } )" +
                                      motion + R"( }
      shapes { sphere { radius: 0.6 } material: 'metal'
        world_from_object { elements: [1,0,0,-0.7, 0,1,0,-0.4, 0,0,1,0, 0,0,0,1] } }
      shapes { sphere { radius: 0.5 } material: 'paint'
        world_from_object { elements: [1,0,0,0.8, 0,1,0,-0.2, 0,0,1,0, 0,0,0,1] } }
    )" + lights,
                                  kSide, {}, "bdpt");
  }

  /// The light of `max_depth` events or fewer, less what one event fewer does: the same paths in both.
  Quarters by_path(std::int32_t events) const {
    return measure(64, [&](std::uint32_t begin, std::uint32_t end) {
      wire::TileResult more = render_path(events, begin, end);
      const wire::TileResult less = render_path(events - 1, begin, end);
      for (std::size_t i = 0; i < more.values.size(); ++i) more.values[i] -= less.values[i];
      return more;
    });
  }
  /// All that paths of up to five events bring.
  Quarters by_path() const {
    return measure(64, [&](std::uint32_t begin, std::uint32_t end) { return render_path(5, begin, end); });
  }
  Quarters alone(int s, int t) const { return from_both_ends({s, t}, 0); }
  /// The same by all strategies, vertices merged within this radius in the first pass; 0: none are.
  Quarters merged(float radius) const { return from_both_ends({}, radius); }

  /// `first`: the fewest vertices from the light with which it is found at all.
  void expect_all_the_same(int first) const {
    for (int events = 1; events <= 3; ++events) {
      const Quarters expected = by_path(events);
      for (int s = first; s <= events + 1; ++s) {
        const Quarters found = alone(s, events + 2 - s);
        for (int q = 0; q < 5; ++q) {
          // Six standard errors with 15 degrees of freedom each: one comparison in 40,000.
          EXPECT_NEAR(found.mean[q], expected.mean[q], 6 * std::hypot(found.error[q], expected.error[q]))
              << "s = " << s << ", t = " << events + 2 - s << ", quarter " << q;
        }
        EXPECT_GT(found.mean[4], 4 * found.error[4]) << "too noisy to tell anything";
      }
    }
  }

  void expect_limit_of_merging() const;

 private:
  Quarters from_both_ends(StrategyFilter filter, float radius) const {
    return measure(64, [&](std::uint32_t begin, std::uint32_t end) {
      wire::TileResult result = range_of_samples(*content_, begin, end);
      RenderStats stats;
      PassFilm film(result, content_->tables.filter);
      auto merging = radius > 0 ? std::make_unique<Merging>(content_->tables, radius) : nullptr;
      Bidirectional integrator({content_->tables, *content_->rays, 7, stats}, filter, std::move(merging));
      while (film.begin_pass()) {
        EXPECT_TRUE(integrator.render(film, film, {}));
        film.end_pass();
      }
      return result;
    });
  }
  wire::TileResult render_path(std::int32_t max_depth, std::uint32_t begin, std::uint32_t end) const {
    wire::TileResult result = range_of_samples(*content_, begin, end);
    RenderStats stats;
    FixedTile film(result);
    Wavefront integrator({content_->tables, *content_->rays, 11, stats}, max_depth);
    EXPECT_TRUE(integrator.render(film, film, {}));
    return result;
  }

  std::shared_ptr<const SceneContent> content_;
};

constexpr const char* kSoftPoint =
    " lights { point { position { x: 0.5 y: 1.5 z: -1.5 } intensity { constant: 3 } radius: 0.6 } }";
/// The balls stand in its light.
constexpr const char* kSoftSpotAbout =
    " lights { spot { position { x: 0.1 z: -0.3 } target { x: 0.3 y: -0.2 z: 1 } intensity { constant: 2 }"
    " cone_angle_degrees: 80 cone_delta_degrees: 40 radius: 0.9 } }";

constexpr const char* kLamp =
    " shapes { disk { radius: 0.9 } area_light { radiance { constant: 2 } two_sided: true }"
    "          world_from_object { elements: [1,0,0,0.2, 0,0,-1,1.6, 0,1,0,0, 0,0,0,1] } }";

TEST_F(Strategies, OfALamp) {
  load(kLamp);
  expect_all_the_same(0);
}

void Strategies::expect_limit_of_merging() const {
  const Quarters expected = by_path(), none = merged(0), least = merged(1e-6f), small = merged(0.3f),
                 large = merged(0.6f);
  for (int q = 0; q < 5; ++q) {
    SCOPED_TRACE(q);
    // Six standard errors with 15 degrees of freedom each: one comparison in 40,000.
    const auto expect_near = [&](double mean, double error) {
      EXPECT_NEAR(mean, expected.mean[q], 6 * std::hypot(error, expected.error[q]));
    };
    expect_near(none.mean[q], none.error[q]);
    expect_near(least.mean[q], least.error[q]);
    // Bias goes with the squared radius, which falls alike from pass to pass in both.
    expect_near((4 * small.mean[q] - large.mean[q]) / 3, std::hypot(4 * small.error[q], large.error[q]) / 3);
  }
  // Something is merged, and more of it with a larger radius.
  EXPECT_NE(large.mean[4], small.mean[4]);
  EXPECT_NE(small.mean[4], none.mean[4]);
}

TEST_F(Strategies, MergedGoToThePathTracersPictureAsRadiiGoToZero) {
  for (const char* const light : {kLamp, kSoftPoint}) {
    SCOPED_TRACE(light);
    load(light);
    expect_limit_of_merging();
  }
}

TEST_F(Strategies, MergedGoWithWhatMoves) {
  load(kLamp, "world_from_object_end { elements: [1,0,0,0, 0,1,0,0, 0,0,-1,2.5, 0,0,0,1] }");
  const Quarters expected = by_path(), large = merged(0.6f);
  // A large radius costs 0.4 % here; photons of other moments, which are elsewhere, would cost 3 %.
  EXPECT_NEAR(large.mean[4], expected.mean[4], 0.01 * expected.mean[4]);
  EXPECT_LT(6 * std::hypot(large.error[4], expected.error[4]), 0.02 * expected.mean[4]);
}

TEST_F(Strategies, OfASky) {
  load(" lights { infinite { radiance { constant: 0.5 } } }");
  expect_all_the_same(0);
}

TEST_F(Strategies, OfALightAtAPoint) {
  load(" lights { point { position { x: 0.5 y: 1.5 z: -1.5 } intensity { constant: 3 } } }");
  expect_all_the_same(1);
}

TEST_F(Strategies, OfSoftLights) {
  for (const char* const light : {kSoftPoint, kSoftSpotAbout}) {
    SCOPED_TRACE(light);
    load(light);
    expect_all_the_same(1);
  }
}

TEST_F(Strategies, OfADistantLight) {
  load(" lights { distant { direction { x: 0.3 y: -0.5 z: 1 } irradiance { constant: 2 } } }");
  expect_all_the_same(1);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
