// A scene that is being built, and a unit that is being rendered, end soon after a stop is requested. How
// soon is counted in work, not in time.
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "render/accel/embree/accelerator.h"
#include "render/accel/stoppable_query.h"
#include "render/accel/structure/scene_structure.h"
#include "render/color/texture_table.h"
#include "render/core/stopped.h"
#include "render/kernel/kernel.h"
#include "render/scene/load_scene.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/mesh_blob.h"

namespace tessera::test::stops {
namespace {

using render::Stopped;

constexpr const char* kScene = R"(
film { width: 64 height: 64 }
camera { perspective { fov_degrees: 45 }
  world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-5, 0,0,0,1] } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
lights { infinite { radiance { constant: 0.3 } } }
shapes { material: 'white' sphere { radius: 1 } }
shapes { material: 'white' disk { radius: 3 } }
)";

absl::StatusOr<render::BlobBytes> no_blob(const std::string& digest) { return absl::NotFoundError(digest); }

class Stops : public testing::Test {
 protected:
  Stops() {
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(kScene, &scene_));
    job_.mutable_view()->set_width(64), job_.mutable_view()->set_height(64);
    job_.mutable_view()->set_max_depth(3);
    job_.mutable_content()->mutable_algorithms()->set_integrator("path");
    job_.mutable_samples()->set_spp(4);
    options_.isa = render::supported_isas().front();
    options_.stop = source_.get_token();
  }

  std::stop_source source_;
  v1::Scene scene_;
  v1::JobSpec job_;
  render::LoadOptions options_;
};

TEST_F(Stops, EndTheBuildOfEveryStructure) {
  for (int a = v1::ACCELERATOR_UNSPECIFIED; a <= v1::Accelerator_MAX; ++a) {
    SCOPED_TRACE(wire::word_of(static_cast<v1::Accelerator>(a)));
    job_.mutable_content()->mutable_algorithms()->set_accelerator(static_cast<v1::Accelerator>(a));
    std::stop_source source;
    options_.stop = source.get_token();
    options_.geometry_read = [&source] { source.request_stop(); };
    const auto loaded = render::load_scene(scene_, job_, no_blob, options_);
    EXPECT_TRUE(absl::IsCancelled(loaded.status())) << loaded.status();
  }
}

TEST_F(Stops, AskForNoFurtherBlob) {
  for (int i = 0; i < 100; ++i) {
    v1::TriangleMesh& mesh = *scene_.add_shapes()->mutable_mesh();
    mesh.mutable_blob()->set_digest(std::to_string(i));
  }
  int asked = 0;
  const render::BlobSource blobs = [&](const std::string&) -> absl::StatusOr<render::BlobBytes> {
    ++asked;
    source_.request_stop();
    return absl::UnavailableError("later");
  };
  EXPECT_FALSE(render::load_scene(scene_, job_, blobs, options_).ok());
  EXPECT_EQ(asked, 1);
}

/// The last vertex of the mesh would be an error, if it were still looked at.
TEST_F(Stops, EndAMeshBeforeItsLastVertex) {
  wire::MeshData mesh;
  mesh.positions.assign(3 * 5000, 1);
  mesh.positions.back() = 1e30f;
  mesh.indices = {0, 1, 2};
  const auto bytes = std::make_shared<std::string>(wire::encode_mesh(mesh));
  v1::Shape& shape = *scene_.add_shapes();
  shape.mutable_mesh()->mutable_blob()->set_digest("mesh");
  for (int i = 0; i < 16; ++i)
    shape.mutable_world_from_object()->add_elements(i % 5 > 0 ? 0 : i < 15 ? 1e15 : 1);
  bool stops = false;
  const render::BlobSource blobs = [&](const std::string&) -> absl::StatusOr<render::BlobBytes> {
    if (stops) source_.request_stop();
    return render::BlobBytes{*bytes, bytes};
  };
  EXPECT_TRUE(absl::IsInvalidArgument(render::load_scene(scene_, job_, blobs, options_).status()));
  stops = true;
  const auto stopped = render::load_scene(scene_, job_, blobs, options_);
  EXPECT_TRUE(absl::IsCancelled(stopped.status())) << stopped.status();
}

/// A cell of millions is split in passes over all of them, each of which looks for a stop.
TEST(StopsOfBuilders, AreSeenWithinASplit) {
  using namespace render;
  std::vector<KdRef> refs;
  Box cell;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto x = static_cast<float>(i);
    const float low[3] = {x, x, x}, high[3] = {x + 1, x + 2, x + 3};
    Box part;
    part.add(low);
    part.add(high);
    refs.push_back({part, i});
    cell.add(part);
  }
  std::stop_source source;
  const std::stop_token stop = source.get_token();
  EXPECT_GE(split_by_sah(refs, cell, stop).axis, 0);
  EXPECT_GE(split_at_median(refs, cell, 0, stop).axis, 0);
  source.request_stop();
  EXPECT_THROW(split_by_sah(refs, cell, stop), Stopped);
  EXPECT_THROW(split_at_median(refs, cell, 0, stop), Stopped);
}

/// The builders themselves: none begins a node when a stop has been requested.
TEST(StopsOfBuilders, AreSeenByEachOfThem) {
  using namespace render;
  std::vector<Primitive> list(10'000);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto x = static_cast<float>(i % 100), y = static_cast<float>(i / 100);
    const float corners[3][3] = {{x, y, 0}, {x + 1, y, 1}, {x, y + 1, 2}};
    std::copy_n(&corners[0][0], 9, &list[i].corners[0][0]);
  }
  std::stop_source source;
  source.request_stop();
  const std::stop_token stop = source.get_token();
  EXPECT_THROW(build_bvh(BvhRule::kMedian, list, 2, stop), Stopped);
  EXPECT_THROW(build_bvh(BvhRule::kSah, list, 2, stop), Stopped);
  EXPECT_THROW(build_sphere_tree(list, 2, stop), Stopped);
  EXPECT_THROW(build_grid(list, kGridDensity, 2, stop).IgnoreError(), Stopped);
  EXPECT_THROW(build_octree(list, 2, stop), Stopped);
  EXPECT_THROW(build_bsp_tree(list, 2, stop), Stopped);
  EXPECT_THROW(build_kd_tree(KdRule::kMedian, list, 2, stop), Stopped);
  EXPECT_THROW(build_kd_tree(KdRule::kSah, list, 2, stop), Stopped);
  Bvh bvh = build_bvh(BvhRule::kSah, list, 2);
  EXPECT_THROW(widen(list, bvh, stop), Stopped);
  KdTree kd = build_kd_tree(KdRule::kMedian, list, 2);
  EXPECT_THROW(widen(list, kd, stop), Stopped);
}

/// Boxes in a row; the one at `stop_at` requests the stop.
struct BoxesInARow {
  static constexpr unsigned kCount = 1u << 20;
  static inline unsigned stop_at = 0;
  static inline std::stop_source source;
  static inline std::atomic<unsigned> asked;

  static unsigned count(const render::ShapeTable&, std::int32_t) { return kCount; }
  static void bound(const RTCBoundsFunctionArguments* args) {
    if (++asked == stop_at) source.request_stop();
    const auto x = static_cast<float>(args->primID);
    *args->bounds_o = {x, 0, 0, 0, x + 1, 1, 1, 0};
  }
};

TEST(StopsOfBuilders, EndEmbreesBuild) {
  render::ShapeTable table;
  table.shapes.push_back({.kind = render::ShapeKind::kSphere});
  table.world_shape_count = 1;
  const render::TextureTable textures;
  render::GeometryCallbacks callbacks;
  callbacks.count_primitives = BoxesInARow::count;
  callbacks.bound = BoxesInARow::bound;
  render::BuildOptions options;
  options.stop = BoxesInARow::source.get_token();
  ASSERT_TRUE(render::Accelerator::build(table, textures, callbacks, options).ok());
  EXPECT_GE(BoxesInARow::asked.exchange(0), BoxesInARow::kCount);

  BoxesInARow::stop_at = BoxesInARow::kCount / 2;
  EXPECT_THROW(render::Accelerator::build(table, textures, callbacks, options).IgnoreError(), Stopped);
  // No pass over all boxes is begun after the one at hand.
  EXPECT_LE(BoxesInARow::asked, BoxesInARow::kCount);
}

/// Counts the rays that it is asked, and where their arrays begin.
class CountingQuery final : public render::RayQuery {
 public:
  void nearest(const render::RayArrays& rays, int n, bool, const render::HitArrays& hits) const override {
    for (int i = 0; i < n; ++i) hits.t[i] = rays.ox[i];
    count(n);
  }
  void occluded(const render::RayArrays& rays, int n, float* distance) const override {
    for (int i = 0; i < n; ++i) distance[i] = -rays.ox[i];
    count(n);
  }
  void count(int n) const {
    asked += n;
    if (asked >= stop_after) source.request_stop();
  }
  mutable int asked = 0;
  int stop_after = 1 << 30;
  mutable std::stop_source source;
};

TEST(StoppableQuery, HandsOnEveryRayAndEndsWithinAFewDozen) {
  constexpr int kRays = 1000;
  alignas(64) float x[1024], t[1024] = {}, distance[1024] = {};
  alignas(64) std::int32_t number[1024];
  std::iota(x, x + 1024, 1.0f);
  const render::RayArrays rays{x, x, x, x, x, x};
  const render::HitArrays hits{t, t, t, number, number, number};
  CountingQuery all;
  const std::stop_token never = all.source.get_token();
  const render::StoppableQuery query(all, 64, never);
  query.nearest(rays, kRays, true, hits);
  query.occluded(rays, kRays, distance);
  for (int i = 0; i < kRays; ++i) ASSERT_TRUE(t[i] == x[i] && distance[i] == -x[i]) << i;
  EXPECT_EQ(all.asked, 2 * kRays);

  CountingQuery slow;
  slow.stop_after = 200;
  const std::stop_token stop = slow.source.get_token();
  const render::StoppableQuery stopped(slow, 64, stop);
  EXPECT_THROW(stopped.nearest(rays, kRays, false, hits), Stopped);
  EXPECT_LT(slow.asked, 200 + 64);
  EXPECT_THROW(stopped.occluded(rays, kRays, distance), Stopped);
  EXPECT_LT(slow.asked, 200 + 64);
}

/// An algorithm that never looks whether it is to stop, and traces rays without end.
class Endless final : public render::Integrator {
 public:
  explicit Endless(const render::IntegratorContext& context) : rays_(context.rays) {}
  bool render(render::SampleSource&, render::Film&, std::stop_token) override {
    alignas(64) float zero[16] = {}, one[16], t[16];
    alignas(64) std::int32_t number[16];
    std::fill_n(one, 16, 1.0f);
    for (calls = 0; calls < 10'000; ++calls) {
      if (calls == 10) source.request_stop();
      rays_.nearest({zero, zero, zero, zero, zero, one}, 16, false, {t, t, t, number, number, number});
    }
    return true;
  }
  static inline int calls = 0;
  static inline std::stop_source source;

 private:
  const render::RayQuery& rays_;
};

TEST_F(Stops, EndAUnitWhateverItsAlgorithmDoes) {
  wire::add_algorithm({.name = "endless", .bias = wire::Bias::kBiased});
  render::add_algorithm(
      {.name = "endless",
       .make = [](const render::IntegratorContext& context) -> std::unique_ptr<render::Integrator> {
         return std::make_unique<Endless>(context);
       }});
  job_.mutable_content()->mutable_algorithms()->set_integrator("endless");
  job_.mutable_view()->set_path_sharing(v1::PATH_SHARING_OFF);
  const auto loaded = render::load_scene(scene_, job_, no_blob, options_);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  render::RenderStats stats;
  const auto tile = (*loaded)->render_tile({0, 0, 8, 8, 0, 4}, Endless::source.get_token(), stats);
  EXPECT_TRUE(absl::IsCancelled(tile.status())) << tile.status();
  EXPECT_EQ(Endless::calls, 10);
}

}  // namespace
}  // namespace tessera::test::stops
