// The size that a scene says it has, against what the heap has grown
// by, with much of one kind of content.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "support/picture/scene_file.h"
#include "wire/mesh_blob.h"
#include "wire/volume_blob.h"

namespace tessera::test::scene_memory {
namespace {

/// Bytes that the program has from malloc(), mapped ones included.
double heap() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Samples of a ball of radius 0.4: its signed distance.
std::string ball_volume(std::uint32_t side, std::uint32_t channels) {
  std::vector<float> samples;
  const auto at = [&](std::uint32_t i) {
    return (static_cast<float>(i) + 0.5f) / static_cast<float>(side) - 0.5f;
  };
  for (std::uint32_t z = 0; z < side; ++z) {
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x)
        samples.insert(samples.end(), channels, std::hypot(at(x), at(y), at(z)) - 0.4f);
    }
  }
  if (channels > 1) {
    for (float& sample : samples) sample = std::fabs(sample);
  }
  return wire::encode_volume({.nx = side, .ny = side, .nz = side, .channels = channels, .samples = samples});
}

/// A sheet of 2 side^2 triangles that waves.
std::string sheet(std::uint32_t side) {
  wire::MeshData mesh;
  const auto n = static_cast<float>(side);
  for (std::uint32_t y = 0; y <= side; ++y) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      const float u = static_cast<float>(x) / n, v = static_cast<float>(y) / n;
      mesh.positions.insert(mesh.positions.end(), {u, v, 0.1f * std::sin(20 * u) * std::cos(20 * v)});
    }
  }
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
      mesh.indices.insert(mesh.indices.end(), {a, a + 1, b, b, a + 1, b + 1});
    }
  }
  return wire::encode_mesh(mesh);
}

/// A closed sphere of about 4 side^2 triangles.
std::string globe(std::uint32_t side) {
  wire::MeshData mesh;
  const std::uint32_t around = 2 * side;
  const double pi = 3.14159265358979323846;
  mesh.positions = {0, 0, 1};
  for (std::uint32_t i = 1; i < side; ++i) {
    for (std::uint32_t k = 0; k < around; ++k) {
      const double theta = pi * i / side, phi = 2 * pi * k / around;
      for (const double c :
           {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)})
        mesh.positions.push_back(static_cast<float>(c));
    }
  }
  mesh.positions.insert(mesh.positions.end(), {0, 0, -1});
  const std::uint32_t last = (side - 1) * around + 1;
  const auto vertex = [&](std::uint32_t i, std::uint32_t k) { return 1 + (i - 1) * around + k % around; };
  for (std::uint32_t k = 0; k < around; ++k) {
    mesh.indices.insert(mesh.indices.end(), {0, vertex(1, k), vertex(1, k + 1)});
    mesh.indices.insert(mesh.indices.end(), {last, vertex(side - 1, k + 1), vertex(side - 1, k)});
    for (std::uint32_t i = 1; i + 1 < side; ++i) {
      const std::uint32_t a = vertex(i, k), b = vertex(i + 1, k), c = vertex(i, k + 1),
                          d = vertex(i + 1, k + 1);
      mesh.indices.insert(mesh.indices.end(), {a, b, c, c, b, d});
    }
  }
  return wire::encode_mesh(mesh);
}

/// A portable float map.
std::string picture(int width, int height) {
  std::vector<float> values;
  for (int i = 0; i < 3 * width * height; ++i)
    values.push_back(0.5f + 0.5f * std::sin(0.001f * static_cast<float>(i)));
  return absl::StrCat("PF\n", width, " ", height, "\n-1.0\n") + bytes_of(values);
}

struct Content {
  const char* name;
  std::function<std::string()> scene;
  std::function<TestBlobs()> blobs;
};

constexpr char kIdentity[] = "{ elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }";

std::string repeated(int count, const std::function<std::string(int)>& part) {
  std::string text;
  for (int i = 0; i < count; ++i) text += part(i);
  return text;
}

const Content kContents[] = {
    {"a volume",
     [] {
       return absl::StrCat("media { name: 'm' extinction { grid { blob { digest: 'v' } world_from_grid ",
                           kIdentity,
                           " } } albedo { constant { constant: 0.5 } } } shapes { sphere { radius: 1 } "
                           "interior_medium: 'm' }");
     },
     [] {
       return TestBlobs{{"v", ball_volume(128, 3)}};
     }},
    {"a signed distance grid", [] { return std::string("shapes { sdf_grid { blob { digest: 'v' } } }"); },
     [] {
       return TestBlobs{{"v", ball_volume(128, 1)}};
     }},
    {"triangles", [] { return std::string("shapes { mesh { blob { digest: 'm' } } }"); },
     [] {
       return TestBlobs{{"m", sheet(600)}};
     }},
    {"triangles that glow",
     [] {
       return std::string("shapes { mesh { blob { digest: 'm' } } area_light { radiance { constant: 1 } } }");
     },
     [] {
       return TestBlobs{{"m", sheet(200)}};
     }},
    {"values at vertices",
     [] {
       return std::string(
           "textures { name: 'c' mesh_attribute { attribute: 'c' } } materials { name: 'm' diffuse { "
           "reflectance { texture: 'c' } } } shapes { material: 'm' mesh { blob { digest: 'm' } attributes { "
           "name: 'c' channels: 3 blob { digest: 'c' } } } }");
     },
     [] {
       return TestBlobs{{"m", sheet(600)}, {"c", bytes_of(std::vector<float>(3 * 601 * 601, 0.5f))}};
     }},
    {"curves",
     [] {
       return std::string(
           "shapes { curves { points { digest: 'p' } starts { digest: 's' } params { digest: 'u' } } }");
     },
     [] {
       constexpr std::uint32_t kSegments = 100'000;
       std::vector<float> points, params;
       std::vector<std::uint32_t> starts;
       for (std::uint32_t i = 0; i < kSegments; ++i) {
         starts.push_back(4 * i);
         const float x = static_cast<float>(i % 316), y = static_cast<float>(i) / 316;
         for (int k = 0; k < 4; ++k) points.insert(points.end(), {x, y, static_cast<float>(k), 0.1f});
         params.insert(params.end(), {0, 1});
       }
       return TestBlobs{{"p", bytes_of(points)}, {"s", bytes_of(starts)}, {"u", bytes_of(params)}};
     }},
    {"instances",
     [] {
       return "objects { name: 'o' shapes { sphere { radius: 0.1 } } } " + repeated(30'000, [](int i) {
                return absl::StrCat("instances { object: 'o' world_from_instance { elements: [1,0,0,", i,
                                    ", 0,1,0,0, 0,0,1,0, 0,0,0,1] } } ");
              });
     },
     [] { return TestBlobs{}; }},
    {"a picture as a texture",
     [] {
       return std::string(
           "textures { name: 't' image { image { digest: 'i' path: 'i.pfm' } } } textures { name: 'u' image "
           "{ image { "
           "digest: 'i' path: 'i.pfm' } } } materials { name: 'm' diffuse { reflectance { texture: 't' } } } "
           "materials { name: 'n' diffuse { reflectance { texture: 'u' } } } shapes { material: 'm' sphere "
           "{ radius: 1 } } "
           "shapes { material: 'n' sphere { radius: 1 } }");
     },
     [] {
       return TestBlobs{{"i", picture(2048, 1024)}};
     }},
    {"a picture of the sky",
     [] {
       return std::string(
           "lights { infinite { image { digest: 'i' path: 'i.pfm' } mapping: LATITUDE_LONGITUDE } }");
     },
     [] {
       return TestBlobs{{"i", picture(2048, 1024)}};
     }},
    {"meshes that are combined",
     [] {
       return std::string(
           "shapes { csg { operation: DIFFERENCE parts { solid { mesh { blob { digest: 'g' } } } } parts { "
           "solid { "
           "mesh { blob { digest: 'g' } } world_from_object { elements: [1,0,0,0.5, 0,1,0,0, 0,0,1,0, "
           "0,0,0,1] } } "
           "} } }");
     },
     [] {
       return TestBlobs{{"g", globe(100)}};
     }},
    {"materials and functions",
     [] {
       return repeated(4'000, [](int i) {
         return absl::StrCat("materials { name: 'm", i, "' gltf {} } shapes { material: 'm", i,
                             "' implicit { expression: 'x^8 + y^8 + z^8 - 1' ball { radius: 2 } } "
                             "world_from_object { elements: [1,0,0,",
                             5 * i, ", 0,1,0,0, 0,0,1,0, 0,0,0,1] } } ");
       });
     },
     [] { return TestBlobs{}; }},
};

/// Within a tenth, for malloc() rounds, and 4 MiB for each of the arrays on huge pages (core/big_array.h),
/// at most four, half as much in the mean: 2 MiB of alignment and 2 MiB of size. Embree has a part of its
/// memory from elsewhere.
TEST(SceneMemory, IsWhatTheHeapGrowsBy) {
  {
    // Sanitizers have a heap of their own, of which mallinfo2() knows nothing.
    const double before = heap();
    const std::string some(1 << 20, 'x');
    if (heap() == before) GTEST_SKIP() << "the heap is not the C library's";
  }
  const std::string isa = render::supported_isas().front();
  const std::string view =
      "camera { perspective { fov_degrees: 40 } world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-9, "
      "0,0,0,1] } } film { width: 8 height: 8 } settings { integrator: 'volpath' spp: 1 path_sharing: "
      "PATH_SHARING_OFF } ";
  // The first scene of a program leaves memory behind that is none of a scene's.
  ASSERT_TRUE(load_scene_text(view + "shapes { sphere { radius: 1 } }", {}, isa).ok());
  for (const Content& content : kContents) {
    SCOPED_TRACE(content.name);
    const TestBlobs blobs = content.blobs();
    const std::string scene = view + content.scene();
    const double before = heap();
    const auto file = load_scene_text(scene, {}, isa, blobs);
    ASSERT_TRUE(file.ok()) << file.status();
    const double grown = heap() - before;
    const auto told = static_cast<double>(file->scene->memory_bytes());
    const double structure = file->scene->structure().figures.bytes;
    constexpr double kHugePages = 8 << 20;
    const double tolerance = 0.1 * grown + kHugePages;
    EXPECT_GT(grown, 2e6);
    EXPECT_GT(told, grown - tolerance) << grown;
    EXPECT_LT(told - structure, grown + tolerance) << grown;
  }
}

}  // namespace
}  // namespace tessera::test::scene_memory
