// Geometry that is not one: what is refused is refused by name, and what is rendered is finite.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/load_scene.h"
#include "support/picture/render_image.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"

namespace tessera::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

/// A camera at the origin that looks along z at what stands around (0, 0, 5), in front of a wall and under a
/// sky.
constexpr const char* kAround = R"(
camera { perspective { fov_degrees: 50 } }
film { width: 32 height: 32 filter { kind: BOX } }
lights { infinite { radiance { constant: 0.5 } } }
lights { point { position { x: 2 y: 3 z: 1 } intensity { constant: 20 } } }
shapes { name: 'wall' mesh { blob { digest: 'wall' } }
  world_from_object { elements: [20,0,0,0, 0,20,0,0, 0,0,20,8, 0,0,0,1] } }
)";

std::string square() {
  wire::MeshData mesh;
  mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return wire::encode_mesh(mesh);
}

absl::StatusOr<LoadedFile> load(const std::string& scene, TestBlobs blobs = {},
                                v1::Intersection intersection = v1::INTERSECTION_AUTO) {
  test::SceneJob job;
  job.settings.set_spp(64);
  job.settings.set_max_depth(5);
  job.settings.set_intersection(intersection);
  job.aovs = {v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH};
  blobs["wall"] = square();
  return load_scene_text(absl::StrCat(scene, kAround), job, render::supported_isas().front(), blobs);
}

/// render_image() fails the test for samples that are not finite; here pixels are looked at too.
client::Image expect_finite(const absl::StatusOr<LoadedFile>& file) {
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  client::Image image = render_image(*file);
  EXPECT_FALSE(image.channels.empty());
  for (const client::Channel& channel : image.channels) {
    for (const float x : channel.values) {
      if (!std::isfinite(x)) {
        ADD_FAILURE() << channel.name << " is not finite";
        break;
      }
    }
  }
  return image;
}

double mean(const client::Image& image) {
  double sum = 0;
  for (const float x : image.find("G")->values) sum += x;
  return sum / static_cast<double>(image.find("G")->values.size());
}

const std::string kMesh =
    "shapes { name: 'bad' mesh { blob { digest: 'bad' } } world_from_object { elements: [1,0,0,0, 0,1,0,0, "
    "0,0,1,5, "
    "0,0,0,1] } ";

TEST(DegenerateTriangles, AreNotThere) {
  wire::MeshData mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0, 0.5f, 0, 0, 1e-30f, 0, 0, 0, 1e-30f, 0};
  mesh.normals.assign(mesh.positions.size(), 0);
  mesh.uvs.assign(12, 0.5f);
  // A point three times, an edge and a corner, a line, and a triangle whose area is below every float.
  mesh.indices = {0, 0, 0, 0, 1, 1, 0, 1, 2, 0, 4, 5};
  const double empty = mean(expect_finite(load("")));
  for (const char* light : {"}", "area_light { radiance { constant: 3 } } }"}) {
    for (const v1::Intersection tests : {v1::INTERSECTION_FAST, v1::INTERSECTION_ROBUST}) {
      EXPECT_NEAR(mean(expect_finite(load(kMesh + light, {{"bad", wire::encode_mesh(mesh)}}, tests))), empty,
                  1e-3 * empty + (light[0] == 'a' ? empty : 0));
    }
  }
}

TEST(SliverTriangles, GiveFinitePictures) {
  wire::MeshData mesh;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const float x = -1.5f + 0.01f * static_cast<float>(i),
                width = std::pow(10.0f, -1 - 0.03f * static_cast<float>(i));
    mesh.positions.insert(mesh.positions.end(), {x, -1, 0, x + width, -1, 0.2f, x, 1, -0.1f});
    mesh.indices.insert(mesh.indices.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  for (const char* material :
       {"}", "material: 'glass' }", "area_light { radiance { constant: 3 } two_sided: true } }"}) {
    for (const v1::Intersection tests : {v1::INTERSECTION_FAST, v1::INTERSECTION_ROBUST}) {
      expect_finite(load(
          absl::StrCat("materials { name: 'glass' dielectric { eta { constant: 1.5 } } } ", kMesh, material),
          {{"bad", wire::encode_mesh(mesh)}}, tests));
    }
  }
}

TEST(DuplicateTriangles, LookLikeOne) {
  wire::MeshData once, often;
  once.positions = often.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0};
  once.indices = {0, 1, 2};
  for (int i = 0; i < 500; ++i) often.indices.insert(often.indices.end(), {0, 1, 2});
  const double single = mean(expect_finite(load(kMesh + "}", {{"bad", wire::encode_mesh(once)}})));
  // The same hits, whichever of them is met: rays start off all of them at once.
  EXPECT_NEAR(mean(expect_finite(load(kMesh + "}", {{"bad", wire::encode_mesh(often)}}))), single,
              1e-4 * single);
}

TEST(CoplanarSheets, GiveOneOfThem) {
  // Red and green squares in one plane, overlapping by half: no third colour, no black.
  const std::string colours =
      "materials { name: 'r' diffuse { reflectance { constant { rgb { r: 0.8 } } } } } materials { name: 'g' "
      "diffuse { "
      "reflectance { constant { rgb { g: 0.8 } } } } } ";
  const std::string sheets =
      absl::StrCat(colours,
                   "shapes { material: 'r' mesh { blob { digest: 'wall' } } world_from_object { "
                   "elements: [1,0,0,-0.5, 0,1,0,0, 0,0,1,5, 0,0,0,1] } } "
                   "shapes { material: 'g' mesh { blob { digest: 'wall' } } world_from_object { "
                   "elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,5, 0,0,0,1] } } ");
  const client::Image image = expect_finite(load(sheets));
  ASSERT_FALSE(image.channels.empty());
  const auto pixel = [&](const char* channel, std::size_t x, std::size_t y) {
    return image.find(channel)->values[y * 32 + x];
  };
  for (std::size_t x = 10; x < 22; ++x)
    EXPECT_NEAR(pixel("albedo.R", x, 16) + pixel("albedo.G", x, 16), 0.8, 1e-3) << x;
}

TEST(NotFiniteVertices, AreRefusedByName) {
  for (const float x : {kNan, kInf, -kInf}) {
    wire::MeshData mesh;
    mesh.positions = {0, 0, 0, 1, x, 0, 0, 1, 0};
    mesh.indices = {0, 1, 2};
    EXPECT_THAT(load(kMesh + "}", {{"bad", wire::encode_mesh(mesh)}}).status().message(),
                AllOf(HasSubstr("(bad)"), HasSubstr("position of vertex 1 is not finite")));
  }
  // Finite as they are, but not where they are put.
  wire::MeshData mesh;
  mesh.positions = {0, 0, 0, 3e38f, 0, 0, 0, 1, 0};
  mesh.indices = {0, 1, 2};
  EXPECT_THAT(
      load("shapes { name: 'bad' mesh { blob { digest: 'bad' } } world_from_object { elements: [9,0,0,0, "
           "0,1,0,0, 0,0,1,5, 0,0,0,1] } }",
           {{"bad", wire::encode_mesh(mesh)}})
          .status()
          .message(),
      AllOf(HasSubstr("(bad)"), HasSubstr("vertex")));
}

TEST(HugeVertices, GiveFinitePictures) {
  for (const float size : {1e10f, 1e15f, 1e18f}) {
    wire::MeshData mesh;
    mesh.positions = {-size, -1, -size, size, -1, -size, 0, -1, size};
    mesh.indices = {0, 2, 1};
    const auto file = load(kMesh + "}", {{"bad", wire::encode_mesh(mesh)}});
    if (file.ok())
      expect_finite(file);
    else
      EXPECT_THAT(file.status().message(), HasSubstr("(bad)"));
  }
}

TEST(NotFiniteNormalsAndUvs, AreDoneWithout) {
  for (const float x : {kNan, kInf, 0.0f, 1e38f}) {
    wire::MeshData mesh;
    mesh.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0};
    mesh.normals = {0, 0, 1, x, 0, x, 0, 0, 1};
    mesh.uvs = {0, 0, x, 0, 1, 1};
    mesh.indices = {0, 1, 2};
    expect_finite(
        load(absl::StrCat("textures { name: 't' checkerboard { even { constant { constant: 0.7 } } } } "
                          "materials { name: 'm' diffuse { reflectance { texture: 't' } } } ",
                          kMesh, "material: 'm' }"),
             {{"bad", wire::encode_mesh(mesh)}}));
  }
}

/// The elements of a 3x4 matrix that puts things at z = 5.
std::string at(const std::string& elements) { return absl::StrCat("elements: [", elements, "]"); }
const char* const kSingular[] = {"0,0,0,0, 0,0,0,0, 0,0,0,5, 0,0,0,1", "1,0,0,0, 0,0,0,0, 0,0,1,5, 0,0,0,1",
                                 "1,1,0,0, 1,1,0,0, 0,0,1,5, 0,0,0,1"};
const char* const kTiny[] = {
    "1e-30,0,0,0, 0,1e-30,0,0, 0,0,1e-30,5, 0,0,0,1", "1,0,0,0, 0,1e-45,0,0, 0,0,1,5, 0,0,0,1",
    "1e-14,0,0,0, 0,1e-14,0,0, 0,0,1e-14,5, 0,0,0,1", "1e17,0,0,0, 0,1e17,0,0, 0,0,1e17,5, 0,0,0,1"};

TEST(SingularTransforms, OfMeshesFlattenThem) {
  for (const char* matrix : kSingular) {
    for (const char* light : {"", "area_light { radiance { constant: 3 } }"}) {
      expect_finite(
          load(absl::StrCat("shapes { name: 'flat' mesh { blob { digest: 'wall' } } world_from_object { ",
                            at(matrix), " } ", light, " }")));
    }
  }
}

TEST(SingularTransforms, OfQuadricsAreRefusedByName) {
  for (const char* kind : {"sphere { radius: 1 }", "disk { radius: 1 }", "cylinder { radius: 1 z_max: 1 }"}) {
    for (const char* matrix : kSingular) {
      EXPECT_THAT(
          load(absl::StrCat("shapes { name: 'flat' ", kind, " world_from_object { ", at(matrix), " } }"))
              .status()
              .message(),
          AllOf(HasSubstr("(flat)"), HasSubstr("singular")));
    }
  }
}

TEST(SingularTransforms, OfInstancesLeaveThemOut) {
  for (const char* matrix : kSingular) {
    const auto file = load(absl::StrCat(
        "objects { name: 'o' shapes { mesh { blob { digest: 'wall' } } } } instances { object: 'o' "
        "world_from_instance { ",
        at(matrix), " } }"));
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_THAT(file->scene->warnings(),
                testing::Contains(AllOf(HasSubstr("instance 0 (o)"), HasSubstr("singular"))));
    expect_finite(file);
  }
}

/// Not singular in doubles, but a float holds neither them nor their inverses, or not their determinants.
TEST(SingularTransforms, InFloatsAreRefusedOrRendered) {
  for (const char* matrix : kTiny) {
    for (const char* light : {"", "area_light { radiance { constant: 3 } }"}) {
      for (const char* kind : {"mesh { blob { digest: 'wall' } }", "sphere { radius: 1 }",
                               "disk { radius: 1 }", "cylinder { radius: 1 z_max: 1 }"}) {
        const auto file = load(absl::StrCat("shapes { name: 'odd' ", kind, " world_from_object { ",
                                            at(matrix), " } ", light, " }"));
        SCOPED_TRACE(absl::StrCat(kind, " ", matrix, " ", light));
        if (file.ok())
          expect_finite(file);
        else
          EXPECT_THAT(file.status().message(), HasSubstr("(odd)"));
      }
    }
    const auto file = load(absl::StrCat(
        "objects { name: 'o' shapes { mesh { blob { digest: 'wall' } } } shapes { sphere { radius: 1 "
        "} } } instances { object: 'o' world_from_instance { ",
        at(matrix), " } }"));
    SCOPED_TRACE(matrix);
    if (file.ok())
      expect_finite(file);
    else
      EXPECT_THAT(file.status().message(), HasSubstr("instance 0 (o)"));
  }
}

/// A float holds the transform, but not where a ray from across the scene is in the instance's space.
TEST(SingularTransforms, OfInstancesInScenesThatAreTooLarge) {
  const std::string scene =
      "objects { name: 'o' shapes { mesh { blob { digest: 'wall' } } } } "
      "instances { object: 'o' world_from_instance { elements: [1e-11,0,0,0, 0,1e-11,0,0, 0,0,1e-11,5, "
      "0,0,0,1] } } ";
  expect_finite(load(scene));
  EXPECT_THAT(load(absl::StrCat(scene, "shapes { sphere { radius: 1e8 } }")).status().message(),
              HasSubstr("instance 0 (o)"));
}

TEST(MirroredTransforms, LookLikeTheirMirrorImages) {
  // A square about the axis is its own mirror image.
  const auto with = [](const char* x) {
    return mean(
        expect_finite(load(absl::StrCat("shapes { mesh { blob { digest: 'wall' } } world_from_object { ",
                                        at(absl::StrCat(x, ",0,0,0, 0,1,0,0, 0,0,1,5, 0,0,0,1")), " } } "))));
  };
  EXPECT_NEAR(with("-1"), with("1"), 2e-3 * with("1"));
}

TEST(NotFiniteMatrices, AreRefused) {
  for (const char* x : {"nan", "inf", "-inf"}) {
    const std::string matrix = at(absl::StrCat("1,0,0,0, 0,", x, ",0,0, 0,0,1,5, 0,0,0,1"));
    for (const std::string& scene :
         {absl::StrCat("shapes { name: 'bad' sphere { radius: 1 } world_from_object { ", matrix, " } }"),
          absl::StrCat("objects { name: 'bad' shapes { sphere { radius: 1 } } } instances { object: 'bad' "
                       "world_from_instance { ",
                       matrix, " } }")}) {
      EXPECT_THAT(load(scene).status().message(), HasSubstr("elements")) << scene;
    }
  }
}

TEST(Intersection, TheProbeSaysWhatItChose) {
  // A square cut into strips of 2e-6 of its distance each.
  wire::MeshData strips;
  constexpr std::uint32_t kStrips = 200000;
  for (std::uint32_t i = 0; i <= kStrips; ++i) {
    const float x = -1 + 2 * static_cast<float>(i) / kStrips;
    strips.positions.insert(strips.positions.end(), {x, -1, 0, x, 1, 0});
    if (i < kStrips)
      strips.indices.insert(strips.indices.end(),
                            {2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  const TestBlobs blobs{{"bad", wire::encode_mesh(strips)}};
  const auto file = load(kMesh + "}", blobs);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_THAT(file->scene->warnings(), testing::ElementsAre(AllOf(HasSubstr("(bad)"), HasSubstr("robust"))));
  for (const v1::Intersection chosen : {v1::INTERSECTION_FAST, v1::INTERSECTION_ROBUST}) {
    const auto quiet = load(kMesh + "}", blobs, chosen);
    ASSERT_TRUE(quiet.ok()) << quiet.status();
    EXPECT_THAT(quiet->scene->warnings(), testing::IsEmpty());
  }
}

}  // namespace
}  // namespace tessera::test
