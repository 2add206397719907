// Light that moves, and surfaces that deform: pictures of all algorithms against the mean of still ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "statistical/motion/still_pictures.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test::moving_light {
namespace {

struct Integrator {
  const char* name;
  const char* settings = "";
  double relative = 3e-3;  // of the light: moments that stand for others, and photons that are merged
};

/// Algorithms that find light in different ways; pixels of `path` share light, and do not.
const std::vector<Integrator> kAll = {{"path", "path_sharing: PATH_SHARING_4"},
                                      {"path", "path_sharing: PATH_SHARING_OFF"},
                                      {"path", "direct_light: DIRECT_LIGHT_BSDF"},
                                      {"volpath"},
                                      {"light"},
                                      {"bdpt"},
                                      {"vcm", "photon { radius: 0.02 }", 0.01},
                                      {"photon", "photon { radius: 0.02 }", 0.02},
                                      {"mlt", "mlt { mutations: 32 }"}};

const std::vector<Integrator> kThree = {{"path"}, {"light"}, {"bdpt"}};

/// Those that see lights without a surface: all but paths that meet light by chance.
std::vector<Integrator> samplers() {
  std::vector<Integrator> result = kAll;
  std::erase_if(result, [](const Integrator& one) {
    return std::string(one.settings).find("BSDF") != std::string::npos;
  });
  return result;
}

PictureRequest request_of(const std::string& scene, const TestBlobs& blobs) {
  PictureRequest request;
  request.scene = absl::StrCat(things(kDiffuse), camera(kPerspective), scene);
  request.max_depth = 2;
  request.blobs = light_blobs();
  request.blobs.insert(blobs.begin(), blobs.end());
  return request;
}

/// `moving` by all integrators, against stills by paths.
void expect_mean_of_stills(const std::function<std::string(double)>& still, const std::string& moving,
                           const std::vector<Integrator>& integrators, const TestBlobs& blobs = {},
                           const std::function<TestBlobs(double)>& still_blobs = {}) {
  const Pictures stills = mean_of_stills([&](double time) {
    PictureRequest request = request_of(still(time), still_blobs ? still_blobs(time) : blobs);
    request.settings = "path_sharing: PATH_SHARING_OFF";
    return request;
  });
  for (const Integrator& integrator : integrators) {
    SCOPED_TRACE(absl::StrCat(integrator.name, " ", integrator.settings));
    PictureRequest request = request_of(moving, blobs);
    request.integrator = integrator.name;
    request.settings = integrator.settings;
    request.spp = samples_of_form(4096);
    expect_same(measure_pictures(request), stills, integrator.relative);
  }
}

/// A lamp of radiance 3 that moves from one place to another.
void expect_lamp(const std::string& shape, const Placing& start, const Placing& end,
                 const std::vector<Integrator>& integrators = kThree) {
  const auto scene = [&](const std::string& place) {
    return absl::StrCat("shapes { ", shape, " area_light { two_sided: true radiance { constant: 3 } } ",
                        place, " }");
  };
  expect_mean_of_stills([&](double time) { return scene(matrices("world_from_object", start, end, time)); },
                        scene(matrices("world_from_object", start, end)), integrators);
}

TEST(MovingLamp, Sphere) {
  expect_lamp("sphere { radius: 1 }", {0, {0.2, 0.2, 0.2}, {-1.2, -0.5, 1.6}},
              {0, {0.5, 0.5, 0.5}, {1, 0.6, 2.4}}, kAll);
}

TEST(MovingLamp, SphereThatIsStretched) {
  expect_lamp("sphere { radius: 1 }", {20, {0.2, 0.5, 0.3}, {-1, -0.5, 2}},
              {100, {0.6, 0.3, 0.2}, {1, 0.6, 2.2}});
}

TEST(MovingLamp, RectangleThatTurnsAndIsStretched) {
  // On edge, so that its light falls on all sides one after the other.
  expect_lamp("polygon { corners: [-1,0,-0.5, 1,0,-0.5, 1,0,0.5, -1,0,0.5] }", {0, {0.3, 1, 1}, {-1, 0, 1.8}},
              {110, {0.8, 1, 0.4}, {0.8, -0.2, 2}}, kAll);
}

TEST(MovingLamp, TriangleThatTurns) {
  expect_lamp("polygon { corners: [-1,0,-0.5, 1,0.3,-0.5, 0,0,0.8] }", {0, {0.5, 1, 1}, {-1, 0, 1.8}},
              {90, {0.5, 0.7, 1}, {0.8, -0.2, 2}});
}

TEST(MovingLamp, DiskAndCylinder) {
  expect_lamp("disk { radius: 0.5 inner_radius: 0.2 }", {0, {1, 1, 1}, {-1, 0, 1.8}},
              {60, {1.5, 0.5, 1}, {0.8, -0.2, 2.4}});
  expect_lamp("cylinder { radius: 0.2 z_min: -0.3 z_max: 0.4 }", {0, {1, 1, 1}, {-1, 0, 1.8}},
              {60, {1.5, 0.5, 1.4}, {0.8, -0.2, 2.4}});
}

TEST(MovingLamp, WithATexture) {
  const std::string texture =
      "textures { name: 'stripes' checkerboard { even { constant { constant: 1 } } odd { constant { "
      "constant: 0.1 } } mapping { scale_u: 3 scale_v: 2 } } } ";
  const Placing start{0, {0.5, 0.5, 1}, {-1, 0, 2}}, end{80, {0.9, 0.4, 1}, {0.7, -0.3, 2.3}};
  const auto scene = [&](const std::string& place) {
    return absl::StrCat(texture,
                        "shapes { mesh { blob { digest: 'square' } } area_light { radiance { constant: 5 } "
                        "texture: 'stripes' } ",
                        place, " }");
  };
  expect_mean_of_stills([&](double time) { return scene(matrices("world_from_object", start, end, time)); },
                        scene(matrices("world_from_object", start, end)), kThree);
}

std::string point3(const char* name, const double (&start)[3], const double (&end)[3], double time) {
  return absl::StrFormat(" %s { x: %.15g y: %.15g z: %.15g } ", name, (1 - time) * start[0] + time * end[0],
                         (1 - time) * start[1] + time * end[1], (1 - time) * start[2] + time * end[2]);
}

TEST(MovingPoint, PointsAndSoftPoints) {
  const double start[3] = {-1, -0.5, 1.5}, end[3] = {1, 0.5, 2.5};
  for (const char* const radius : {"", "radius: 0.3 "}) {
    const auto scene = [&](const std::string& place) {
      return absl::StrCat("lights { point { intensity { constant: 6 } ", radius, place, " } }");
    };
    expect_mean_of_stills([&](double time) { return scene(point3("position", start, end, time)); },
                          scene(point3("position", start, end, 0) + point3("position_end", start, end, 1)),
                          *radius == 0 ? samplers() : kThree);
  }
}

/// A spot that goes from (-1, 0, 2) to (1, 0, 2.4), while it turns about y from pointing along `from` degrees
/// off -z to `to` degrees.
TEST(MovingPoint, SpotsAndSoftSpots) {
  constexpr double kFrom = -40, kTo = 30;
  const double start[3] = {-1, 0, 2}, end[3] = {1, 0, 2.4};
  const auto target = [&](double time, const char* name) {
    const double angle = ((1 - time) * kFrom + time * kTo) * 3.14159265358979323846 / 180;
    return absl::StrFormat(" %s { x: %.15g y: 0 z: %.15g } ", name,
                           (1 - time) * start[0] + time * end[0] - std::sin(angle),
                           (1 - time) * start[2] + time * end[2] - std::cos(angle));
  };
  for (const char* const radius : {"", "radius: 0.2 "}) {
    const auto scene = [&](const std::string& place) {
      return absl::StrCat(
          "lights { spot { intensity { constant: 9 } cone_angle_degrees: 35 "
          "cone_delta_degrees: 15 ",
          radius, place, " } }");
    };
    expect_mean_of_stills(
        [&](double time) { return scene(point3("position", start, end, time) + target(time, "target")); },
        scene(point3("position", start, end, 0) + target(0, "target") +
              point3("position_end", start, end, 1) + target(1, "target_end")),
        *radius == 0 ? samplers() : kThree);
  }
}

TEST(MovingPoint, ProjectionsAndGoniometricLights) {
  // Light space is upside down, so that its z axis points at the floor.
  const auto place = [](const Placing& p) {
    const double angle = p.degrees * 3.14159265358979323846 / 180, c = std::cos(angle), s = std::sin(angle);
    return absl::StrFormat("elements: [%.15g,%.15g,0,%.15g, %.15g,%.15g,0,%.15g, 0,0,-1,%.15g, 0,0,0,1]", c,
                           s, p.at[0], s, -c, p.at[1], p.at[2]);
  };
  const Placing start{-20, {}, {-0.8, 0, 2.5}}, end{70, {}, {0.8, -0.3, 2.2}};
  for (const char* const kind :
       {"projection { fov_degrees: 60 aspect: 1.6 intensity { constant: 8 } texture: 'checks' ",
        "goniometric { intensity { constant: 8 } texture: 'checks' "}) {
    const auto scene = [&](const std::string& where) {
      return absl::StrCat("lights { ", kind, where, " } }");
    };
    expect_mean_of_stills(
        [&](double time) {
          return scene(absl::StrCat("world_from_light { ", place(between(start, end, time)), " }"));
        },
        scene(absl::StrCat("world_from_light { ", place(start), " } world_from_light_end { ", place(end),
                           " }")),
        kThree);
  }
}

TEST(MovingSky, SunsAndMaps) {
  const auto along = [](double time, const char* name) {
    const double angle = (20 + 50 * time) * 3.14159265358979323846 / 180;
    return absl::StrFormat(" %s { x: %.15g z: %.15g } ", name, std::sin(angle), -std::cos(angle));
  };
  const auto sun = [&](const std::string& directions) {
    return absl::StrCat("lights { distant { irradiance { constant: 2 } ", directions, " } }");
  };
  expect_mean_of_stills([&](double time) { return sun(along(time, "direction")); },
                        sun(along(0, "direction") + along(1, "direction_end")), samplers());

  const Placing start{0, {1, 1, 1}, {}}, end{120, {1, 1, 1}, {}};
  const auto sky = [&](const std::string& place) {
    return absl::StrCat(
        "lights { infinite { image { digest: 'map' path: 'map.pfm' } mapping: LATITUDE_LONGITUDE ", place,
        " } }");
  };
  expect_mean_of_stills([&](double time) { return sky(matrices("world_from_light", start, end, time)); },
                        sky(matrices("world_from_light", start, end)), kAll);
}

TEST(MovingLamp, ManyOfThemInATree) {
  // Small lamps on their ways about the things, some of which stand still.
  const auto scene = [](const std::function<std::string(const Placing&, const Placing&)>& place) {
    std::string result;
    for (int i = 0; i < 40; ++i) {
      const double angle = i * 2.4, far = 0.8 + 0.05 * i, next = angle + (i % 3) * 0.6;
      const Placing start{i * 30.0, {0.1, 0.1, 0.1}, {far * std::cos(angle), far * std::sin(angle), 1.6}};
      const Placing end{i * 30.0 + (i % 3) * 50,
                        {0.1, 0.1 + 0.05 * (i % 3), 0.1},
                        {far * std::cos(next), far * std::sin(next), 1.6 + 0.2 * (i % 3)}};
      absl::StrAppend(
          &result, "shapes { ",
          i % 2 ? "sphere { radius: 0.5 }" : "polygon { corners: [-1,0,-1, 1,0,-1, 1,0,1, -1,0,1] }",
          " area_light { two_sided: ", i % 4 == 0 ? "true" : "false", " radiance { constant: ", 2 + i % 5,
          " } } ", place(start, end), " }");
    }
    return result;
  };
  expect_mean_of_stills(
      [&](double time) {
        return scene([&](const Placing& start, const Placing& end) {
          return matrices("world_from_object", start, end, time);
        });
      },
      scene(
          [](const Placing& start, const Placing& end) { return matrices("world_from_object", start, end); }),
      {{"path", "light_selection: LIGHT_SELECTION_TREE"},
       {"path", "light_selection: LIGHT_SELECTION_POWER"},
       {"bdpt"},
       {"light"}});
}

/// Keys of a patch of 8 x 8 quads over [-1, 1]^2 that waves; the last is at time 1.
constexpr int kKeys = 4;
float height(int key, double x, double y) {
  return static_cast<float>(0.25 * std::sin(3 * x + 1.7 * key) * std::cos(2 * y - 0.9 * key));
}

std::string cloth(double time, bool with_normals) {
  const double place = time * (kKeys - 1);
  const int before = std::min(static_cast<int>(place), kKeys - 2);
  const double part = place - before;
  wire::MeshData mesh;
  constexpr int kSide = 8;
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= kSide; ++i) {
      const double x = -1 + 2.0 * i / kSide, y = -1 + 2.0 * j / kSide;
      // It goes sideways, too, so that no place on it keeps its own.
      const auto vertex = [&](int key) {
        return std::array{static_cast<float>(x + 0.1 * key), static_cast<float>(y - 0.05 * key * x),
                          height(key, x, y)};
      };
      const auto normal = [&](int key) {
        const double step = 1e-3, dx = (height(key, x + step, y) - height(key, x - step, y)) / (2 * step),
                     dy = (height(key, x, y + step) - height(key, x, y - step)) / (2 * step),
                     l = std::sqrt(1 + dx * dx + dy * dy);
        return std::array{static_cast<float>(-dx / l), static_cast<float>(-dy / l),
                          static_cast<float>(1 / l)};
      };
      const auto add = [&](const auto& at, std::vector<float>& to) {
        const auto a = at(before), b = at(before + 1);
        for (std::size_t k = 0; k < 3; ++k) to.push_back(static_cast<float>((1 - part) * a[k] + part * b[k]));
      };
      add(vertex, mesh.positions);
      if (with_normals) add(normal, mesh.normals);
      mesh.uvs.insert(mesh.uvs.end(), {static_cast<float>(i) / kSide, static_cast<float>(j) / kSide});
    }
  }
  for (std::uint32_t j = 0; j < kSide; ++j) {
    for (std::uint32_t i = 0; i < kSide; ++i) {
      const std::uint32_t a = j * (kSide + 1) + i, b = a + 1, c = a + kSide + 1, d = c + 1;
      mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
    }
  }
  return wire::encode_mesh(mesh);
}

TestBlobs cloth_keys(bool with_normals) {
  TestBlobs blobs;
  for (int key = 0; key < kKeys; ++key)
    blobs[absl::StrCat("key ", key)] = cloth(static_cast<double>(key) / (kKeys - 1), with_normals);
  return blobs;
}

std::string still_cloth() { return "mesh { blob { digest: 'cloth' } }"; }
std::string moving_cloth() {
  std::string later;
  for (int key = 1; key < kKeys; ++key) absl::StrAppend(&later, " later_blobs { digest: 'key ", key, "' }");
  return absl::StrCat("mesh { blob { digest: 'key 0' }", later, " }");
}

void expect_cloth(const std::string& lights, const std::string& more, bool with_normals,
                  const std::vector<Integrator>& integrators) {
  const auto scene = [&](const std::string& mesh) {
    return absl::StrCat(lights, " shapes { ", mesh, " ", more,
                        " world_from_object { elements: [0.7,0,0,0, 0,0.7,0,-0.3, 0,0,0.7,1.6, 0,0,0,1] } }");
  };
  expect_mean_of_stills([&](double) { return scene(still_cloth()); }, scene(moving_cloth()), integrators,
                        cloth_keys(with_normals),
                        [&](double time) {
                          return TestBlobs{{"cloth", cloth(time, with_normals)}};
                        });
}

constexpr const char* kBulb = "lights { point { position { x: 1 y: -1 z: 4 } intensity { constant: 20 } } } ";

TEST(Deforming, ClothWithNormalsAndATexture) {
  // Within 0.02 so few photons of the cloth's own light lie that some blocks have none in thousands of
  // passes, and batches say that nothing is missing. Within 0.08, a still cloth is right to 1.5 % in each
  // block that is not dark, noise included.
  std::vector<Integrator> integrators = samplers();
  for (Integrator& one : integrators)
    if (std::string(one.name) == "photon") one.settings = "photon { radius: 0.08 }";
  expect_cloth(
      absl::StrCat("materials { name: 'cloth' diffuse { reflectance { texture: 'checks' } } } ", kBulb),
      "material: 'cloth'", true, integrators);
}

TEST(Deforming, ClothWithHolesAndBumps) {
  expect_cloth(
      absl::StrCat("materials { name: 'cloth' diffuse { reflectance { constant { constant: 0.7 } } } "
                   "displacement { texture: 'lower bumps' } } textures { name: 'holes' checkerboard { even { "
                   "constant { constant: 1 } } odd { constant { constant: 0.2 } } mapping { scale_u: 4 "
                   "scale_v: 4 } } } ",
                   kBulb),
      "material: 'cloth' alpha { texture: 'holes' }", false, {{"path"}, {"volpath"}, {"bdpt"}});
}

TEST(Deforming, ClothThatShines) {
  expect_cloth("", "area_light { two_sided: true radiance { constant: 2 } }", false, kAll);
}

TEST(Deforming, ClothThatShinesAndMoves) {
  const Placing start{0, {0.7, 0.7, 0.7}, {-0.5, -0.3, 1.6}}, end{70, {0.7, 0.4, 0.9}, {0.4, 0.2, 2}};
  const auto scene = [&](const std::string& mesh, const std::string& place) {
    return absl::StrCat(" shapes { ", mesh,
                        " area_light { radiance { constant: 2 } } reverse_orientation: true ", place, " }");
  };
  expect_mean_of_stills(
      [&](double time) { return scene(still_cloth(), matrices("world_from_object", start, end, time)); },
      scene(moving_cloth(), matrices("world_from_object", start, end)), kThree, cloth_keys(false),
      [&](double time) {
        return TestBlobs{{"cloth", cloth(time, false)}};
      });
}

TEST(Deforming, EveryStructureSeesTheSameCloth) {
  const std::string scene =
      absl::StrCat(kBulb, " shapes { ", moving_cloth(),
                   " world_from_object { elements: [0.7,0,0,0, 0,0.7,0,-0.3, 0,0,0.7,1.6, 0,0,0,1] } }");
  const auto pictures = [&](const char* structure) {
    PictureRequest request = request_of(scene, cloth_keys(true));
    request.settings = absl::StrCat("accelerator: ACCELERATOR_", structure);
    request.spp = samples_of_form(1024);
    return measure_pictures(request);
  };
  const Pictures embree = pictures("EMBREE");
  for (const char* const structure :
       {"BRUTE", "BVH_MEDIAN", "BVH_SAH", "SPHERE_TREE", "GRID", "OCTREE", "BSP", "KD_MEDIAN", "KD_SAH"}) {
    SCOPED_TRACE(structure);
    expect_same(pictures(structure), embree);
  }
}

/// Strands in a row that bend over.
std::string strands(double time) {
  std::vector<float> points;
  for (int i = 0; i < 30; ++i) {
    for (int k = 0; k < 4; ++k) {
      const double place = time * 2;
      const int before = std::min(static_cast<int>(place), 1);
      const auto x = [&](int key) { return -1 + i / 15.0 + 0.15 * key * k * (1 + 0.2 * key); };
      const double part = place - before;
      points.push_back(static_cast<float>((1 - part) * x(before) + part * x(before + 1)));
      points.push_back(-0.8f);
      points.push_back(0.4f * static_cast<float>(k));
      points.push_back(0.05f - 0.01f * static_cast<float>(k));
    }
  }
  return {reinterpret_cast<const char*>(points.data()), points.size() * sizeof(float)};
}

TEST(Deforming, Strands) {
  std::vector<std::uint32_t> starts;
  for (std::uint32_t i = 0; i < 30; ++i) starts.push_back(4 * i);
  const std::string start_bytes(reinterpret_cast<const char*>(starts.data()), starts.size() * 4);
  TestBlobs keys = {{"starts", start_bytes}, {"0", strands(0)}, {"1", strands(0.5)}, {"2", strands(1)}};
  const auto scene = [&](const std::string& points) {
    return absl::StrCat(kBulb, " shapes { curves { kind: FLAT starts { digest: 'starts' } ", points,
                        " } material: 'm' }");
  };
  expect_mean_of_stills(
      [&](double) { return scene("points { digest: 'now' }"); },
      scene("points { digest: '0' } later_points { digest: '1' } later_points { digest: '2' }"),
      {{"path"}, {"volpath"}}, keys,
      [&](double time) {
        return TestBlobs{{"starts", start_bytes}, {"now", strands(time)}};
      });
}

}  // namespace
}  // namespace tessera::test::moving_light
