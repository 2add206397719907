// Combinations of solids against a judge that looks at points, and against closed forms.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "absl/strings/str_cat.h"
#include "render/shape/csg/csg_sweep.h"
#include "support/long_form.h"
#include "unit/render/shape/csg/csg_table.h"
#include "unit/render/shape/csg/random_tree.h"
#include "wire/mesh_blob.h"

namespace tessera::render::TESSERA_ISA::csg_test {
namespace {

using render::csg_test::RandomTree;

std::string at(double x, double y, double z) {
  return absl::StrCat(" world_from_object { elements: [1,0,0,", x, ", 0,1,0,", y, ", 0,0,1,", z,
                      ", 0,0,0,1] } ");
}
std::string solid(const std::string& text) { return absl::StrCat("parts { solid { ", text, " } } "); }
std::string csg(const std::string& operation, const std::string& parts) {
  return absl::StrCat("csg { operation: ", operation, " ", parts, " } ");
}
std::string box(double low, double high) {
  return absl::StrCat("box { low: [", low, ", -1, -1] high: [", high, ", 1, 1] } ");
}
/// Along x, off the axes.
const Ray kAlongX({-5, 0.1, 0.2}, {1, 0, 0});

/// Uniform directions through a ball of radius 2.
Ray ray_through(RandomTree& random) {
  const Point d = random.direction(), to{random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)};
  return {to - d * 6, d * random.number(0.5, 2)};
}

/// Whether the judge, at places along the ray, finds it inside where an odd number of borders lies before.
/// Places that are within `tolerance` of where the judge's answer changes are open.
struct Verdict {
  int judged = 0, open = 0, wrong = 0;
};
void judge(const RandomTree& tree, const CsgTable& table, const Ray& ray, double scale, Verdict& verdict) {
  const std::vector<float> borders = table.borders(ray);
  std::vector<double> places;
  for (int i = 0; i < 64; ++i) places.push_back((i + 0.37) / 64 * 26);
  for (std::size_t i = 0; i + 1 < borders.size(); ++i)
    places.push_back((double{borders[i]} + borders[i + 1]) / 2);
  // t is a float, and so is all that leads to it: 2^-24 of 26, a few times.
  constexpr double kTolerance = 1e-5;
  for (const double t : places) {
    const auto inside = [&](double s) { return tree.inside(ray.at(s) * (1 / scale)); };
    ++verdict.judged;
    if (inside(t - kTolerance) != inside(t + kTolerance) || inside(t) != inside(t + kTolerance)) {
      ++verdict.open;
      continue;
    }
    const auto before = std::ranges::count_if(borders, [&](float b) { return b < t; });
    verdict.wrong += (before % 2 != 0) != inside(t);
  }
}

TEST(Csg, IsWhereItsOperandsSay) {
  Verdict verdict;
  int borders = 0;
  const unsigned trees = test::long_form() ? 20000 : 400;
  for (unsigned seed = 1; seed <= trees; ++seed) {
    RandomTree tree(seed, 4);
    const CsgTable table(tree.shape());
    for (int i = 0; i < 16; ++i) {
      const Ray ray = ray_through(tree);
      borders += static_cast<int>(table.borders(ray).size());
      judge(tree, table, ray, 1, verdict);
    }
  }
  EXPECT_EQ(verdict.wrong, 0) << "of " << verdict.judged;
  // Each border makes places within 10^-5 of it open, of 26.
  EXPECT_LT(verdict.open, verdict.judged / 1000);
  EXPECT_GT(borders, static_cast<int>(trees) * 8);  // rays that meet something are judged
}

TEST(Csg, IsTheSameInAnyUnits) {
  for (const double scale : {1e-6, 1e-3, 1e4, 1e9}) {
    Verdict verdict;
    for (unsigned seed = 1; seed <= 40; ++seed) {
      RandomTree tree(seed, 3);
      Transform placed;
      for (const std::size_t i : {0, 5, 10}) placed.m[i] = scale;
      const CsgTable table(tree.shape(), placed);
      for (int i = 0; i < 16; ++i) {
        const Ray ray = ray_through(tree);
        judge(tree, table, {ray.o * scale, ray.d * scale}, scale, verdict);
      }
    }
    EXPECT_EQ(verdict.wrong, 0) << scale;
  }
}

/// Operands far from the origin of their combination, which is brought back.
TEST(Csg, DoesNotCareWhereItsOriginIs) {
  constexpr double kFar = 1e7;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    RandomTree tree(seed, 3);
    v1::Shape far = tree.shape();
    for (v1::Csg::Part& part : *far.mutable_csg()->mutable_parts()) {
      if (!part.has_solid()) continue;
      v1::Matrix& matrix = *part.mutable_solid()->mutable_world_from_object();
      if (matrix.elements().empty()) {
        for (int i = 0; i < 16; ++i) matrix.add_elements(i % 5 == 0);
      }
      matrix.set_elements(3, matrix.elements(3) + kFar);
    }
    const CsgTable table(far, Transform::translation({-kFar, 0, 0}));
    Verdict verdict;
    for (int i = 0; i < 16; ++i) judge(tree, table, ray_through(tree), 1, verdict);
    EXPECT_EQ(verdict.wrong, 0) << seed;
  }
}

/// The sides of its surface: a little before it the judge is outside, a little behind it inside.
TEST(Csg, HasItsNormalsOutward) {
  int hits = 0, wrong = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    RandomTree tree(seed, 4);
    const CsgTable table(tree.shape());
    for (int i = 0; i < 16; ++i) {
      const Ray ray = ray_through(tree);
      for (const float t : table.borders(ray)) {
        const Surface s = table.surface(ray, t);
        const auto lane = [](Vec3 v) { return Point{v.x.lane(3), v.y.lane(3), v.z.lane(3)}; };
        const Point p = lane(s.p), n = lane(s.ng);
        EXPECT_NEAR(length(p - ray.at(t)), 0, 2e-5);
        EXPECT_NEAR(length(n), 1, 1e-5);
        ++hits;
        wrong += tree.inside(p + n * 1e-4) || !tree.inside(p - n * 1e-4);
        // Origins of rays that go on: off by the error bound they are on their side.
        const Point out = lane(offset_origin(s, s.ng)), in = lane(offset_origin(s, -s.ng));
        if (tree.inside(p + n * 1e-4) || !tree.inside(p - n * 1e-4)) continue;
        EXPECT_FALSE(tree.inside(out));
        EXPECT_TRUE(tree.inside(in));
      }
    }
  }
  // Within 10^-4 of an edge either may be another's.
  EXPECT_GT(hits, 5000);
  EXPECT_LT(wrong, hits / 200);
}

TEST(Csg, ADifferenceOfEqualsIsNothing) {
  for (const char* const what :
       {"sphere { radius: 1 }", "torus { major_radius: 1 minor_radius: 0.3 }",
        "box { low: [-1,-1,-1] high: [1,1,1] }", "cone { radius: 1 height: 2 capped: true }"}) {
    const CsgTable none(csg("DIFFERENCE", solid(what) + solid(what)));
    RandomTree random(5, 1);
    for (int i = 0; i < 2000; ++i) EXPECT_TRUE(none.borders(ray_through(random)).empty()) << what;
  }
}

TEST(Csg, AUnionOrIntersectionOfEqualsIsEither) {
  for (const char* const what : {"sphere { radius: 1 }", "torus { major_radius: 1 minor_radius: 0.3 }",
                                 "polyhedron { vertices: [-1,-1,-1, 1,-1,-1, 0,1.2,-1, 0,0,1.3] }"}) {
    const CsgTable one(csg("UNION", solid(what)));
    for (const char* const operation : {"UNION", "INTERSECTION"}) {
      const CsgTable both(csg(operation, solid(what) + solid(what)));
      RandomTree random(6, 1);
      for (int i = 0; i < 2000; ++i) {
        const Ray ray = ray_through(random);
        EXPECT_EQ(both.borders(ray), one.borders(ray)) << what << operation;
      }
    }
  }
}

/// A - (B or C) is A and all beyond B's plane and all beyond C's.
TEST(Csg, ObeysDeMorgan) {
  const std::string ball = solid("sphere { radius: 1 }");
  const std::string up = "world_from_object { elements: [0.8,0,0.6,0, 0,1,0,0, -0.6,0,0.8,0.1, 0,0,0,1] }",
                    other_up = "world_from_object { elements: [1,0,0,0, 0,0,-1,-0.2, 0,1,0,0, 0,0,0,1] }",
                    down =
                        "world_from_object { elements: [0.8,0,-0.6,0, 0,-1,0,0, -0.6,0,-0.8,0.1, 0,0,0,1] }",
                    other_down = "world_from_object { elements: [1,0,0,0, 0,0,1,-0.2, 0,-1,0,0, 0,0,0,1] }";
  const CsgTable less(csg("DIFFERENCE", ball + "parts { begin { operation: UNION } } " +
                                            solid("half_space {}" + up) + solid("half_space {}" + other_up) +
                                            "parts { end: true }"));
  const CsgTable met(
      csg("INTERSECTION", ball + solid("half_space {}" + down) + solid("half_space {}" + other_down)));
  RandomTree random(7, 1);
  int borders = 0;
  for (int i = 0; i < 5000; ++i) {
    const Ray ray = ray_through(random);
    const std::vector<float> a = less.borders(ray), b = met.borders(ray);
    ASSERT_EQ(a.size(), b.size());
    // Their unit spaces are not the same.
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 4e-6);
    borders += static_cast<int>(b.size());
  }
  EXPECT_GT(borders, 500);
}

TEST(Csg, FacesThatTouchWithinAreNone) {
  EXPECT_EQ(CsgTable(csg("UNION", solid(box(0, 1)) + solid(box(1, 3)))).borders(kAlongX),
            (std::vector<float>{5, 8}));
  EXPECT_TRUE(
      CsgTable(csg("INTERSECTION", solid(box(0, 1)) + solid(box(1, 3)) + solid(box(0, 3)))).is_there() ==
      false);
  // A bar that ends in the faces of what it is cut from leaves no skin.
  const std::string bar = "box { low: [0, -0.5, -0.5] high: [1, 0.5, 0.5] }";
  EXPECT_TRUE(CsgTable(csg("DIFFERENCE", solid(box(0, 1)) + solid(bar))).borders(kAlongX).empty());
  // Nor where both are turned, in units in which nothing is round.
  const std::string turned =
      "world_from_object { elements: [0.36,0.48,-0.8,0.1, -0.8,0.6,0,0.2, 0.48,0.64,0.6,0.3, 0,0,0,1] }";
  const auto slab = [&](double low, double high) {
    return solid(absl::StrCat("box { low: [-0.7, -0.7, ", low, "] high: [0.7, 0.7, ", high, "] } ", turned));
  };
  const CsgTable stack(
      csg("UNION", slab(-0.7, -0.31) + slab(-0.31, 0.13) + slab(0.13, 0.17) + slab(0.17, 0.7)));
  const CsgTable whole(csg("UNION", slab(-0.7, 0.7)));
  RandomTree random(8, 1);
  int met = 0;
  for (int i = 0; i < 5000; ++i) {
    const Ray ray = ray_through(random);
    const std::vector<float> a = stack.borders(ray), b = whole.borders(ray);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 4e-6);
    met += a.size() == 2;
  }
  EXPECT_GT(met, 500);
}

TEST(Csg, AFaceOfTwoIsThatOfTheOneNamedFirst) {
  const auto first_material = [](const std::string& text, float t) {
    return CsgTable(text).material(kAlongX, t);
  };
  const std::string a = solid(box(0, 2) + "material: 'm1'"), b = solid(box(0, 3) + "material: 'm2'");
  EXPECT_EQ(first_material(csg("UNION", a + b), 5), 1);
  EXPECT_EQ(first_material(csg("UNION", b + a), 5), 2);
  EXPECT_EQ(first_material(csg("UNION", a + b), 8), 2);
  EXPECT_EQ(first_material(csg("INTERSECTION", b + a), 5), 2);
  EXPECT_EQ(first_material(csg("INTERSECTION", b + a), 7), 1);
  // A solid that does not change there has no say: the first is inside before and behind.
  const std::string all = solid(box(-1, 4) + "material: 'm3'");
  EXPECT_EQ(first_material(csg("INTERSECTION", all + b + a), 5), 2);
}

TEST(Csg, CutFacesHaveTheMaterialThatIsAskedFor) {
  const std::string operands = solid(box(0, 3) + "material: 'm1'") + solid(box(-1, 1) + "material: 'm2'");
  EXPECT_EQ(CsgTable(csg("DIFFERENCE", operands)).material(kAlongX, 6), 2);
  EXPECT_EQ(CsgTable(csg("DIFFERENCE cut_faces: CUT", operands)).material(kAlongX, 6), 1);
  // With several solids it is that of the one which is there.
  const std::string two = "parts { begin { operation: UNION } } " + solid(box(2, 4) + "material: 'm3'") +
                          solid(box(0, 3) + "material: 'm1'") + "parts { end: true } ";
  const std::string cutter = solid(box(-1, 1) + "material: 'm2'");
  EXPECT_EQ(CsgTable(csg("DIFFERENCE cut_faces: CUT", two + cutter)).material(kAlongX, 6), 1);
  EXPECT_EQ(CsgTable(csg("DIFFERENCE cut_faces: CUT", two + solid(box(-1, 2.5) + "material: 'm2'")))
                .material(kAlongX, 7.5f),
            3);
  // Operands without one have that of the combination.
  EXPECT_EQ(CsgTable(csg("DIFFERENCE", solid(box(0, 3)) + cutter) + "material: 'm7'").material(kAlongX, 8),
            7);
}

TEST(Csg, SolidsThatAreThinnerThanFloatsTellAreNone) {
  const std::string base = solid(box(0, 2));
  EXPECT_EQ(CsgTable(csg("UNION", base + solid(box(3, 3.0001)))).borders(kAlongX).size(), 4u);
  EXPECT_EQ(CsgTable(csg("DIFFERENCE", base + solid(box(1e-8, 3)))).borders(kAlongX).size(), 0u);
}

/// A comb of more crossings than the fixed arrays hold.
TEST(Csg, ManyCrossingsAreAllThere) {
  std::string slabs, gaps = solid(box(0, 100.5));
  std::vector<float> expected;
  for (int i = 0; i < 100; ++i) {
    slabs += solid(box(i, i + 0.5));
    gaps += solid(absl::StrCat("box { low: [", i + 0.5, ", -2, -2] high: [", i + 1, ", 2, 2] }"));
    expected.insert(expected.end(), {i + 5.0f, i + 5.5f});
  }
  EXPECT_EQ(CsgTable(csg("UNION", slabs)).borders(kAlongX), expected);
  // The other way, the last slab is left by the box alone.
  expected.insert(expected.end(), {105.0f, 105.5f});
  EXPECT_EQ(CsgTable(csg("DIFFERENCE", gaps)).borders(kAlongX), expected);
}

TEST(CsgSweep, GrowingListsGiveTheBordersOfFixedOnes) {
  // A union of ten, the last of which is an intersection that the ray is never within.
  v1::Shape shape;
  std::string parts;
  for (int i = 0; i < 9; ++i) parts += solid(box(-1, 1 + i));
  parts += "parts { begin { operation: INTERSECTION } } " + solid(box(-1, 1)) + solid(box(-1, 1)) +
           "parts { end: true }";
  const CsgTable table(csg("UNION", parts));
  const CsgRecord& record = table.table().csgs[0];
  RandomTree random(9, 1);
  for (int round = 0; round < 200; ++round) {
    CsgCrossings few, many;
    for (int i = 0; i < 9; ++i) {
      const double a = random.number(-1, 1), b = a + random.number(0, 0.3);
      few.add_span(a, b, i);
      many.add_span(a, b, i);
    }
    for (int i = 0; i < 40; ++i) {
      const double a = random.number(-1, 1);
      many.add_span(a, a + random.number(0, 0.1), 9);
    }
    ASSERT_LT(few.size(), CsgCrossings::kFixed);
    ASSERT_GT(many.size(), CsgCrossings::kFixed);
    const auto borders = [&](CsgCrossings& crossings) {
      crossings.sort();
      CsgSweep sweep(record);
      sweep.start(crossings, 0);
      std::vector<std::tuple<double, int, bool>> found;
      CsgBorder border;
      while (sweep.next(border)) found.emplace_back(border.at.s, border.at.solid, border.enters);
      return found;
    };
    EXPECT_EQ(borders(few), borders(many));
  }
}

TEST(Csg, ALaneDoesNotDependOnItsNeighbours) {
  RandomTree tree(11, 4);
  const CsgTable table(tree.shape());
  alignas(64) float o[3][kWidth], d[3][kWidth];
  std::vector<Ray> rays;
  for (int i = 0; i < kWidth; ++i) {
    rays.push_back(ray_through(tree));
    const Ray& ray = rays.back();
    o[0][i] = static_cast<float>(ray.o.x), o[1][i] = static_cast<float>(ray.o.y),
    o[2][i] = static_cast<float>(ray.o.z);
    d[0][i] = static_cast<float>(ray.d.x), d[1][i] = static_cast<float>(ray.d.y),
    d[2][i] = static_cast<float>(ray.d.z);
  }
  const auto load = [](const float(&v)[3][kWidth]) {
    return Vec3{Float::load(v[0]), Float::load(v[1]), Float::load(v[2])};
  };
  const ShapeRays all{load(o), load(d), Float(0.0f), Float(__builtin_inff()), Mask::all()};
  const Float t = analytic_shape(ShapeKind::kCsg)->nearest(table.table(), table.table().shapes[0], 0, all);
  for (int i = 0; i < kWidth; ++i)
    EXPECT_EQ(t.lane(i), table.nearest(rays[static_cast<std::size_t>(i)])) << i;
}

/// Mean length of the part of parallel rays within the solid, over a square of half-size `half`, times its
/// area: the volume, with four standard errors.
void expect_volume(const std::string& text, double half, double volume) {
  const CsgTable table(text);
  RandomTree random(12, 1);
  constexpr int kRays = 40000;
  double sum = 0, squares = 0;
  for (int i = 0; i < kRays; ++i) {
    const Ray ray({random.number(-half, half), random.number(-half, half), -5}, {0, 0, 1});
    double chord = 0;
    const std::vector<float> borders = table.borders(ray);
    ASSERT_EQ(borders.size() % 2, 0u);
    for (std::size_t k = 0; k < borders.size(); k += 2) chord += double{borders[k + 1]} - borders[k];
    sum += chord, squares += chord * chord;
  }
  const double mean = sum / kRays, error = std::sqrt((squares / kRays - mean * mean) / kRays);
  const double area = 4 * half * half;
  EXPECT_NEAR(mean * area, volume, 4 * error * area) << text;
}

TEST(Csg, HasTheVolumeOfItsClosedForm) {
  // A lens of two unit spheres whose centres are 1.2 apart, seen from two sides.
  const double d = 1.2, lens = M_PI / 12 * (4 + d) * (2 - d) * (2 - d);
  const std::string ball = "sphere { radius: 1 }";
  expect_volume(csg("INTERSECTION", solid(ball + at(0, 0, -0.6)) + solid(ball + at(0, 0, 0.6))), 1, lens);
  expect_volume(csg("INTERSECTION", solid(ball + at(-0.6, 0, 0)) + solid(ball + at(0.6, 0, 0))), 1, lens);
  // The part of one that the other leaves.
  expect_volume(csg("DIFFERENCE", solid(ball + at(-0.6, 0, 0)) + solid(ball + at(0.6, 0, 0))), 2,
                4 * M_PI / 3 - lens);
  expect_volume(csg("UNION", solid(ball + at(-0.6, 0, 0)) + solid(ball + at(0.6, 0, 0))), 2,
                8 * M_PI / 3 - lens);
  // Steinmetz' solids of two and of three cylinders.
  const std::string rod = "cylinder { radius: 1 z_min: -2 z_max: 2 capped: true }",
                    along_x = rod + " world_from_object { elements: [0,0,1,0, 1,0,0,0, 0,1,0,0, 0,0,0,1] }",
                    along_y = rod + " world_from_object { elements: [1,0,0,0, 0,0,-1,0, 0,1,0,0, 0,0,0,1] }";
  expect_volume(csg("INTERSECTION", solid(along_x) + solid(along_y)), 1, 16.0 / 3);
  expect_volume(csg("INTERSECTION", solid(along_x) + solid(along_y) + solid(rod)), 1,
                8 * (2 - std::sqrt(2.0)));
}

/// A cube of triangles.
std::string cube_mesh() {
  wire::MeshData mesh;
  for (int i = 0; i < 8; ++i) {
    for (int a = 0; a < 3; ++a) mesh.positions.push_back((i >> a & 1) ? 1.0f : -1.0f);
  }
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return wire::encode_mesh(mesh);
}

TEST(Csg, MeshesAreSolidsLikeOthers) {
  const Blobs blobs{{"cube", cube_mesh()}};
  const std::string mesh = "mesh { blob { digest: 'cube' } } ",
                    own = "box { low: [-1,-1,-1] high: [1,1,1] } ";
  const std::string
      turned =
          "world_from_object { elements: [0.36,0.48,-0.8,0.1, -0.8,0.6,0,0.2, 0.48,0.64,0.6,0.3, 0,0,0,1] } ",
      mirrored =
          "world_from_object { elements: [0.36,0.48,0.8,0.1, -0.8,0.6,0,0.2, 0.48,0.64,-0.6,0.3, 0,0,0,1] } ";
  const std::string ball = solid("sphere { radius: 1.2 }");
  for (const std::string& placed : {turned, mirrored}) {
    for (const char* const operation : {"UNION", "INTERSECTION", "DIFFERENCE"}) {
      for (const bool mesh_first : {false, true}) {
        const auto text = [&](const std::string& cube) {
          return csg(operation, mesh_first ? solid(cube + placed) + ball : ball + solid(cube + placed));
        };
        const CsgTable of_mesh(text(mesh), blobs), of_box(text(own));
        RandomTree random(13, 1);
        int met = 0;
        for (int i = 0; i < 1000; ++i) {
          const Ray ray = ray_through(random);
          const std::vector<float> a = of_mesh.borders(ray), b = of_box.borders(ray);
          ASSERT_EQ(a.size(), b.size());
          for (std::size_t k = 0; k < a.size(); ++k) {
            EXPECT_NEAR(a[k], b[k], 4e-6);
            const Surface s = of_mesh.surface(ray, a[k]), expected = of_box.surface(ray, b[k]);
            EXPECT_GT(dot(s.ng, expected.ng).lane(3), 0.9999f);
            EXPECT_GT(dot(s.ns, expected.ng).lane(3), 0.9999f);
          }
          met += !a.empty();
        }
        EXPECT_GT(met, 300);
      }
    }
  }
}

/// Rays through corners and along the diagonals of faces, exactly: what goes in comes out.
TEST(Csg, MeshesAreWatertight) {
  const Blobs blobs{{"cube", cube_mesh()}};
  const CsgTable cube(csg("UNION", solid("mesh { blob { digest: 'cube' } }")), blobs);
  RandomTree random(14, 1);
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    // Numbers of few digits, so that nothing is rounded: edges, diagonals and corners are hit, and planes are
    // run along.
    const auto digit = [&] { return std::floor(random.number(-4, 5)) / 2; };
    const Point from{digit() * 4, digit() * 4, digit() * 4}, to{digit(), digit(), digit()};
    if (length(to - from) == 0) continue;
    const Ray ray(from, to - from);
    const std::vector<float> borders = cube.borders(ray);
    const double size = std::max({std::abs(from.x), std::abs(from.y), std::abs(from.z)});
    if (size <= 1) continue;
    ASSERT_EQ(borders.size() % 2, 0u);
    const double inside = std::max({std::abs(to.x), std::abs(to.y), std::abs(to.z)});
    if (inside >= 1) continue;
    EXPECT_EQ(borders.size(), 2u) << from.x << " " << from.y << " " << from.z << ": " << to.x << " " << to.y
                                  << " " << to.z;
    ++met;
  }
  EXPECT_GT(met, 500);
}

/// Rays that leave a convex solid meet nothing of it.
TEST(Csg, DoesNotMeetItselfAgain) {
  const std::string text =
      csg("INTERSECTION", solid("box { low: [-1,-1,-1] high: [1,1,1] }") + solid("sphere { radius: 1.3 }") +
                              solid("cylinder { radius: 1.1 z_min: -0.9 z_max: 2 capped: true }") +
                              solid("half_space {} world_from_object { elements: [0.8,0,0.6,0.3, 0,1,0,0, "
                                    "-0.6,0,0.8,0.4, 0,0,0,1] }"));
  std::int64_t hits = 0;
  for (const double scale : {1e-6, 1.0, 1e9}) {
    for (const double shift : {0.0, 3.0, 1e3}) {
      Transform placed;
      placed.m = {
          0.36 * scale,        0.48 * scale, -0.8 * scale, shift * scale, -0.8 * scale,  0.6 * scale, 0,
          0.5 * shift * scale, 0.48 * scale, 0.64 * scale, 0.6 * scale,   -shift * scale};
      v1::Shape shape;
      ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &shape));
      const CsgTable table(shape, placed);
      RandomTree random(15, 1);
      const int rays = test::long_form() ? 1000000 : 4000;
      for (int i = 0; i < rays; ++i) {
        const Ray in = ray_through(random);
        const Point centre{shift * scale, 0.5 * shift * scale, -shift * scale};
        const Ray ray(centre + in.o * scale, in.d);
        const float t = table.nearest(ray);
        if (t < 0) continue;
        ++hits;
        const Surface s = table.surface(ray, t);
        const Point n{s.ng.x.lane(3), s.ng.y.lane(3), s.ng.z.lane(3)};
        Point out = random.direction();
        if (dot(out, n) < 0) out = out * -1.0;
        const Vec3 origin = offset_origin(s, s.ng);
        const Ray again({origin.x.lane(3), origin.y.lane(3), origin.z.lane(3)}, out);
        if (dot(again.d, n) <= 1e-6) continue;
        EXPECT_LT(table.nearest(again), 0) << scale << " " << shift;
      }
    }
  }
  EXPECT_GT(hits, 9000);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::csg_test
