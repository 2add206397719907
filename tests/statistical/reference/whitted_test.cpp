// Whitted's algorithm, ray casting and direct light: against a textbook's recursion in double precision, and
// against path tracing where both see the same light.
#include <Imath/ImathVec.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "support/picture/render_image.h"
#include "wire/mesh_blob.h"

namespace tessera::test::whitted {  // apart from tests that are compiled with these
namespace {

using V = Imath::V3d;

constexpr int kSide = 64;
constexpr double kWall = 3, kFloor = -1, kAlbedo = 0.7, kMetallic = 0.9, kIndex = 1.5;
struct Ball {
  V centre;
  double radius;
};
const Ball kMirrorBall{{-0.5, 0.2, 0}, 0.4};
const Ball kGlassBall{{0.45, -0.3, 0}, 0.5};
struct Lamp {
  V place;
  double intensity;
};
const Lamp kLamps[] = {{{1.5, 2, -2}, 20}, {{-2, 1.5, -3}, 12}};

/// A wall and a floor in one paint, a ball of silver, a ball of glass, two lamps, seen along +z; rays through
/// the pixels' middles.
std::string scene(const std::string& integrator, int max_depth) {
  const auto ball = [](const Ball& b, const char* material) {
    return absl::StrCat(" shapes { sphere { radius: ", b.radius, " } material: '", material,
                        "' world_from_object { elements: [1,0,0,", b.centre.x, ",0,1,0,", b.centre.y,
                        ",0,0,1,", b.centre.z, ",0,0,0,1] } }");
  };
  std::string text = absl::StrCat(
      "camera { orthographic {} world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }"
      " film { width: ",
      kSide, " height: ", kSide, " filter { kind: BOX radius_x: 1e-6 radius_y: 1e-6 } }",
      " settings { integrator: '", integrator, "' max_depth: ", max_depth, " spp: 1 }",
      " materials { name: 'paint' diffuse { reflectance { constant { constant: ", kAlbedo, " } } } }",
      " materials { name: 'silver' conductor { reflectance { constant { constant: ", kMetallic, " } } } }",
      " materials { name: 'glass' dielectric { eta { constant: ", kIndex, " } } }",
      " shapes { disk { radius: 50 } material: 'paint' world_from_object { elements: [1,0,0,0, 0,1,0,0, "
      "0,0,1,",
      kWall, ", 0,0,0,1] } }",
      " shapes { disk { radius: 50 } material: 'paint' world_from_object { elements: [1,0,0,0, 0,0,1,",
      kFloor, ", 0,-1,0,0, 0,0,0,1] } }", ball(kMirrorBall, "silver"), ball(kGlassBall, "glass"));
  for (const Lamp& lamp : kLamps) {
    absl::StrAppend(&text, " lights { point { position { x: ", lamp.place.x, " y: ", lamp.place.y,
                    " z: ", lamp.place.z, " } intensity { constant: ", lamp.intensity, " } } }");
  }
  return text;
}

// ---- the textbook

enum class Kind { kNothing, kPaint, kSilver, kGlass };
struct Found {
  Kind kind = Kind::kNothing;
  double t = std::numeric_limits<double>::infinity();
  V p, n;  // n: outward
};

Found nearest(const V& o, const V& d) {
  constexpr double kLeast = 1e-9;
  Found found;
  const auto plane = [&](const V& n, double offset) {
    const double t = (offset - o.dot(n)) / d.dot(n);
    const V p = o + d * t;
    if (t > kLeast && t < found.t && (p - n * offset).length() < 50) found = {Kind::kPaint, t, p, n};
  };
  const auto ball = [&](const Ball& b, Kind kind) {
    const double half = d.dot(o - b.centre);
    const double root = half * half - ((o - b.centre).length2() - b.radius * b.radius);
    if (root < 0) return;
    for (const double t : {-half - std::sqrt(root), -half + std::sqrt(root)}) {
      if (t > kLeast && t < found.t) found = {kind, t, o + d * t, (o + d * t - b.centre) / b.radius};
    }
  };
  plane({0, 0, 1}, kWall);
  plane({0, 1, 0}, kFloor);
  ball(kMirrorBall, Kind::kSilver);
  ball(kGlassBall, Kind::kGlass);
  return found;
}

/// Reflectance of a metal of index 1 + ik that reflects kMetallic head-on.
double silver_reflectance(double cosine) {
  const double k2 = 4 * kMetallic / (1 - kMetallic), c2 = cosine * cosine, s2 = 1 - c2;
  const double t0 = 1 - k2 - s2, a2b2 = std::sqrt(t0 * t0 + 4 * k2), a = std::sqrt((a2b2 + t0) / 2);
  const double rs = (a2b2 + c2 - 2 * cosine * a) / (a2b2 + c2 + 2 * cosine * a);
  const double t3 = c2 * a2b2 + s2 * s2, t4 = 2 * cosine * a * s2;
  return (rs + rs * (t3 - t4) / (t3 + t4)) / 2;
}

double trace(const V& o, const V& d, int depth, int max_depth, double importance) {
  const Found hit = nearest(o, d);
  if (hit.kind == Kind::kNothing || depth == max_depth || importance < 1e-3) return 0;
  const V n = hit.n.dot(d) < 0 ? hit.n : -hit.n;
  const double cosine = -n.dot(d);
  const V mirrored = d + n * (2 * cosine);
  if (hit.kind == Kind::kSilver) {
    const double r = silver_reflectance(cosine);
    return r * trace(hit.p, mirrored, depth + 1, max_depth, importance * r);
  }
  if (hit.kind == Kind::kGlass) {
    const double eta = hit.n.dot(d) < 0 ? kIndex : 1 / kIndex;
    const double sin2 = (1 - cosine * cosine) / (eta * eta);
    if (sin2 >= 1) return trace(hit.p, mirrored, depth + 1, max_depth, importance);
    const double inner = std::sqrt(1 - sin2);
    const double parallel = (eta * cosine - inner) / (eta * cosine + inner);
    const double across = (cosine - eta * inner) / (cosine + eta * inner);
    const double r = (parallel * parallel + across * across) / 2;
    const V refracted = d / eta + n * (cosine / eta - inner);
    return r * trace(hit.p, mirrored, depth + 1, max_depth, importance * r) +
           (1 - r) / (eta * eta) * trace(hit.p, refracted, depth + 1, max_depth, importance * (1 - r));
  }
  double sum = 0;
  for (const Lamp& lamp : kLamps) {
    const V to = lamp.place - hit.p;
    const double distance = to.length(), cosine_l = n.dot(to) / distance;
    if (cosine_l <= 0 || nearest(hit.p, to / distance).t < distance) continue;
    sum += kAlbedo / std::numbers::pi * lamp.intensity * cosine_l / (distance * distance);
  }
  return sum;
}

void expect_textbook(const std::string& integrator, int max_depth, int textbook_depth) {
  SCOPED_TRACE(absl::StrCat(integrator, " to depth ", max_depth));
  const auto file = load_scene_text(scene(integrator, max_depth), {}, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  const client::Image image = render_image(*file);
  ASSERT_EQ(image.pixel_count(), std::size_t{kSide * kSide});
  const std::vector<float>& green = image.find("G")->values;
  // Floats see the balls' curvature through up to eight bounces: 1e-3 of the value holds for all pixels but
  // those at edges, where one of the two sees the other side; as many as 1 in 400 of them.
  int wrong = 0, lit = 0;
  double sum = 0, expected_sum = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const V o{(x + 0.5) / (kSide / 2) - 1, 1 - (y + 0.5) / (kSide / 2), -4};
      const double expected = trace(o, {0, 0, 1}, 0, textbook_depth, 1);
      const double value = double{green[static_cast<std::size_t>(y * kSide + x)]};
      wrong += std::abs(value - expected) > 1e-3 * expected + 1e-5;
      lit += expected > 0.01;
      sum += value;
      expected_sum += expected;
    }
  }
  EXPECT_LE(wrong, kSide * kSide / 400);
  EXPECT_GT(lit, kSide * kSide / 3);
  EXPECT_NEAR(sum, expected_sum, 2e-3 * expected_sum);
}

TEST(Whitted, EveryPixelIsTheTextbooks) {
  for (const int depth : {1, 2, 3, 8}) expect_textbook("whitted", depth, depth);
}

TEST(Whitted, RayCastingIsItsFirstLevel) { expect_textbook("raycast", 8, 1); }

// ---- lamps with extent

/// A square of side 1 in the plane y = 0, facing down: two triangles, which are one lamp.
std::string square() {
  wire::MeshData mesh;
  mesh.positions = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return wire::encode_mesh(mesh);
}

PictureRequest lit_room(const std::string& integrator, std::uint32_t max_depth) {
  PictureRequest request;
  request.scene = R"(
      camera { perspective { fov_degrees: 60 }
        world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-4, 0,0,0,1] } }
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.6 b: 0.3 } } } } }
      materials { name: 'varnish' coated_diffuse { reflectance { constant { constant: 0.4 } }
        eta { constant: 1.5 }
                                                   roughness { u { constant: 0.3 } v { constant: 0.3 } } } }
      materials { name: 'fog' mix { a: 'paint' b: 'varnish' amount { constant: 0.3 } } }
      shapes { disk { radius: 5 } material: 'paint'
        world_from_object { elements: [1,0,0,0, 0,1,0,0, 0,0,1,2, 0,0,0,1] } }
      shapes { sphere { radius: 0.7 } material: 'varnish' }
      shapes { sphere { radius: 0.4 } material: 'fog'
               world_from_object { elements: [1,0,0,1.2, 0,1,0,0.3, 0,0,1,0, 0,0,0,1] } }
      shapes { sphere { radius: 0.3 } material: 'paint' area_light { radiance { constant: 9 } }
               world_from_object { elements: [1,0,0,-1.5, 0,1,0,1.4, 0,0,1,-1, 0,0,0,1] } }
      shapes { mesh { blob { digest: 'square' } } material: 'paint' area_light { radiance { constant: 4 } }
               world_from_object { elements: [1,0,0,0.6, 0,1,0,1.6, 0,0,1,-1, 0,0,0,1] } }
      lights { infinite { radiance { rgb { r: 0.1 g: 0.2 b: 0.4 } } } })";
  request.blobs = {{"square", square()}};
  request.integrator = integrator;
  request.max_depth = max_depth;
  request.spp = 4096;
  return request;
}

TEST(Whitted, DirectLightIsPathsOfOneEvent) {
  expect_same(measure_picture(lit_room("direct", 7)), measure_picture(lit_room("path", 1)));
}

TEST(Whitted, RayCastingSeesAllDirectLight) {
  expect_same(measure_picture(lit_room("raycast", 7)), measure_picture(lit_room("path", 1)));
}

TEST(Whitted, ARoomOfMirrorsTakesLittleMemory) {
  // Nothing is lost on the way, so that only the depth ends it: at 32767 levels, 170 KB each would be 5.5 GB.
  const auto most_megabytes = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss / 1024;
  };
  const auto file = load_scene_text(
      "camera { perspective { fov_degrees: 90 } } film { width: 16 height: 16 }"
      " settings { integrator: 'whitted' max_depth: 32767 spp: 1 }"
      " materials { name: 'mirror' phong { diffuse { constant { constant: 0 } }"
      "                                    specular { constant { constant: 1 } } lobe: MIRROR } }"
      " shapes { sphere { radius: 2 } material: 'mirror' world_from_object { elements: [1,0,0,0.3, 0,1,0,0.2,"
      "                                                                                0,0,1,0, 0,0,0,1] } }",
      {}, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  const auto before = most_megabytes();
  EXPECT_EQ(render_image(*file).pixel_count(), 256u);
  // 17 MB a thread, of which a test has few; the batches themselves are below one.
  EXPECT_LT(most_megabytes() - before, 100 + 20 * static_cast<long>(std::thread::hardware_concurrency()));
}

TEST(Whitted, RayCastingFollowsNoMirror) {
  const auto whole = [](const std::string& integrator) {
    PictureRequest request;
    request.scene = absl::StrCat(
        "camera { perspective { fov_degrees: 30 } world_from_camera { elements: [1,0,0,0, 0,1,0,0,"
        " 0,0,1,-2, 0,0,0,1] } }",
        kSky,
        "materials { name: 'mirror' phong { diffuse { constant { constant: 0 } }"
        " specular { constant { constant: 0.5 } } lobe: MIRROR } }"
        " shapes { disk { radius: 5 } material: 'mirror' }");
    request.integrator = integrator;
    return measure_picture(request);
  };
  expect_value(whole("whitted"), 0.5);
  expect_value(whole("raycast"), 0);
}

TEST(Whitted, GlassThatMakesLightDoublesNoRays) {
  // Shells of glass within a mirror: every ray splits, both halves meet the next, and each hit doubles what
  // they bring. By what they bring alone, 2^24 rays would follow each sample.
  const auto file = load_scene_text(
      "camera { perspective { fov_degrees: 90 } } film { width: 16 height: 16 }"
      " settings { integrator: 'whitted' max_depth: 24 spp: 1 }"
      " materials { name: 'mirror' phong { diffuse { constant { constant: 0 } }"
      "                                    specular { constant { constant: 1 } } lobe: MIRROR } }"
      " materials { name: 'glass' dielectric { eta { constant: 1.5 } reflection_tint { constant { constant: "
      "2 } }"
      "                                        transmission_tint { constant { constant: 2 } } } }"
      " shapes { sphere { radius: 2 } material: 'mirror' }"
      " shapes { sphere { radius: 1 } material: 'glass' } shapes { sphere { radius: 0.5 } material: 'glass' "
      "}",
      {}, render::supported_isas().front());
  ASSERT_TRUE(file.ok()) << file.status();
  render::RenderStats stats;
  const auto tile = file->scene->render_tile({.x1 = 16, .y1 = 16, .sample_end = 1}, std::stop_token{}, stats);
  ASSERT_TRUE(tile.ok()) << tile.status();
  EXPECT_GT(stats.bounce_rays, 24u * 256) << "rays split";
  EXPECT_LT(stats.bounce_rays, 24u * 1000 * 256);
}

TEST(Whitted, AnExponentFromATextureIsThatOfAConstant) {
  const auto picture = [](const std::string& exponent) {
    const auto file = load_scene_text(
        absl::StrCat(
            "camera { perspective { fov_degrees: 30 } world_from_camera { elements: [1,0,0,0, 0,1,0,0,"
            " 0,0,1,-4, 0,0,0,1] } } film { width: 16 height: 16 }"
            " settings { integrator: 'raycast' spp: 1 }"
            " textures { name: 'even' checkerboard { even { constant { constant: 200 } } odd { constant { "
            "constant: 200 } } } }"
            " materials { name: 'gloss' phong { exponent { ",
            exponent,
            " } } }"
            " shapes { sphere { radius: 1 } material: 'gloss' }"
            " lights { point { intensity { constant: 9 } position { x: 1 y: 2 z: -4 } } }"),
        {}, render::supported_isas().front());
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() ? render_image(*file).find("G")->values : std::vector<float>{};
  };
  const std::vector<float> constant = picture("constant: 200");
  EXPECT_GT(*std::max_element(constant.begin(), constant.end()), 0.1f);
  EXPECT_EQ(picture("texture: 'even'"), constant);
}

TEST(Whitted, GlassInAWhiteRoomLosesOnlyWhatIsNotFollowed) {
  // Glass takes no light, and a radiance of 1 is all around, so the shares of all ways of a ray add up to 1;
  // left out are those below 1e-3. A ray within a ball meets it under one angle again and again and splits
  // once a hit, so two ways at most end there: those reflected outside and inside.
  PictureRequest request;
  request.scene = R"(
      camera { orthographic {} world_from_camera { elements: [0.5,0,0,0, 0,0.5,0,0, 0,0,1,-4, 0,0,0,1] } }
      materials { name: 'glass' dielectric { eta { constant: 1.5 } } }
      shapes { sphere { radius: 1 } material: 'glass' }
      lights { infinite { radiance { constant: 1 } } })";
  request.integrator = "whitted";
  request.max_depth = 100;
  request.spp = 256;
  const Picture picture = measure_picture(request);
  ASSERT_FALSE(picture.values.empty());
  for (const Picture::Value& value : picture.values) {
    EXPECT_LT(value.mean, 1 + 1e-5);
    EXPECT_GT(value.mean, 1 - 2e-3);
  }
}

}  // namespace
}  // namespace tessera::test::whitted
