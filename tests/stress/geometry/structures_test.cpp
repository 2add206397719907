// All structures find the hits that testing everything finds, to the last bit.
#include <bit>
#include <cstring>
#include <numeric>

#include "render/accel/structure/clip.h"
#include "render/accel/structure/structure_query.h"
#include "stress/geometry/structure_tables.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Named {
  const char* name;
  StructureKind kind;
  bool wide = false;
};
constexpr Named kBrute{"brute", StructureKind::kBrute};
constexpr Named kJudged[] = {{"bvh-median of 16", StructureKind::kBvhMedian, true},
                             {"bvh-sah of 16", StructureKind::kBvhSah, true},
                             {"kd-median of 16", StructureKind::kKdMedian, true},
                             {"kd-sah of 16", StructureKind::kKdSah, true},
                             {"bvh-median", StructureKind::kBvhMedian},
                             {"bvh-sah", StructureKind::kBvhSah},
                             {"sphere-tree", StructureKind::kSphereTree},
                             {"grid", StructureKind::kGrid},
                             {"octree", StructureKind::kOctree},
                             {"bsp", StructureKind::kBsp},
                             {"kd-median", StructureKind::kKdMedian},
                             {"kd-sah", StructureKind::kKdSah}};

class Structured {
 public:
  Structured(const Named& named, const ShapeTable& table, bool shadow_cache = false) {
    auto built = build_structure(named.kind, table, textures_, structure_kernel().analytic,
                                 {.threads = 2, .wide = named.wide, .shadow_cache = shadow_cache});
    EXPECT_TRUE(built.ok()) << built.status();
    structure_ = *std::move(built);
    query_ = structure_kernel().make_query(*structure_);
  }
  const SceneStructure& structure() const { return *structure_; }
  const RayQuery& query() const { return *query_; }

 private:
  TextureTable textures_;
  std::unique_ptr<SceneStructure> structure_;
  std::unique_ptr<RayQuery> query_;
};

struct TimedRays : RayBatch {
  alignas(64) float time[kSize];
  RayArrays timed() const { return {ox, oy, oz, dx, dy, dz, time}; }
  HitArrays hits() { return {t, u, v, primitive, shape, instance, nullptr, upper}; }
};

/// Rays of every sort: across the scene, along its axes, aimed at corners, from far away, along planes, and
/// some that are no rays.
void fill(TimedRays& rays, const ShapeTable& table, double scale, Point centre, Numbers& random) {
  for (int i = 0; i < TimedRays::kSize; ++i) {
    rays.time[i] = static_cast<float>(random());
    rays.distance[i] = static_cast<float>(scale * 2 * random());
    const Point o = centre + in_cube(random, 3) * scale;
    if (i % 8 < 3 || table.vertices.empty()) {
      rays.set(i, o, random.direction());
      continue;
    }
    const Vertex& a = table.vertices[random.below(table.vertices.size())];
    const Vertex& b = table.vertices[random.below(table.vertices.size())];
    const Point p{a.position[0], a.position[1], a.position[2]},
        q{b.position[0], b.position[1], b.position[2]};
    if (i % 8 == 3) rays.aim(i, o, p);
    if (i % 8 == 4) rays.aim(i, p, q);
    if (i % 8 == 5) rays.aim(i, o * (i % 16 == 5 ? 1e6 : 1e3), p);
    if (i % 8 == 6) {
      const double sign = random() < 0.5 ? -1 : 1;
      const std::size_t axis = random.below(3);
      rays.set(i, p - Point{axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0} * scale,
               {axis == 0 ? sign : 0.0, axis == 1 ? sign : 0.0, axis == 2 ? sign : 0.0});
    }
    if (i % 8 == 7) rays.set(i, {p.x, o.y, o.z}, {0, random() - 0.5, random() - 0.5});
    if (i == 77) rays.ox[i] = HUGE_VALF;
    if (i == 78) rays.dy[i] = NAN;
    if (i == 79) rays.dx[i] = rays.dy[i] = rays.dz[i] = 0;
  }
}

bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

void expect_same_hits(const ShapeTable& table, double scale, Point centre, std::int64_t rays) {
  const Structured judge(kBrute, table);
  TimedRays expected, found;
  std::int64_t hits = 0, all = 0;
  std::vector<Structured> structures;
  structures.reserve(std::size(kJudged));
  for (const Named& one : kJudged) structures.emplace_back(one, table);
  Numbers random(17);
  for (; all < rays; all += TimedRays::kSize) {
    fill(expected, table, scale, centre, random);
    found = expected;
    judge.query().nearest(expected.timed(), TimedRays::kSize, false, expected.hits());
    judge.query().occluded(expected.timed(), TimedRays::kSize, expected.distance);
    for (int i = 0; i < TimedRays::kSize; ++i) hits += expected.shape[i] >= 0;
    const TimedRays asked = found;
    for (std::size_t s = 0; s < structures.size(); ++s) {
      found = asked;
      structures[s].query().nearest(found.timed(), TimedRays::kSize, false, found.hits());
      structures[s].query().occluded(found.timed(), TimedRays::kSize, found.distance);
      int wrong = 0;
      for (int i = 0; i < TimedRays::kSize; ++i) {
        const bool hit = expected.shape[i] >= 0;
        const bool same =
            found.shape[i] == expected.shape[i] && found.primitive[i] == expected.primitive[i] &&
            found.instance[i] == expected.instance[i] && found.upper[i] == expected.upper[i] &&
            same_bits(found.t[i], expected.t[i]) &&
            (!hit || (same_bits(found.u[i], expected.u[i]) && same_bits(found.v[i], expected.v[i])));
        const bool blocked = (found.distance[i] < 0) == (expected.distance[i] < 0);
        if (same && blocked) continue;
        if (wrong++ > 2) continue;
        ADD_FAILURE() << kJudged[s].name << ", ray " << i << " from " << found.ox[i] << " " << found.oy[i]
                      << " " << found.oz[i] << " along " << found.dx[i] << " " << found.dy[i] << " "
                      << found.dz[i] << ": t " << found.t[i] << " of " << found.primitive[i] << " in shape "
                      << found.shape[i] << "/" << found.instance[i] << ", expected " << expected.t[i]
                      << " of " << expected.primitive[i] << " in " << expected.shape[i] << "/"
                      << expected.instance[i] << ", blocked " << (found.distance[i] < 0) << " "
                      << (expected.distance[i] < 0);
      }
      ASSERT_EQ(wrong, 0) << kJudged[s].name << ", of " << all;
    }
  }
  EXPECT_GT(hits, all / 20);  // the rays do meet things
}

TEST(Structures, FindTheSameInSlivers) { expect_same_hits(slivers(1500), 1, {}, stress_count(4e3, 1e5)); }

TEST(Structures, FindTheSameInAHundredThousandSlivers) {
  if (!test::long_form()) GTEST_SKIP() << "the long form has it";
  expect_same_hits(slivers(100000), 1, {}, 1024);
}

/// Builds end in seconds each; the judge needs most of the time.
TEST(Structures, FindTheSameInAMillionSlivers) {
  if (!test::long_form()) GTEST_SKIP() << "the long form has it";
  expect_same_hits(slivers(1000000), 1, {}, 1);
}

/// Slivers reach through many cells, and no plane parts them well: what they are cut into is bounded all the
/// same, and with it the time of builds.
TEST(Structures, CutSliversIntoABoundedNumberOfParts) {
  const std::int64_t n = stress_count(8e3, 2e5);
  const ShapeTable table = slivers(n);
  for (const Named& one : kJudged) {
    SCOPED_TRACE(one.name);
    const StructureFigures figures = Structured(one, table).structure().figures();
    const double most = one.kind == StructureKind::kGrid
                            ? std::max(kLeastGridItems, kGridItems * static_cast<double>(n))
                            : reference_budget(static_cast<std::size_t>(n));
    EXPECT_LE(static_cast<double>(figures.references), most);
    EXPECT_LE(figures.depth, 64);
  }
}

TEST(Structures, FindTheSameInSheetsTwinsAndWhatIsNotThere) {
  expect_same_hits(sheets(), 1, {}, stress_count(6e3, 2e5));
}

TEST(Structures, FindTheSameInAStadium) { expect_same_hits(stadium(), 1, {}, stress_count(4e3, 1e5)); }

TEST(Structures, FindTheSameAmongQuadricsAndInstancesThatMove) {
  expect_same_hits(many_kinds(), 1, {}, stress_count(1.5e3, 3e4));
}

TEST(Structures, FindTheSameInObjectsWithinObjects) {
  expect_same_hits(nested_kinds(), 1, {}, stress_count(1.5e3, 3e4));
}

TEST(Structures, FindTheSameWhateverTheUnitAndThePlace) {
  for (const double scale : {1e-6, 1e3, 1e9}) {
    SCOPED_TRACE(scale);
    expect_same_hits(scaled(slivers(500), scale, {}), scale, {}, stress_count(2e3, 5e4));
  }
  const Point far{1e7, -2e6, 3e5};
  expect_same_hits(scaled(slivers(500), 1e3, far), 1e3, far, stress_count(2e3, 5e4));
}

TEST(Structures, FindNothingWhereThereIsNothing) {
  const ShapeTable empty;
  TimedRays rays;
  Numbers random(3);
  fill(rays, empty, 1, {}, random);
  for (const Named& one : kJudged) {
    SCOPED_TRACE(one.name);
    const Structured structured(one, empty);
    EXPECT_EQ(structured.structure().bounding_radius(), 0);
    structured.query().nearest(rays.timed(), TimedRays::kSize, false, rays.hits());
    for (int i = 0; i < TimedRays::kSize; ++i) EXPECT_LT(rays.shape[i], 0);
  }
}

/// Each ray meets a closed mesh from its inside, aimed at edges and corners.
TEST(Structures, LeaveNoHoles) {
  TableMaker maker;
  const ClosedMesh mesh = displaced_sphere(4);
  maker.add_mesh(mesh, {10, -6, 7}, 1);
  maker.end_mesh();
  const ShapeTable table = maker.take();
  TimedRays rays;
  for (const Named& one : kJudged) {
    SCOPED_TRACE(one.name);
    const Structured structured(one, table);
    Numbers random(19);
    std::int64_t missed = 0;
    for (std::int64_t all = 0; all < stress_count(2e4, 1e6); all += TimedRays::kSize) {
      for (int i = 0; i < TimedRays::kSize; ++i) {
        rays.time[i] = 0;
        const std::uint32_t* const corner = &table.triangles[3 * random.below(table.triangles.size() / 3)];
        const auto at = [&](int k) {
          const float* p = table.vertices[corner[k]].position;
          return Point{p[0], p[1], p[2]};
        };
        const Point o = Point{10, -6, 7} + random.direction() * (0.3 * random());
        rays.aim(i, o, i % 2 == 0 ? at(0) : at(0) + (at(1) - at(0)) * random());
      }
      structured.query().nearest(rays.timed(), TimedRays::kSize, false, rays.hits());
      for (int i = 0; i < TimedRays::kSize; ++i) missed += rays.shape[i] < 0;
    }
    EXPECT_EQ(missed, 0);
  }
}

/// The figures of bench on a structure: each ray's nodes add up to the query's own count, and nearly all
/// primitives are left out.
TEST(Structures, CountWhatTheyVisit) {
  const ShapeTable table = stadium();
  const std::uint64_t triangles = table.triangles.size() / 3;
  TimedRays rays;
  alignas(64) std::int32_t nodes[TimedRays::kSize], primitives[TimedRays::kSize];
  for (const Named& one : kJudged) {
    SCOPED_TRACE(one.name);
    const Structured structured(one, table);
    Numbers random(29);
    for (int i = 0; i < TimedRays::kSize; ++i) {
      rays.time[i] = 0;
      rays.set(i, in_cube(random, 3), random.direction());
    }
    HitArrays hits = rays.hits();
    hits.visited_nodes = nodes, hits.visited_primitives = primitives;
    structured.query().nearest(rays.timed(), TimedRays::kSize, false, hits);
    const RayVisits all = structured.query().visits();
    std::uint64_t opened = 0, tested = 0;
    for (const std::int32_t n : nodes) opened += static_cast<std::uint64_t>(n);
    for (const std::int32_t n : primitives) tested += static_cast<std::uint64_t>(n);
    EXPECT_EQ(opened, all.nodes);
    EXPECT_EQ(tested, all.primitives);
    EXPECT_GT(opened, 0u);
    // The grid has all of the mesh in one cell, which is what a stadium is for.
    if (one.kind != StructureKind::kGrid) {
      EXPECT_LT(all.primitives, TimedRays::kSize * triangles / 10);
    }
    const StructureFigures figures = structured.structure().figures();
    EXPECT_EQ(figures.primitives, triangles);
    EXPECT_GE(figures.references, triangles);
    EXPECT_GE(structured.structure().memory_bytes(), triangles * sizeof(Primitive));
  }
}

/// A list that grows would be copied as a whole, and no stop be looked for meanwhile.
TEST(Structures, ListPrimitivesWithoutCopies) {
  for (const ShapeTable& table : {stadium(), many_kinds(), nested_kinds()}) {
    const Structured brute(kBrute, table);
    const auto& structure = static_cast<const TreeStructure<Brute>&>(brute.structure());
    EXPECT_EQ(structure.world().primitives.capacity(),
              static_cast<std::size_t>(std::accumulate(
                  table.shapes.begin(), table.shapes.begin() + table.world_shape_count, 0,
                  [](int sum, const ShapeRecord& shape) {
                    return sum + (shape.kind == ShapeKind::kTriangles ? shape.triangle_count : 1);
                  })) +
                  table.instances.size());
  }
}

TEST(Structures, AnswerTheSameWithAShadowCache) {
  for (const ShapeTable& table : {sheets(), stadium(), many_kinds(), nested_kinds()}) {
    for (const Named& one : kJudged) {
      SCOPED_TRACE(one.name);
      const Structured plain(one, table), cached(one, table, true);
      Numbers random(31);
      TimedRays rays;
      int blocked = 0;
      for (std::int64_t all = 0; all < stress_count(4e3, 1e5); all += TimedRays::kSize) {
        fill(rays, table, 1, {}, random);
        // Rays go to a few places, again and again, and to infinity.
        for (int i = 0; i < TimedRays::kSize; ++i) {
          if (i % 4 == 0) rays.distance[i] = HUGE_VALF;
          if (i % 4 == 1) rays.aim(i, in_cube(random, 3), Point{0.1, 0.2, 3} * (i % 8 == 1 ? 1 : -1));
          if (i % 16 == 2) rays.distance[i] = -1;
        }
        TimedRays expected = rays;
        plain.query().occluded(expected.timed(), TimedRays::kSize, expected.distance);
        cached.query().occluded(rays.timed(), TimedRays::kSize, rays.distance);
        ASSERT_EQ(std::memcmp(rays.distance, expected.distance, sizeof(rays.distance)), 0);
        blocked += static_cast<int>(std::ranges::count_if(rays.distance, [](float d) { return d < 0; }));
      }
      EXPECT_GT(blocked, 100);
    }
  }
}

/// Rays so close that one primitive blocks all of them: the first is searched for, and no other opens a node.
TEST(Structures, ShadowCachesAnswerWhatTheLastOccluderBlocks) {
  for (const ShapeTable& table : {stadium(), many_kinds()}) {
    for (const Named& one : kJudged) {
      SCOPED_TRACE(one.name);
      const Structured plain(one, table), cached(one, table, true);
      Numbers random(37);
      int lights = 0;
      for (int tried = 0; tried < 20; ++tried) {
        TimedRays rays;
        const Point from = in_cube(random, 3), to = in_cube(random, 3);
        const auto aim = [&](int n) {
          for (int i = 0; i < n; ++i) {
            rays.time[i] = 0.5f;
            rays.aim(i, from + in_cube(random, 1e-6), to);
            rays.distance[i] = 3;
          }
        };
        const auto opened = [&](const Structured& structured, int n) {
          const RayVisits before = structured.query().visits();
          structured.query().occluded(rays.timed(), n, rays.distance);
          return structured.query().visits() - before;
        };
        aim(1);
        const RayVisits first = opened(plain, 1);
        if (!(rays.distance[0] < 0)) continue;
        aim(TimedRays::kSize);
        const RayVisits all = opened(cached, TimedRays::kSize);
        ASSERT_EQ(std::ranges::count_if(rays.distance, [](float d) { return d < 0; }), TimedRays::kSize);
        EXPECT_EQ(all.nodes, first.nodes);
        // One test for each of the others, and one against what blocked rays to the light before.
        EXPECT_LE(all.primitives, first.primitives + TimedRays::kSize);
        ++lights;
      }
      EXPECT_GT(lights, 5);
    }
  }
}

/// Embree's own tests are in float: a ray within some roundings of an edge may meet the neighbour, or come to
/// another t by as much.
TEST(Structures, FindWhatEmbreeFinds) {
  for (const ShapeTable& table : {stadium(), many_kinds(), nested_kinds()}) {
    const Structured structured({"bvh-sah", StructureKind::kBvhSah}, table);
    const TracedTable embree(table, true);
    TimedRays ours, theirs;
    Numbers random(23);
    std::int64_t all = 0, other = 0, unexplained = 0;
    for (; all < stress_count(2e4, 1e6); all += TimedRays::kSize) {
      for (int i = 0; i < TimedRays::kSize; ++i) {
        ours.time[i] = 0;
        ours.set(i, in_cube(random, 3), random.direction());
      }
      theirs = ours;
      structured.query().nearest(ours.timed(), TimedRays::kSize, false, ours.hits());
      embree.nearest(theirs);
      for (int i = 0; i < TimedRays::kSize; ++i) {
        const bool same = ours.shape[i] == theirs.shape[i] &&
                          (ours.shape[i] < 0 ||
                           (ours.primitive[i] == theirs.primitive[i] &&
                            ours.instance[i] == theirs.instance[i] && ours.upper[i] == theirs.upper[i]));
        if (same) {
          if (ours.shape[i] >= 0) {
            EXPECT_NEAR(ours.t[i], theirs.t[i], 1e-4 * (1 + ours.t[i]));
          }
          continue;
        }
        ++other;
        const auto at_edge = [](const TimedRays& r, int k) {
          constexpr float kNear = 1e-4f;
          return r.shape[k] >= 0 && (r.u[k] < kNear || r.v[k] < kNear || r.u[k] + r.v[k] > 1 - kNear);
        };
        // Instances that lie in one another, to the last bit; places are around 1.
        const bool as_near = std::abs(ours.t[i] - theirs.t[i]) <= 1e-5f * ours.t[i] + 2e-6f;
        unexplained += !as_near && !at_edge(ours, i) && !at_edge(theirs, i);
      }
    }
    EXPECT_EQ(unexplained, 0) << "of " << other << " that differ among " << all;
  }
}

template <class Array>
bool same_bytes(const Array& a, const Array& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}
template <class Node>
bool same_tree(const CellTree<Node>& a, const CellTree<Node>& b) {
  return same_bytes(a.nodes, b.nodes) && same_bytes(a.leaves, b.leaves) && same_bytes(a.items, b.items) &&
         a.root == b.root;
}

TEST(Structures, AreTheSameForAnyNumberOfThreads) {
  const ShapeTable table = slivers(9000);
  std::vector<Primitive> list;
  ASSERT_TRUE(add_primitives(table, 0, {}, list).ok());
  for (const BvhRule rule : {BvhRule::kMedian, BvhRule::kSah}) {
    std::vector<Primitive> one = list, five = list;
    const Bvh a = build_bvh(rule, one, 1), b = build_bvh(rule, five, 5);
    EXPECT_TRUE(same_bytes(a.nodes, b.nodes));
    EXPECT_TRUE(same_bytes(one, five));
  }
  for (const KdRule rule : {KdRule::kMedian, KdRule::kSah})
    EXPECT_TRUE(same_tree(build_kd_tree(rule, list, 1), build_kd_tree(rule, list, 5)));
  EXPECT_TRUE(same_tree(build_octree(list, 1), build_octree(list, 5)));
  EXPECT_TRUE(same_tree(build_bsp_tree(list, 1), build_bsp_tree(list, 5)));
  const auto grid = build_grid(list, kGridDensity, 1), grid5 = build_grid(list, kGridDensity, 5);
  ASSERT_TRUE(grid.ok() && grid5.ok());
  EXPECT_TRUE(same_bytes(grid->items, grid5->items) && same_bytes(grid->firsts, grid5->firsts));
}

/// A triangle that crosses a cell without a vertex in it lies in it; one whose box alone does lies not.
TEST(Structures, KnowTheCellsThatATriangleCrosses) {
  Primitive triangle{};
  const float corners[3][3] = {{-5, -5, 0.5f}, {9, -5, 0.5f}, {-5, 9, 0.5f}};
  std::memcpy(triangle.corners, corners, sizeof(corners));
  const Box cell{{0, 0, 0}, {1, 1, 1}}, corner{{6, 6, 0}, {7, 7, 1}};
  const Box part = part_within(triangle, cell);
  EXPECT_EQ(part.low[2], 0.5f);
  EXPECT_EQ(part.high[0], 1);
  EXPECT_TRUE(part_within(triangle, corner).empty());
}

/// A million twins: nothing can part them, and every build ends all the same.
TEST(Structures, EndWhereNothingCanBeParted) {
  TableMaker maker;
  const std::int64_t n = stress_count(3e4, 1e6);
  for (std::int64_t i = 0; i < n; ++i) maker.add({0, 0, 0}, {1, 0, 0.5}, {0, 1, 0.25});
  maker.end_mesh();
  const ShapeTable table = maker.take();
  TimedRays rays;
  for (int i = 0; i < 16; ++i) rays.time[i] = 0, rays.set(i, {0.2, 0.2, 5}, {0, 0.001 * i, -1});
  for (const Named& one : kJudged) {
    SCOPED_TRACE(one.name);
    const Structured structured(one, table);
    structured.query().nearest(rays.timed(), 16, false, rays.hits());
    for (int i = 0; i < 16; ++i) EXPECT_EQ(rays.primitive[i], 0);
    EXPECT_LE(structured.structure().figures().references, static_cast<std::uint64_t>(65 * n));
  }
}

TEST(Structures, RefuseMoreCellsThanMemoryMayHold) {
  std::vector<Primitive> list;
  ASSERT_TRUE(add_primitives(slivers(100), 0, {}, list).ok());
  const auto grid = build_grid(list, 1e10, 1);
  ASSERT_FALSE(grid.ok());
  EXPECT_EQ(grid.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_NE(grid.status().message().find("at most 2.68e+08"), std::string::npos) << grid.status();
}

TEST(Structures, NameCurvesThatTheyDoNotKnow) {
  ShapeTable table;
  table.shapes.push_back({.kind = ShapeKind::kCurves, .number = 7});
  table.world_shape_count = 1;
  const TextureTable textures;
  const auto built = build_structure(StructureKind::kGrid, table, textures, structure_kernel().analytic, {});
  ASSERT_FALSE(built.ok());
  EXPECT_NE(built.status().message().find("shape 7"), std::string::npos) << built.status();
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
