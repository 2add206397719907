// Instances in scene files: a message each where they are few, packed where they are many.
#include <cstring>

#include "import/input/concat.h"
#include "import/input/instance_list.h"
#include "unit/import/import_fixture.h"
#include "wire/packed_instances.h"

namespace tessera::client {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class ManyInstances : public ImportTest {
 protected:
  static constexpr std::size_t kMany = InstanceList::kMostMessages + 1;

  static constexpr char kObjects[] =
      "ObjectBegin \"a\" Shape \"sphere\" ObjectEnd ObjectBegin \"b\" Shape \"disk\" ObjectEnd\n";

  /// pbrt's directives for instances of two objects in turn, instance i at x = i.
  static std::string in_turn(std::size_t count) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i)
      text += concat("AttributeBegin Translate ", i, " 0 0 ObjectInstance \"", i % 2 == 0 ? "a" : "b",
                     "\" AttributeEnd\n");
    return text;
  }
  static const SceneBlob& blob_of(const v1::PackedInstances& packed, const ImportedScene& scene) {
    const auto found = std::ranges::find_if(
        scene.blobs, [&](const SceneBlob& blob) { return blob.ref.digest() == packed.matrices().digest(); });
    EXPECT_NE(found, scene.blobs.end());
    return *found;
  }
};

TEST_F(ManyInstances, ArePackedObjectByObject) {
  const ImportedScene few = world(kObjects + in_turn(kMany - 1));
  EXPECT_THAT(few.scene.instances(), SizeIs(kMany - 1));
  EXPECT_FALSE(few.scene.has_packed_instances());
  EXPECT_EQ(few.scene.instances(1).object(), "b");

  const ImportedScene many = world(kObjects + in_turn(kMany));
  EXPECT_THAT(many.scene.instances(), SizeIs(0));
  const v1::PackedInstances& packed = many.scene.packed_instances();
  ASSERT_THAT(packed.runs(), SizeIs(2));
  EXPECT_EQ(packed.runs(0).object(), "a");
  EXPECT_EQ(packed.runs(0).count(), kMany / 2 + 1);
  EXPECT_EQ(packed.runs(1).count(), kMany / 2);
  const std::string& blob = blob_of(packed, many).bytes;
  EXPECT_EQ(blob.size(), 16 + 96 * kMany);
  const auto matrices = wire::decode_matrices(packed, blob);
  ASSERT_TRUE(matrices.ok()) << matrices.status();
  // The second of "a" is instance 2, the first of "b" instance 1.
  EXPECT_EQ((*matrices)[12 + 3], 2);
  EXPECT_EQ((*matrices)[12 * (kMany / 2 + 1) + 3], 1);
  EXPECT_EQ((*matrices)[0], 1);
}

TEST_F(ManyInstances, KeepMessagesWhereTheyMove) {
  const ImportedScene scene =
      world(kObjects + in_turn(kMany) + "ActiveTransform EndTime Translate 0 1 0 ObjectInstance \"b\"\n");
  ASSERT_THAT(scene.scene.instances(), SizeIs(1));
  EXPECT_EQ(scene.scene.instances(0).object(), "b");
  EXPECT_THAT(scene.scene.instances(0).world_from_instance_end().elements(), SizeIs(16));
  EXPECT_EQ(scene.scene.packed_instances().runs(1).count(), kMany / 2);
}

TEST_F(ManyInstances, ArePackedInObjectsToo) {
  const ImportedScene scene = world(concat(kObjects, "ObjectBegin \"group\" ", in_turn(kMany),
                                           "ObjectInstance \"none\" ObjectEnd ObjectBegin \"unused\" ",
                                           in_turn(kMany), "ObjectEnd ObjectInstance \"group\"\n")
                                        .replace(0, 0, "ObjectBegin \"none\" ObjectEnd "));
  ASSERT_THAT(scene.scene.objects(), SizeIs(3));
  const v1::Object& group = scene.scene.objects(2);
  EXPECT_EQ(group.name(), "group");
  EXPECT_THAT(group.packed_instances().runs(), SizeIs(2));
  EXPECT_THAT(scene.blobs, SizeIs(1));
}

TEST_F(ManyInstances, AreWrittenAndReadAgain) {
  const ImportedScene scene = world(kObjects + in_turn(kMany));
  for (const char* const name : {"packed.textproto", "packed.tsb"}) {
    const std::filesystem::path path = folder_ / name;
    ASSERT_TRUE(write_scene(scene, path).ok());
    const auto again = import_scene(path);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(again->scene.packed_instances().matrices().digest(),
              scene.scene.packed_instances().matrices().digest());
    EXPECT_EQ(again->scene.packed_instances().runs_size(), 2);
  }
  // A scene that was written before there were any has messages, which are packed as they are read.
  ImportedScene messages = scene;
  messages.blobs.clear();
  messages.scene.clear_packed_instances();
  for (std::size_t i = 0; i < kMany; ++i) {
    v1::Instance& instance = *messages.scene.add_instances();
    instance.set_object(i % 2 == 0 ? "a" : "b");
    write_matrix(translation(static_cast<double>(i), 0, 0), *instance.mutable_world_from_instance());
  }
  const std::filesystem::path path = folder_ / "messages.tsb";
  ASSERT_TRUE(write_scene(messages, path).ok());
  const auto again = import_scene(path);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->scene.packed_instances().matrices().digest(),
            scene.scene.packed_instances().matrices().digest());
  EXPECT_EQ(again->scene.instances_size(), 0);
  // An animation names instances by their numbers.
  v1::Track& track = *messages.scene.mutable_animation()->add_tracks();
  track.set_instance(3);
  track.add_keys();
  ASSERT_TRUE(write_scene(messages, path).ok());
  const auto animated = import_scene(path);
  ASSERT_TRUE(animated.ok()) << animated.status();
  EXPECT_EQ(animated->scene.instances_size(), static_cast<int>(kMany));
}

TEST_F(ManyInstances, FaultsOfTheirFilesAreTold) {
  const ImportedScene scene = world(kObjects + in_turn(kMany));
  const std::filesystem::path path = folder_ / "faulty.textproto";
  ImportedScene faulty = scene;
  faulty.scene.mutable_packed_instances()->mutable_runs(0)->set_count(1);
  ASSERT_TRUE(write_scene(faulty, path).ok());
  EXPECT_THAT(error_of(import_scene(path)), HasSubstr("packed instances: the runs have 2048 less than 4097"));
  faulty.scene.mutable_packed_instances()->mutable_runs(0)->set_object("none");
  ASSERT_TRUE(write_scene(faulty, path).ok());
  EXPECT_THAT(error_of(import_scene(path)), HasSubstr("there is no object \"none\""));
}

TEST_F(ManyInstances, OfObjectsThatAreMissingAreToldAtTheirLines) {
  const auto result = import_text(
      "WorldBegin\nObjectInstance \"late\"\nObjectInstance \"none\"\n"
      "ObjectBegin \"late\" Shape \"sphere\" ObjectEnd\n  ObjectInstance \"none\"\n");
  const std::string text = error_of(result);
  EXPECT_THAT(
      text, testing::AllOf(HasSubstr(":3:1: there is no object \"none\""),
                           HasSubstr(":5:3: there is no object \"none\""), testing::Not(HasSubstr("late"))));
}

}  // namespace
}  // namespace tessera::client
