// Objects within objects: the graph, what is flattened of it, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/object_graph.h"
#include "render/shape/place.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render::nested_objects {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct GraphOf {
  v1::Scene scene;
  NameTable names{"object"};
  absl::StatusOr<ObjectGraph> graph;

  explicit GraphOf(const std::string& text) : scene(message<v1::Scene>(text)) {
    for (int i = 0; i < scene.objects_size(); ++i) EXPECT_TRUE(names.add(scene.objects(i).name(), i).ok());
    graph = ObjectGraph::of(scene.objects(), names);
  }
  std::string error() const { return std::string(graph.status().message()); }
};

/// Each object holds the one before it `width` times: n0, n1 ...
std::string chain(int objects, int width = 1) {
  std::string text;
  for (int i = 0; i < objects; ++i) {
    absl::StrAppend(&text, "objects { name: 'n", i, "' ");
    for (int k = 0; i > 0 && k < width; ++k) absl::StrAppend(&text, "instances { object: 'n", i - 1, "' } ");
    absl::StrAppend(&text, "} ");
  }
  return text;
}

absl::StatusOr<NestingPlan> plan(const std::string& objects, std::vector<int> placed,
                                 v1::Nesting asked = v1::NESTING_UNSPECIFIED, const std::string& wants = "") {
  const GraphOf of(objects);
  if (!of.graph.ok()) return of.graph.status();
  return plan_nesting(*of.graph, std::vector<std::uint64_t>(of.scene.objects_size(), 1), placed, asked,
                      wants);
}

TEST(ObjectGraph, SortsObjectsBehindThoseThatTheyHold) {
  const GraphOf flat("objects { name: 'a' } objects { name: 'b' } objects { name: 'c' }");
  ASSERT_TRUE(flat.graph.ok());
  EXPECT_THAT(flat.graph->order(), ElementsAre(0, 1, 2));
  EXPECT_EQ(flat.graph->depth(), 1);
  const GraphOf nested(
      "objects { name: 'a' instances { object: 'c' } instances { object: 'b' } } objects { name: 'b' } "
      "objects { name: 'c' instances { object: 'b' } }");
  ASSERT_TRUE(nested.graph.ok());
  EXPECT_THAT(nested.graph->order(), ElementsAre(1, 2, 0));
  EXPECT_EQ(nested.graph->depth(), 3);
}

TEST(ObjectGraph, NamesCyclesByTheirWay) {
  EXPECT_EQ(GraphOf("objects { name: 'a' instances { object: 'a' } }").error(),
            "object 'a' holds itself: 'a' > 'a'");
  EXPECT_EQ(GraphOf("objects { name: 'x' instances { object: 'a' } } "
                    "objects { name: 'a' instances { object: 'b' } } objects { name: 'b' instances { "
                    "object: 'c' } } objects { name: 'c' instances { object: 'a' } }")
                .error(),
            "object 'a' holds itself: 'a' > 'b' > 'c' > 'a'");
  EXPECT_EQ(GraphOf("objects { name: 'a' instances { object: 'b' } }").error(),
            "object 'a', instance 0 (b): object 'b' does not exist");
}

TEST(ObjectGraph, RefusesWaysThatAreTooLong) {
  EXPECT_TRUE(GraphOf(chain(ObjectGraph::kDeepest)).graph.ok());
  EXPECT_EQ(
      GraphOf(chain(65)).error(),
      "objects hold one another 65 deep, at most 64: 'n64' > 'n63' > 'n62' > 'n61' > ... > 'n3' > 'n2' > "
      "'n1' > 'n0'");
  EXPECT_THAT(GraphOf(chain(100000)).error(), HasSubstr("hold one another 100000 deep"));
}

TEST(NestingPlan, FlattensWhereThereIsRoom) {
  const auto small = plan(chain(4, 10), {3});
  ASSERT_TRUE(small.ok());
  EXPECT_THAT(small->kept, ElementsAre(false, false, false, false));
  EXPECT_THAT(small->note, AllOf(HasSubstr("4 deep"), HasSubstr("for there is room: 1111 instances")));
  EXPECT_EQ(plan(chain(1), {0, 0, 0})->note, "");

  const auto kept = plan(chain(4, 10), {3}, v1::NESTING_KEPT);
  ASSERT_TRUE(kept.ok());
  EXPECT_THAT(kept->kept, ElementsAre(false, true, true, true));
  EXPECT_THAT(kept->note, HasSubstr("3 of them are kept as levels, as asked"));
}

TEST(NestingPlan, KeepsTheWorldAsALevelWhereItHasTooManyInstances) {
  const std::vector<int> room(kMostFlattened, 0), many(kMostFlattened + 1, 0);
  EXPECT_FALSE(plan(chain(1), room)->world_kept);
  EXPECT_TRUE(plan(chain(1), many)->world_kept);
  EXPECT_TRUE(plan(chain(2), many)->world_kept);
  EXPECT_FALSE(plan(chain(1), many, v1::NESTING_FLATTENED)->world_kept);
  EXPECT_FALSE(plan(chain(1), many, v1::NESTING_UNSPECIFIED, "someone")->world_kept);
}

TEST(NestingPlan, KeepsAsFewLevelsAsThereIsRoomFor) {
  const auto large = plan(chain(10, 10), {9, 9, 9});
  ASSERT_TRUE(large.ok()) << large.status();
  // An object at level k comes to about 10^k parts and is used ten times: those up to n4 add 1.2 * 10^5, n5
  // would add 10^6; the levels above it begin anew.
  EXPECT_THAT(large->kept, ElementsAre(false, false, false, false, false, true, false, false, false, false));
  EXPECT_THAT(large->note, HasSubstr("3333333333 instances"));
}

TEST(NestingPlan, LeavesOutWhatNothingPlaces) {
  // n9 holds n8 and so on; only n2, and n1 and n0 in it, are in the world.
  const auto small = plan(chain(64, 2), {2, 2});
  ASSERT_TRUE(small.ok()) << small.status();
  EXPECT_EQ(small->uses[3], 0u);
  EXPECT_EQ(small->uses[2], 2u);
  EXPECT_EQ(small->uses[1], 2u);
  EXPECT_THAT(small->note, HasSubstr("14 instances"));
}

TEST(NestingPlan, RefusesWhatCannotBeCountedOrHeld) {
  EXPECT_THAT(std::string(plan(chain(64, 2), {63}).status().message()), HasSubstr("2^62 places or more"));
  EXPECT_EQ(
      plan(chain(9, 10), {8}, v1::NESTING_FLATTENED).status().message(),
      "nesting 'flattened' places every object in the world, here 111111111 instances; at most 16777216");
  EXPECT_EQ(plan(chain(9, 10), {8}, v1::NESTING_KEPT, "integrator 'radiosity'").status().message(),
            "integrator 'radiosity' places every object in the world, here 111111111 instances; at most "
            "16777216");
  EXPECT_THAT(plan(chain(3, 2), {2}, v1::NESTING_KEPT, "integrator 'radiosity'")->kept,
              ElementsAre(false, false, false));
}

TEST(Places, NumbersLeadBackToTheirInstances) {
  // The world: a, b, b. b holds a twice and a shape; a is a shape.
  ShapeTable table;
  table.objects = {{0, 1, 0, 0}, {1, 1, 0, 2}};
  const auto at = [](std::int32_t object, float x) {
    InstanceRecord record;
    record.object = object;
    record.render_from_instance.m[3] = x;
    return record;
  };
  table.inner = {at(0, 1), at(0, 2)};
  table.instances = {at(0, 100), at(1, 200), at(1, 300)};
  number_places(table);
  const auto x_of = [&](std::int64_t place) { return map_of_place(table, place, 0).render_from_object.m[3]; };
  const double expected[] = {100, 200, 201, 202, 300, 301, 302};
  for (int place = 0; place < 7; ++place) EXPECT_EQ(x_of(place), expected[place]) << place;
  EXPECT_EQ(place_within(4, table.inner[1]), 6);
  EXPECT_EQ(map_of_place(table, 6, 0).shift, 302);
  const std::int64_t large = (std::int64_t{1} << 61) + 12345;
  EXPECT_EQ(place_number(lower_part(large), upper_part(large)), large);
}

}  // namespace
}  // namespace tessera::render::nested_objects
