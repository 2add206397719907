// A scene as kernels see it, for tests that are compiled with them: what stands at a seam of the renderer can
// be tried there without a kernel module.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "render/accel/accel_entry.h"
#include "render/film/fixed_tile.h"
#include "render/film/pass_film.h"
#include "render/integrator/integrator.h"
#include "render/light/light.h"
#include "render/scene/scene_content.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/aov_channels.h"

#define TESSERA_ISA_TEXT2(x) #x
#define TESSERA_ISA_TEXT1(x) TESSERA_ISA_TEXT2(x)
#define TESSERA_ISA_TEXT TESSERA_ISA_TEXT1(TESSERA_ISA)

namespace tessera::render::TESSERA_ISA {

/// The content of a scene in protobuf's text form, of a film of `side` pixels squared; null, with a failure,
/// where it cannot be built. `edit` may change the arrays that its messages became before anything is made of
/// them: BVH, light selection, flags. Lights are made for `integrator`; empty: the default.
inline std::shared_ptr<const SceneContent> build_kernel_scene(
    const std::string& text, std::uint32_t side, const std::function<void(SceneArrays&)>& edit = {},
    const std::string& integrator = "") {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  v1::JobSpec job;
  job.mutable_content()->mutable_algorithms()->set_integrator(integrator);
  job.mutable_view()->set_width(side);
  job.mutable_view()->set_height(side);
  job.mutable_view()->set_max_depth(5);
  const BlobSource no_blobs = [](const std::string&) -> absl::StatusOr<BlobBytes> {
    return absl::NotFoundError("scenes of tests have no blobs");
  };
  const LoadOptions options{.isa = TESSERA_ISA_TEXT, .threads = 1};
  auto build = ContentBuild::begin(scene, job, no_blobs, options, accel_kernel(), light_sources());
  EXPECT_TRUE(build.ok()) << build.status();
  if (!build.ok()) return nullptr;
  if (edit) edit(build->arrays());
  auto content = build->finish();
  EXPECT_TRUE(content.ok()) << content.status();
  return content.ok() ? *content : nullptr;
}

/// The mean radiance of pixels, which hold sums over samples.
class MeanRadiance {
 public:
  MeanRadiance(const wire::TileResult& picture, std::uint32_t samples)
      : picture_(picture), samples_(samples) {}

  double of_pixel(std::size_t channel, std::size_t i) const {
    return double{picture_.values[channel * picture_.pixel_count() + i]} / samples_;
  }
  double of_film(std::size_t channel) const {
    double sum = 0;
    for (std::size_t i = 0; i < picture_.pixel_count(); ++i) sum += of_pixel(channel, i);
    return sum / static_cast<double>(picture_.pixel_count());
  }

 private:
  const wire::TileResult& picture_;
  const std::uint32_t samples_;
};

/// Room for the whole film.
inline wire::TileResult empty_picture(const SceneTables& tables, std::uint32_t samples) {
  wire::TileResult result;
  result.x1 = static_cast<std::uint32_t>(tables.sensor.width);
  result.y1 = static_cast<std::uint32_t>(tables.sensor.height);
  result.sample_end = samples;
  result.channels = wire::channels_for_aovs({});
  return result;
}

/// All samples of the whole film, by an algorithm that works by tiles. `tables` are the content's, or copies
/// that look at it through another sensor.
template <class Algorithm>
wire::TileResult render_tile(const SceneContent& content, const SceneTables& tables, std::uint32_t samples) {
  wire::TileResult result = empty_picture(tables, samples);
  RenderStats stats;
  FixedTile film(result);
  Algorithm integrator(IntegratorContext{tables, *content.rays, tables.sampler.seed, stats});
  EXPECT_TRUE(integrator.render(film, film, {}));
  EXPECT_EQ(stats.dropped_samples, 0u);
  EXPECT_EQ(stats.samples, result.pixel_count() * samples);
  return result;
}

template <class Algorithm>
wire::TileResult render_tile(const SceneContent& content, std::uint32_t samples) {
  return render_tile<Algorithm>(content, content.tables, samples);
}

/// The same by an algorithm that works by passes.
template <class Algorithm>
wire::TileResult render_passes(const SceneContent& content, std::uint32_t samples) {
  wire::TileResult result = empty_picture(content.tables, samples);
  RenderStats stats;
  PassFilm film(result, content.tables.filter);
  Algorithm integrator(IntegratorContext{content.tables, *content.rays, content.tables.sampler.seed, stats});
  while (film.begin_pass()) {
    EXPECT_TRUE(integrator.render(film, film, {}));
    film.end_pass();
  }
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
