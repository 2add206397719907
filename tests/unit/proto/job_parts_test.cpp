#include "wire/job_parts.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>

#include <string>
#include <vector>

namespace tessera::wire {
namespace {

using ::testing::UnorderedElementsAreArray;

/// Names of the fields that are in no part of their own: JobSpec.settings is taken apart.
std::vector<std::string> fields_of(const google::protobuf::Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) {
    if (type.field(i)->name() != "settings") names.push_back(type.name() + "." + type.field(i)->name());
  }
  return names;
}

TEST(JobParts, EveryFieldIsInOne) {
  std::vector<std::string> there = fields_of(*v1::JobSpec::descriptor()), listed;
  for (const std::string& name : fields_of(*v1::RenderSettings::descriptor())) there.push_back(name);
  for (const JobField& field : job_fields())
    listed.push_back(std::string{field.message} + "." + std::string{field.name});
  EXPECT_THAT(listed, UnorderedElementsAreArray(there)) << "a new field must say what depends on it";
}

TEST(JobParts, HaveTheFieldsThatAreListedAndNoOthers) {
  v1::JobSpec spec;
  spec.set_name("of the farm");
  spec.set_width(640);
  spec.set_tile_size(16);
  spec.mutable_scene()->set_digest("abc");
  spec.mutable_scene()->set_path("here.pbrt");
  spec.mutable_settings()->set_spp(64);
  spec.mutable_settings()->set_integrator("path");
  using enum JobPart;
  constexpr JobPart kParts[] = {kScene, kView};
  const v1::JobSpec part = parts_of(spec, kParts);
  v1::JobSpec expected;
  expected.set_width(640);
  expected.mutable_scene()->set_digest("abc");
  expected.mutable_settings()->set_integrator("path");
  EXPECT_EQ(part.DebugString(), expected.DebugString());
}

}  // namespace
}  // namespace tessera::wire
