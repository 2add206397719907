// Things that stand in a scene, shape by shape and instance by instance.
#include "measure/placed_things.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "google/protobuf/text_format.h"
#include "import/geometry/transform.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;

std::vector<PlacedThing> things_in(const std::string& text) {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &scene)) << text;
  return placed_things(scene);
}

std::vector<std::string> names_of(const std::vector<PlacedThing>& things) {
  std::vector<std::string> names;
  for (const PlacedThing& thing : things) names.push_back(thing.name);
  return names;
}

std::string moved(const std::string& field, double x, double scale) {
  const std::string s = std::to_string(scale);
  return field + " { elements: [" + s + ",0,0," + std::to_string(x) + ", 0," + s + ",0,0, 0,0," + s +
         ",0, 0,0,0,1] } ";
}

const char* const kBall = "shapes { sphere { radius: 1 } } ";

TEST(PlacedThings, HaveNames) {
  const auto things = things_in(
      "shapes { name: 'floor' disk { radius: 1 } } shapes { sphere { radius: 1 } } "
      "objects { name: 'chair' shapes { sphere { radius: 1 } } } "
      "objects { name: 'table' shapes { sphere { radius: 1 } } } "
      "instances { object: 'chair' } instances { object: 'table' } instances { object: 'chair' } ");
  EXPECT_THAT(names_of(things), ElementsAre("floor", "shape 2", "chair 1", "table", "chair 2"));
  for (const PlacedThing& thing : things) {
    EXPECT_EQ(thing.shapes.size(), 1u);
    EXPECT_EQ(thing.obstacle, "");
    EXPECT_FALSE(thing.shines);
  }
}

TEST(PlacedThings, AreInWorldSpace) {
  // A ball at 1, in an object that is at 10 and twice as large, in one at 100.
  const auto things =
      things_in("objects { name: 'inner' shapes { sphere { radius: 1 } " + moved("world_from_object", 1, 1) +
                "area_light {} } } objects { name: 'outer' instances { object: 'inner' " +
                moved("world_from_instance", 10, 2) + "} } instances { object: 'outer' " +
                moved("world_from_instance", 100, 3) + "} ");
  ASSERT_EQ(things.size(), 1u);
  ASSERT_EQ(things[0].shapes.size(), 1u);
  EXPECT_TRUE(things[0].shines);
  const Imath::M44d map = matrix_of(things[0].shapes[0].world_from_object());
  EXPECT_EQ(Imath::V3d(0) * map, Imath::V3d(100 + 3 * (10 + 2 * 1), 0, 0));
  EXPECT_EQ(Imath::V3d(0, 1, 0) * map, Imath::V3d(136, 6, 0));
}

TEST(PlacedThings, BordersThatLightPassesAreNone) {
  const auto things = things_in(
      "materials { name: 'open' interface {} } shapes { material: 'open' sphere { radius: 1 } "
      "interior_medium: 'fog' } shapes { name: 'wall' material: 'paint' disk { radius: 1 } } ");
  EXPECT_THAT(names_of(things), ElementsAre("wall"));
}

TEST(PlacedThings, SayWhatIsInTheWay) {
  const std::string object = std::string("objects { name: 'o' ") + kBall + "} ";
  const auto moving =
      things_in(object + "instances { object: 'o' " + moved("world_from_instance_end", 1, 1) + "} ");
  ASSERT_EQ(moving.size(), 1u);
  EXPECT_EQ(moving[0].obstacle, "it moves");
  EXPECT_TRUE(moving[0].shapes.empty());
  const auto packed = things_in(
      "objects { name: 'leaf' shapes { sphere { radius: 1 } area_light {} } } "
      "packed_instances { runs { object: 'leaf' count: 5000 } } ");
  ASSERT_EQ(packed.size(), 1u);
  EXPECT_EQ(packed[0].name, "instances of leaf");
  EXPECT_EQ(packed[0].obstacle, "there are 5000 of them");
  EXPECT_TRUE(packed[0].shines);
  EXPECT_EQ(things_in("instances { object: 'none' } ")[0].obstacle, "its object is not there");
}

TEST(PlacedThings, AreAsManyAsCanBeRead) {
  // Each level has four of the one below: 4^6 = 4096 balls.
  std::string text = std::string("objects { name: 'level 0' ") + kBall + "} ";
  for (int level = 1; level <= 6; ++level) {
    text += "objects { name: 'level " + std::to_string(level) + "' ";
    for (int i = 0; i < 4; ++i) text += "instances { object: 'level " + std::to_string(level - 1) + "' } ";
    text += "} ";
  }
  const auto all = things_in(text + "instances { object: 'level 6' } instances { object: 'level 0' } ");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].shapes.size(), 4096u);
  EXPECT_EQ(all[1].obstacle, "instances hold too many surfaces for it to be read, too");
  const auto half = things_in(text +
                              "instances { object: 'level 0' } instances { object: 'level 6' } "
                              "instances { object: 'level 0' } ");
  ASSERT_EQ(half.size(), 3u);
  EXPECT_EQ(half[0].obstacle, "");
  EXPECT_NE(half[1].obstacle, "");
  EXPECT_EQ(half[2].obstacle, "");
}

}  // namespace
}  // namespace tessera::client
