// Pictures of objects within objects: as of the same scene flattened by hand, and of more than could be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <google/protobuf/text_format.h>

#include <array>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "image/image.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"

namespace tessera::test::nested_scene {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kWorld = R"(
film { width: 64 height: 64 filter { kind: BOX } }
camera { perspective { fov_degrees: 40 }
  world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-6, 0,0,0,1] } }
lights { infinite { radiance { constant: 0.4 } } }
lights { distant { direction { x: 1 y: -2 z: 1 } irradiance { constant: 2 } } }
materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } }
materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
shapes { name: 'floor' material: 'white' disk { radius: 9 }
  world_from_object { elements: [1,0,0,0, 0,0,1,-1.6, 0,-1,0,0, 0,0,0,1] } }
)";

/// Four levels: an ellipsoid and a box in glass, turned, squashed, and mirrored at two of the levels.
constexpr const char* kGraph = R"(
objects { name: 'pin' shapes { name: 'head' material: 'white' ellipsoid { radii: [0.5, 0.3, 0.4] } }
  shapes { name: 'foot' material: 'glass' box { low: [-0.2, -1, -0.2] high: [0.2, -0.35, 0.3] } } }
objects { name: 'pair' shapes { name: 'bar' material: 'white'
  cylinder { radius: 0.06 z_min: -1 z_max: 1 capped: true } }
  instances { object: 'pin' world_from_instance { elements: [0.8,0,0,0, 0,0.8,0,0.1, 0,0,0.8,0.8, 0,0,0,1] } }
  instances { object: 'pin' world_from_instance {
    elements: [-0.6,0.3,0,0.1, 0.2,0.7,0,0, 0,0,0.5,-0.8, 0,0,0,1] } } }
objects { name: 'cross'
  instances { object: 'pair' world_from_instance { elements: [0,0,1,0, 0,1,0,0, -1,0,0,0, 0,0,0,1] } }
  instances { object: 'pair' world_from_instance {
    elements: [1,0,0,0.2, 0,-1.1,0,0.5, 0,0.2,0.7,0, 0,0,0,1] } } }
instances { object: 'cross' world_from_instance { elements: [1,0,0,-1, 0,1,0,-0.5, 0,0,1,0, 0,0,0,1] } }
instances { object: 'pin' world_from_instance { elements: [0.5,0,0,0, 0,0.5,0,1.5, 0,0,0.5,0, 0,0,0,1] } }
instances { object: 'cross' world_from_instance {
  elements: [0.6,0.3,0,1.2, -0.3,0.9,0,0, 0,0,-0.8,-0.3, 0,0,0,1] } }
)";

using Matrix = std::array<double, 16>;

Matrix matrix_of(const v1::Matrix& message) {
  Matrix m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  if (!message.elements().empty()) std::copy_n(message.elements().begin(), 16, m.begin());
  return m;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix r{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k < 4; ++k) r[4 * i + j] += a[4 * i + k] * b[4 * k + j];
    }
  }
  return r;
}

/// The scene with instances in the world alone, one for each way down to an object with shapes; `origins` has
/// the number of the instance that each comes from.
v1::Scene flattened_by_hand(const v1::Scene& scene, std::vector<float>& origins) {
  v1::Scene flat = scene;
  flat.clear_instances();
  for (v1::Object& object : *flat.mutable_objects()) object.clear_instances();
  origins = {0};
  const auto object_of = [&](const std::string& name) -> const v1::Object& {
    return *std::ranges::find_if(scene.objects(), [&](const v1::Object& o) { return o.name() == name; });
  };
  const auto place = [&](auto& self, const v1::Instance& instance, const Matrix& outer,
                         float origin) -> void {
    const Matrix all = product(outer, matrix_of(instance.world_from_instance()));
    const v1::Object& object = object_of(instance.object());
    if (object.shapes_size() > 0) {
      v1::Instance& own = *flat.add_instances();
      own.set_object(object.name());
      for (const double x : all) own.mutable_world_from_instance()->add_elements(x);
      origins.push_back(origin);
    }
    for (const v1::Instance& inner : object.instances()) self(self, inner, all, origin);
  };
  for (int i = 0; i < scene.instances_size(); ++i)
    place(place, scene.instances(i), matrix_of({}), static_cast<float>(i + 1));
  return flat;
}

v1::Scene scene_of(const std::string& text) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene));
  return scene;
}

absl::StatusOr<LoadedFile> load(const v1::Scene& scene, v1::Nesting nesting, std::uint32_t spp,
                                const std::string& integrator = "path",
                                v1::Accelerator accelerator = v1::ACCELERATOR_UNSPECIFIED) {
  SceneJob job;
  job.settings.set_spp(spp);
  job.settings.set_integrator(integrator);
  job.settings.set_nesting(nesting);
  job.settings.set_accelerator(accelerator);
  job.aovs = {v1::AOV_NORMAL, v1::AOV_DEPTH, v1::AOV_ID};
  std::string text;
  google::protobuf::TextFormat::PrintToString(scene, &text);
  return load_scene_text(text, job, render::supported_isas().front());
}

client::Image picture(const v1::Scene& scene, v1::Nesting nesting, std::uint32_t spp,
                      v1::Accelerator accelerator = v1::ACCELERATOR_UNSPECIFIED) {
  const auto file = load(scene, nesting, spp, "path", accelerator);
  EXPECT_TRUE(file.ok()) << file.status();
  return file.ok() ? render_image(*file) : client::Image{};
}

float value(const client::Image& image, const char* channel, std::size_t i) {
  return image.find(channel)->values[i];
}

double mean(const client::Image& image, const char* channel) {
  double sum = 0;
  for (const float x : image.find(channel)->values) sum += x;
  return sum / static_cast<double>(image.find(channel)->values.size());
}

/// Both pictures have the same random numbers, so their paths part only where rounding has a ray pass an edge
/// on its other side, which moves it by some 1e-6 of the picture's 64 pixels, and roughly: at once in glass,
/// after a bounce where it strikes an edge. Of 4096 pixels of a sample 1 % may have another first hit, 3 %
/// another light.
void expect_same_picture(const client::Image& a, const client::Image& b, const std::vector<float>& origins) {
  const std::size_t pixels = a.find("R")->values.size();
  ASSERT_EQ(pixels, b.find("R")->values.size());
  std::size_t other_hit = 0, other_light = 0, in_instances = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    const auto origin = origins[static_cast<std::size_t>(value(b, "id.instance", i))];
    in_instances += origin > 0;
    // Depths are about 6, and off by some roundings of that, more where surfaces are seen askew.
    const bool same_hit = value(a, "id.shape", i) == value(b, "id.shape", i) &&
                          value(a, "id.instance", i) == origin &&
                          std::abs(value(a, "depth.Z", i) - value(b, "depth.Z", i)) < 1e-4;
    other_hit += !same_hit;
    if (!same_hit) continue;
    for (const char* channel : {"normal.X", "normal.Y", "normal.Z"})
      EXPECT_NEAR(value(a, channel, i), value(b, channel, i), 1e-3) << channel << " of pixel " << i;
    other_light += std::abs(value(a, "R", i) - value(b, "R", i)) > 1e-3 * (0.1 + value(b, "R", i));
  }
  EXPECT_GT(in_instances, pixels / 8);
  EXPECT_LE(other_hit, pixels / 100);
  EXPECT_LE(other_light, 3 * pixels / 100);
}

TEST(NestedScene, IsWhatItIsFlattenedByHand) {
  const v1::Scene scene = scene_of(absl::StrCat(kWorld, kGraph));
  std::vector<float> origins;
  const v1::Scene flat = flattened_by_hand(scene, origins);
  ASSERT_EQ(flat.instances_size(), 13);
  for (const auto accelerator : {v1::ACCELERATOR_EMBREE, v1::ACCELERATOR_BVH_SAH}) {
    const client::Image judge = picture(flat, v1::NESTING_AUTO, 1, accelerator);
    ASSERT_NE(judge.find("depth.Z"), nullptr);
    expect_same_picture(picture(scene, v1::NESTING_KEPT, 1, accelerator), judge, origins);
    expect_same_picture(picture(scene, v1::NESTING_FLATTENED, 1, accelerator), judge, origins);
  }
}

TEST(NestedScene, GlassInMirroredGroupsIsGlass) {
  // A ball is its own mirror image: at one level that mirrors, or at two of three, it refracts as it does in
  // the world.
  const std::string ball = "shapes { material: 'glass' sphere { radius: 1.2 } }";
  const std::string mirror = "world_from_instance { elements: [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }";
  const auto in_groups = [&](int mirrored) {
    const auto place = [&](int level) { return level < mirrored ? mirror : std::string(); };
    return scene_of(absl::StrCat(kWorld, "objects { name: 'a' ", ball,
                                 " } objects { name: 'b' instances { object: 'a' ", place(0),
                                 " } instances { object: 'a' world_from_instance { elements: [0.2,0,0,-9, "
                                 "0,0.2,0,9, 0,0,0.2,0, 0,0,0,1] ",
                                 "} } } instances { object: 'b' ", place(1), " }"));
  };
  const client::Image plain = picture(scene_of(absl::StrCat(kWorld, ball)), v1::NESTING_AUTO, 4);
  for (int mirrored = 0; mirrored <= 2; ++mirrored) {
    SCOPED_TRACE(mirrored);
    const client::Image image = picture(in_groups(mirrored), v1::NESTING_KEPT, 4);
    std::size_t other = 0;
    for (std::size_t i = 0; i < 64 * 64; ++i)
      other += std::abs(value(image, "G", i) - value(plain, "G", i)) > 1e-3 * (0.1 + value(plain, "G", i));
    // A wrong side would change all that is seen through the ball, a third of the picture.
    EXPECT_LE(other, 64 * 64 / 20);
  }
}

TEST(NestedScene, MovesAtEveryLevel) {
  // Turned at one level, moved along at the next: between matrices that are interpolated a level by itself,
  // and a product that is sampled often enough, points differ by less than 1e-4 of a radius of about 1.
  const std::string text = absl::StrCat(
      kWorld,
      "objects { name: 'ball' shapes { material: 'white' sphere { radius: 0.4 } } }"
      "objects { name: 'arm' instances { object: 'ball' world_from_instance { elements: [1,0,0,1, 0,1,0,0, "
      "0,0,1,0, 0,0,0,1] } } instances { object: 'ball' world_from_instance { elements: [1,0,0,-1, 0,-1,0,0, "
      "0,0,1,0, 0,0,0,1] } world_from_instance_end { elements: [1,0,0,-1.3, 0,-1,0,0.2, 0,0,1,0, 0,0,0,1] } "
      "} }"
      "instances { object: 'arm' world_from_instance_end { elements: [0.866,-0.5,0,0, 0.5,0.866,0,0, "
      "0,0,1,0, "
      "0,0,0,1] } }");
  const v1::Scene scene = scene_of(text);
  const client::Image kept = picture(scene, v1::NESTING_KEPT, 16),
                      flat = picture(scene, v1::NESTING_FLATTENED, 16);
  std::size_t other = 0;
  for (std::size_t i = 0; i < 64 * 64; ++i)
    other += std::abs(value(kept, "G", i) - value(flat, "G", i)) > 0.01 * (0.1 + value(flat, "G", i));
  EXPECT_LE(other, 64 * 64 / 20);
  EXPECT_NEAR(mean(kept, "G"), mean(flat, "G"), 2e-3 * mean(flat, "G"));
  // It does move: the picture of what stands still is another.
  v1::Scene still = scene;
  for (v1::Object& object : *still.mutable_objects()) {
    for (v1::Instance& inner : *object.mutable_instances()) inner.clear_world_from_instance_end();
  }
  const client::Image other_picture = picture(still, v1::NESTING_KEPT, 16);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < 64 * 64; ++i)
    moved += std::abs(value(kept, "G", i) - value(other_picture, "G", i)) > 0.01;
  EXPECT_GT(moved, 50u);
}

TEST(NestedScene, AWorldOfManyInstancesIsWhatItIsFlattened) {
  // 512 shapes that move have an instance each in every instance of their object: 2^18 and more.
  std::string text = absl::StrCat(kWorld, "objects { name: 'swarm' ");
  for (int i = 0; i < 512; ++i) {
    const std::string place =
        absl::StrCat("[1,0,0,", i % 8 - 3.5, ", 0,1,0,", i / 8 % 8 - 3.5, ", 0,0,1,", i / 64);
    absl::StrAppend(&text,
                    "shapes { material: 'white' sphere { radius: 0.3 } world_from_object { elements: ", place,
                    ", 0,0,0,1] } world_from_object_end { elements: ", place, ".01, 0,0,0,1] } } ");
  }
  text += "} ";
  for (int i = 0; i < 513; ++i)
    absl::StrAppend(&text, "instances { object: 'swarm' world_from_instance { elements: [0.04,0,0,",
                    (i % 23 - 11) * 0.3, ", 0,0.04,0,", (i / 23 - 11) * 0.3, ", 0,0,0.04,0, 0,0,0,1] } } ");
  // From ball to ball, whose distances are some 25 times their radii, rounding grows as much with each
  // bounce: lights are compared after the first.
  v1::Scene scene = scene_of(text);
  scene.mutable_settings()->set_max_depth(1);
  std::vector<float> origins;
  for (int i = 0; i <= 513; ++i) origins.push_back(static_cast<float>(i));
  expect_same_picture(picture(scene, v1::NESTING_AUTO, 1), picture(scene, v1::NESTING_FLATTENED, 1), origins);
}

/// Ten levels, ten instances each: 10^10 balls.
std::string ten_by_ten() {
  std::string text =
      absl::StrCat(kWorld, "objects { name: 'n0' shapes { material: 'white' sphere { radius: 1 } } }");
  const auto level = [&](int held) {
    for (int k = 0; k < 10; ++k) {
      const double a = 2 * M_PI * k / 10, s = k % 2 == 0 ? 0.3 : -0.3;
      absl::StrAppend(&text, "instances { object: 'n", held, "' world_from_instance { elements: [", s,
                      ",0,0,", 0.75 * std::cos(a), ",0,0.3,0,", 0.75 * std::sin(a),
                      ",0,0,0.6,0,0,0,0,1] } } ");
    }
  };
  for (int l = 1; l < 10; ++l) {
    absl::StrAppend(&text, "objects { name: 'n", l, "' ");
    level(l - 1);
    text += "} ";
  }
  level(9);
  return text;
}

TEST(NestedScene, HoldsTenToTheTenthBalls) {
  const v1::Scene scene = scene_of(ten_by_ten());
  const auto kept = load(scene, v1::NESTING_KEPT, 4);
  ASSERT_TRUE(kept.ok()) << kept.status();
  EXPECT_THAT(kept->scene->notes(), Contains(HasSubstr("10000000000 instances")));
  EXPECT_LT(kept->scene->memory_bytes(), 1u << 20);
  const client::Image image = render_image(*kept);
  std::size_t balls = 0;
  for (const float instance : image.find("id.instance")->values) balls += instance > 0;
  EXPECT_GT(balls, 20u);
  // The fewest levels that there is room for find as many. A ball has 6e-6 of the ring's radius, and rays are
  // in single precision: ten roundings of an origin that is 10^5 radii away are a good part of a ball, so one
  // hit in four is another. In pictures that have nothing in common nearly all would be.
  const client::Image fewer = picture(scene, v1::NESTING_AUTO, 4);
  std::size_t other = 0, found = 0;
  for (std::size_t i = 0; i < 64 * 64; ++i) {
    other += value(image, "id.instance", i) != value(fewer, "id.instance", i);
    found += value(fewer, "id.instance", i) > 0;
  }
  EXPECT_LE(other, balls);
  EXPECT_NEAR(static_cast<double>(balls), static_cast<double>(found),
              5 * std::sqrt(static_cast<double>(other)));
}

TEST(NestedScene, EveryAlgorithmSeesIt) {
  const v1::Scene scene = scene_of(absl::StrCat(kWorld, kGraph));
  for (const char* integrator : {"bdpt", "whitted", "ao", "photon", "vcm", "mlt", "light"}) {
    const auto file = load(scene, v1::NESTING_KEPT, 1, integrator);
    EXPECT_TRUE(file.ok()) << integrator << ": " << file.status();
  }
}

/// Three pairs of boxes, and a lamp.
TEST(NestedScene, AnAlgorithmThatListsInstancesFlattensThem) {
  const v1::Scene scene = scene_of(
      "film { width: 16 height: 16 } camera { perspective { fov_degrees: 40 } } "
      "materials { name: 'white' diffuse { reflectance { constant { constant: 0.7 } } } } "
      "shapes { material: 'white' box { low: [-1, 4, -1] high: [1, 5, 1] } area_light { radiance { constant: "
      "5 } } } "
      "objects { name: 'brick' shapes { material: 'white' box { low: [0, 0, 5] high: [1, 1, 6] } } } "
      "objects { name: 'pair' instances { object: 'brick' } instances { object: 'brick' "
      "world_from_instance { elements: [1,0,0,2, 0,1,0,0, 0,0,1,0, 0,0,0,1] } } } "
      "instances { object: 'pair' } instances { object: 'pair' } instances { object: 'pair' }");
  const auto file = load(scene, v1::NESTING_KEPT, 1, "radiosity");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->notes(), Contains(HasSubstr("as the integrator wants it: 6 instances")));
}

/// A lamp in an object that a row holds three times, and a row that stands twice: six lamps, beside boxes
/// that are kept as levels. Without a sky, nothing else shines.
TEST(NestedScene, EveryPlaceOfALampShines) {
  constexpr const char* kBulb =
      "material: 'white' sphere { radius: 0.2 } area_light { radiance { constant: 3 } }";
  const auto shifted = [](const char* what, double x, double y) {
    return absl::StrFormat(" %s { elements: [1,0,0,%g, 0,1,0,%g, 0,0,1,0, 0,0,0,1] } ", what, x, y);
  };
  const std::string world =
      "film { width: 32 height: 32 } camera { perspective { fov_degrees: 60 } } materials { name: 'white' "
      "diffuse { reflectance { constant { constant: 0.7 } } } } shapes { material: 'white' polygon { "
      "corners: "
      "[-9,-9,7, 9,-9,7, 9,9,7, -9,9,7] } } ";
  std::string objects = absl::StrCat(
      "objects { name: 'lamp' shapes { name: 'bulb' ", kBulb,
      " world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,6, 0,0,0,1] } } shapes { material: 'white' "
      "box { low: [0.3, 0, 5.9] high: [0.5, 0.2, 6.1] } } } objects { name: 'row' ");
  std::string flat;
  for (const double x : {-2.0, 0.0, 2.0})
    absl::StrAppend(&objects, "instances { object: 'lamp' ", shifted("world_from_instance", x, 0), " } ");
  absl::StrAppend(&objects, "} ");
  for (const double y : {-1.0, 1.5}) {
    absl::StrAppend(&objects, "instances { object: 'row' ", shifted("world_from_instance", 0, y), " } ");
    for (const double x : {-2.0, 0.0, 2.0}) {
      absl::StrAppendFormat(
          &flat,
          "shapes { %s world_from_object { elements: [1,0,0,%g, 0,1,0,%g, 0,0,1,6, "
          "0,0,0,1] } } shapes { material: 'white' box { low: [0.3, 0, 5.9] high: [0.5, 0.2, "
          "6.1] } %s } ",
          kBulb, x, y, shifted("world_from_object", x, y));
    }
  }
  const double expected = mean(picture(scene_of(world + flat), v1::NESTING_FLATTENED, 64), "R");
  EXPECT_GT(expected, 0);
  for (const v1::Nesting nesting : {v1::NESTING_KEPT, v1::NESTING_FLATTENED}) {
    // A pixel's standard deviation over samples is less than its mean, and 1024 times 64 of them are summed:
    // .4 %, of both pictures. A lamp that is left out is a sixth.
    EXPECT_NEAR(mean(picture(scene_of(world + objects), nesting, 64), "R"), expected, 0.03 * expected)
        << nesting;
  }
  const auto file = load(scene_of(world + objects), v1::NESTING_KEPT, 1);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->warnings(), IsEmpty());
}

TEST(NestedScene, RefusesWhatGrowsBeyondFloats) {
  const std::string grow = "world_from_instance { elements: [1e5,0,0,0, 0,1e5,0,0, 0,0,1e5,0, 0,0,0,1] }";
  const std::string text = absl::StrCat(
      kWorld,
      "objects { name: 'a' shapes { sphere { radius: 1e-15 } } } objects { name: 'b' instances { object: "
      "'a' ",
      grow, " } instances { object: 'a' ", grow, " } } objects { name: 'c' instances { object: 'b' ", grow,
      " } instances { object: 'b' ", grow, " } } instances { object: 'c' ", grow, " }");
  EXPECT_THAT(std::string(load(scene_of(text), v1::NESTING_KEPT, 1).status().message()),
              HasSubstr("an instance in object 'b': its transform scales by more, or by less"));
}

}  // namespace
}  // namespace tessera::test::nested_scene
