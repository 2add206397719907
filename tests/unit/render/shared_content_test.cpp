// Scenes loaded one after the other share what they have in common, and give the same bits as if they did
// not.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "render/scene/load_scene.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/tile_result.h"

namespace tessera::render {
namespace {

constexpr const char* kScene = R"(
  camera { perspective { fov_degrees: 40 }
    world_from_camera { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
  film { width: 16 height: 12 }
  textures { name: 'tiles' checkerboard { mapping { scale_u: 8 scale_v: 8 } } }
  materials { name: 'm' diffuse { reflectance { texture: 'tiles' } } }
  lights { infinite { radiance { constant: 0.5 } } }
  lights { point { position { x: 3 y: 2 z: -3 } intensity { constant: 20 } } }
  shapes { sphere { radius: 1 } material: 'm' }
  shapes { disk { radius: 4 height: 1.5 } material: 'm' }
)";

class SharedContent : public testing::Test {
 protected:
  SharedContent() {
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(kScene, &scene_));
    job_.mutable_view()->set_width(16), job_.mutable_view()->set_height(12);
    job_.mutable_content()->mutable_algorithms()->set_integrator("path");
    job_.mutable_samples()->set_spp(4);
    job_.mutable_view()->set_max_depth(3);
  }

  static absl::StatusOr<BlobBytes> no_blob(const std::string& digest) { return absl::NotFoundError(digest); }

  static std::unique_ptr<RenderScene> load(const v1::Scene& scene, const v1::JobSpec& job,
                                           SharedContents* contents, const BlobSource& blobs = no_blob) {
    auto loaded = load_scene(scene, job, blobs, {supported_isas().front(), 1, contents});
    EXPECT_TRUE(loaded.ok()) << loaded.status();
    return loaded.ok() ? *std::move(loaded) : nullptr;
  }

  static wire::TileResult picture(const RenderScene& scene, const v1::JobSpec& job) {
    RenderStats stats;
    const auto tile =
        scene.render_tile({0, 0, job.view().width(), job.view().height(), 0, job.samples().spp()}, {}, stats);
    EXPECT_TRUE(tile.ok()) << tile.status();
    return tile.ok() ? *tile : wire::TileResult{};
  }

  /// Loads a scene that differs from the first as `edit` says.
  void expect_shared(bool shared, const std::function<void(v1::Scene&, v1::JobSpec&)>& edit) {
    SharedContents contents;
    const auto first = load(scene_, job_, &contents);
    v1::Scene scene = scene_;
    v1::JobSpec job = job_;
    edit(scene, job);
    const auto second = load(scene, job, &contents), alone = load(scene, job, nullptr);
    ASSERT_TRUE(first && second && alone);
    EXPECT_EQ(second->content() == first->content(), shared);
    EXPECT_EQ(contents.shared(), shared ? 1u : 0u);
    EXPECT_EQ(picture(*second, job).values, picture(*alone, job).values);
  }

  v1::Scene scene_;
  v1::JobSpec job_;
};

TEST_F(SharedContent, WhateverLooksAtTheSceneInAnotherWay) {
  expect_shared(true, [](v1::Scene&, v1::JobSpec&) {});
  expect_shared(true, [](v1::Scene&, v1::JobSpec& job) { job.mutable_samples()->set_spp(16); });
  expect_shared(true, [](v1::Scene& scene, v1::JobSpec&) { scene.mutable_settings()->set_spp(16); });
  expect_shared(true, [](v1::Scene&, v1::JobSpec& job) { job.mutable_view()->set_seed(7); });
  expect_shared(true, [](v1::Scene&, v1::JobSpec& job) { job.mutable_view()->set_max_depth(1); });
  expect_shared(
      true, [](v1::Scene&, v1::JobSpec& job) { job.mutable_view()->set_sampler(v1::SAMPLER_INDEPENDENT); });
  expect_shared(true, [](v1::Scene&, v1::JobSpec& job) {
    job.mutable_view()->set_width(20), job.mutable_view()->set_height(20);
  });
  expect_shared(true, [](v1::Scene&, v1::JobSpec& job) {
    job.mutable_view()->add_aovs(v1::AOV_NORMAL), job.mutable_view()->add_aovs(v1::AOV_ALBEDO);
  });
  expect_shared(true, [](v1::Scene& scene, v1::JobSpec&) {
    scene.mutable_film()->mutable_filter()->set_kind(v1::PixelFilter::GAUSSIAN);
    scene.mutable_film()->set_exposure(2);
  });
  // Read from another file, as frames of an animation are.
  expect_shared(true, [](v1::Scene& scene, v1::JobSpec&) {
    scene.set_name("frame 2");
    scene.mutable_shapes(0)->set_name("sphere, frame.0002.pbrt:7");
  });
  // Turned about its own place, and with another lens.
  expect_shared(true, [](v1::Scene& scene, v1::JobSpec&) {
    auto& elements = *scene.mutable_camera()->mutable_world_from_camera()->mutable_elements();
    elements[0] = 0.8f, elements[2] = 0.6f, elements[8] = -0.6f, elements[10] = 0.8f;
    scene.mutable_camera()->mutable_perspective()->set_lens_radius(0.1f);
    scene.mutable_camera()->mutable_perspective()->set_focal_distance(3);
  });
}

TEST_F(SharedContent, NothingThatMakesAnotherScene) {
  expect_shared(false, [](v1::Scene& scene, v1::JobSpec&) {
    scene.mutable_shapes(0)->mutable_sphere()->set_radius(2);
  });
  expect_shared(false, [](v1::Scene& scene, v1::JobSpec&) {
    scene.mutable_camera()->mutable_world_from_camera()->set_elements(3, 0);  // positions are relative to it
  });
  expect_shared(false, [](v1::Scene&, v1::JobSpec& job) {
    job.mutable_content()->mutable_algorithms()->set_light_selection(v1::LIGHT_SELECTION_UNIFORM);
  });
  expect_shared(false, [](v1::Scene&, v1::JobSpec& job) {
    job.mutable_content()->mutable_algorithms()->set_integrator("light");
  });
  expect_shared(false, [](v1::Scene& scene, v1::JobSpec&) {
    *scene.mutable_camera()->mutable_world_from_camera_end() = scene.camera().world_from_camera();
    scene.mutable_camera()->mutable_world_from_camera_end()->set_elements(7, 0.5f);
  });
}

TEST_F(SharedContent, ManyViewsAboutOneOrigin) {
  v1::Point3& origin = *scene_.mutable_render_origin();
  origin.set_x(0.25), origin.set_y(1), origin.set_z(-2);
  const auto stand_elsewhere = [](v1::Scene& scene, v1::JobSpec&) {
    auto& elements = *scene.mutable_camera()->mutable_world_from_camera()->mutable_elements();
    elements[3] = -0.75f, elements[7] = 0.5f, elements[11] = -3;
  };
  expect_shared(true, stand_elsewhere);
  expect_shared(true, [&](v1::Scene& scene, v1::JobSpec& job) {
    stand_elsewhere(scene, job);
    scene.mutable_camera()->mutable_orthographic();
  });
  expect_shared(false, [](v1::Scene& scene, v1::JobSpec&) { scene.mutable_render_origin()->set_x(0.5); });
  expect_shared(false, [](v1::Scene& scene, v1::JobSpec&) { scene.clear_render_origin(); });
}

/// The mean of |a - b| over that of a, both of the same picture.
double mean_difference(const wire::TileResult& a, const wire::TileResult& b) {
  double difference = 0, sum = 0;
  for (std::size_t i = 0; i < 3 * a.pixel_count(); ++i) {
    difference += std::abs(double{a.values[i]} - b.values[i]);
    sum += a.values[i];
  }
  return difference / sum;
}

TEST_F(SharedContent, TheOriginIsNotSeen) {
  // Between the camera's place and a point 1 away from it, floats differ in their last places: 1e-7 of a
  // unit, which moves a hit across the border of a tile or a shadow now and then. Each of the 768 samples
  // counts 1 / 768 of the picture, and those near borders by 1e-6 are fewer than one; three may.
  for (const char* integrator : {"path", "light"}) {
    job_.mutable_content()->mutable_algorithms()->set_integrator(integrator);
    for (const bool spherical : {false, true}) {
      if (spherical && integrator == std::string("light")) continue;
      v1::Scene scene = scene_;
      if (spherical) scene.mutable_camera()->mutable_spherical();
      if (!spherical) {
        scene.mutable_camera()->mutable_perspective()->set_lens_radius(0.05f);
        scene.mutable_camera()->mutable_perspective()->set_focal_distance(3);
      }
      const auto usual = load(scene, job_, nullptr);
      scene.mutable_render_origin()->set_x(1);
      scene.mutable_render_origin()->set_z(-4.5);
      const auto moved = load(scene, job_, nullptr);
      ASSERT_TRUE(usual && moved);
      EXPECT_LT(mean_difference(picture(*usual, job_), picture(*moved, job_)), 3.0 / 768)
          << integrator << " " << spherical;
    }
  }
}

TEST_F(SharedContent, FarFromTheWorldsOriginFloatsHoldWhatIsNearTheRenderOrigin) {
  // 2^20 units away, where floats of world space are 1/8 apart.
  constexpr double kFar = 1 << 20;
  v1::Scene far = scene_;
  const auto move = [](float x) { return static_cast<float>(x + kFar); };
  far.mutable_camera()->mutable_world_from_camera()->set_elements(7, move(0));
  for (v1::Shape& shape : *far.mutable_shapes()) {
    for (int i = 0; i < 16; ++i) shape.mutable_world_from_object()->add_elements(i % 5 == 0 ? 1.0f : 0.0f);
    shape.mutable_world_from_object()->set_elements(7, move(0));
  }
  far.mutable_lights(1)->mutable_point()->mutable_position()->set_y(2 + kFar);
  far.mutable_render_origin()->set_y(kFar + 0.5);
  const auto here = load(scene_, job_, nullptr), there = load(far, job_, nullptr);
  ASSERT_TRUE(here && there);
  EXPECT_LT(mean_difference(picture(*here, job_), picture(*there, job_)), 3.0 / 768);
}

TEST_F(SharedContent, ScenesInWhichThingsMoveShareTheirPictures) {
  // Two pixels of a PFM file.
  const float texels[] = {0.25f, 0.5f, 0.75f, 0.75f, 0.5f, 0.25f};
  std::string file = "PF\n2 1\n-1\n";
  file.append(reinterpret_cast<const char*>(texels), sizeof(texels));
  int reads = 0;
  const BlobSource blobs = [&](const std::string&) -> absl::StatusOr<BlobBytes> {
    ++reads;
    return BlobBytes{file, nullptr};
  };
  v1::ImageTexture& image = *scene_.mutable_textures(0)->mutable_image();
  image.mutable_image()->set_digest("picture");
  image.mutable_image()->set_path("picture.pfm");
  scene_.mutable_textures(0)->set_name("tiles");
  SharedContents contents;
  const auto first = load(scene_, job_, &contents, blobs);
  v1::Scene moved = scene_;
  for (int i = 0; i < 16; ++i)
    moved.mutable_shapes(0)->mutable_world_from_object()->add_elements(i % 5 == 0 ? 1.0f : 0.0f);
  moved.mutable_shapes(0)->mutable_world_from_object()->set_elements(3, 0.5f);
  const auto second = load(moved, job_, &contents, blobs);
  EXPECT_EQ(reads, 1);
  EXPECT_EQ(contents.images().shared(), 1u);
  const auto alone = load(moved, job_, nullptr, blobs);
  ASSERT_TRUE(first && second && alone);
  EXPECT_NE(first->content(), second->content());
  EXPECT_EQ(picture(*second, job_).values, picture(*alone, job_).values);
  EXPECT_NE(picture(*second, job_).values, picture(*first, job_).values);
  // In another encoding it is another picture.
  image.set_encoding(v1::ImageTexture::SRGB);
  const auto encoded = load(scene_, job_, &contents, blobs);
  EXPECT_EQ(contents.images().shared(), 1u);
}

TEST_F(SharedContent, OutlivesTheSceneThatItWasBuiltFor) {
  SharedContents contents;
  auto first = load(scene_, job_, &contents);
  const auto second = load(scene_, job_, &contents);
  const wire::TileResult before = picture(*second, job_);
  first.reset();
  EXPECT_EQ(picture(*second, job_).values, before.values);
}

TEST_F(SharedContent, IsGoneWithTheLastSceneThatHasIt) {
  SharedContents contents;
  load(scene_, job_, &contents).reset();
  load(scene_, job_, &contents).reset();
  EXPECT_EQ(contents.shared(), 0u);
}

}  // namespace
}  // namespace tessera::render
