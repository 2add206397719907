// A scene as kernels see it, for tests that are compiled with them: what stands at a seam of the renderer can
// be tried there without a kernel module.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "render/accel/embree/trace.h"
#include "render/build/scene_content.h"
#include "render/film/fixed_tile.h"
#include "render/integrator/integrator.h"
#include "render/light/light.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/aov_channels.h"

#define TESSERA_ISA_TEXT2(x) #x
#define TESSERA_ISA_TEXT1(x) TESSERA_ISA_TEXT2(x)
#define TESSERA_ISA_TEXT TESSERA_ISA_TEXT1(TESSERA_ISA)

namespace tessera::render::TESSERA_ISA {

/// The content of a scene in protobuf's text form, of a film of `side` pixels squared; null, with a failure,
/// where it cannot be built. Its arrays may be changed before it is rendered, as far as that changes no
/// bounds.
inline std::shared_ptr<SceneContent> build_kernel_scene(const std::string& text, std::uint32_t side) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  v1::JobSpec job;
  job.mutable_view()->set_width(side);
  job.mutable_view()->set_height(side);
  job.mutable_view()->set_max_depth(5);
  const auto no_blobs = [](const std::string&) -> absl::StatusOr<BlobBytes> {
    return absl::NotFoundError("scenes of tests have no blobs");
  };
  auto content = build_content(scene, job, no_blobs, {.isa = TESSERA_ISA_TEXT, .threads = 1}, embree_kernel(),
                               &light_source);
  EXPECT_TRUE(content.ok()) << content.status();
  return content.ok() ? std::const_pointer_cast<SceneContent>(*content) : nullptr;
}

/// All samples of the whole film through an integrator that `make` makes of a context; sums over `samples`
/// each.
template <class Make>
wire::TileResult render_kernel_scene(const SceneContent& content, std::uint32_t samples, Make&& make) {
  wire::TileResult result;
  result.x1 = static_cast<std::uint32_t>(content.tables.camera.width);
  result.y1 = static_cast<std::uint32_t>(content.tables.camera.height);
  result.sample_end = samples;
  result.channels = wire::channels_for_aovs({});
  RenderStats stats;
  FixedTile film(result);
  const std::unique_ptr<Integrator> integrator =
      make(IntegratorContext{content.tables, *content.rays, content.tables.sampler.seed, stats});
  EXPECT_TRUE(integrator->render(film, film, {}));
  EXPECT_EQ(stats.dropped_samples, 0u);
  EXPECT_EQ(stats.samples, result.pixel_count() * samples);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
