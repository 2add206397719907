#include "service/job/old_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scheduler/work_plan.h"
#include "service/job/adoption.h"
#include "tessera/v1/old_job.pb.h"
#include "unit/server/requests.h"
#include "wire/enum_words.h"

namespace tessera::server {
namespace {

using ::testing::ElementsAre;

/// A job as a coordinator journaled it before specs had parts.
v1::OldJobSpec old_spec() {
  v1::OldJobSpec old;
  old.set_name("kitchen");
  old.mutable_scene()->set_digest(std::string(64, 'a'));
  old.add_blobs()->set_digest(std::string(64, 'b'));
  v1::OldJobSpec::Settings& settings = *old.mutable_settings();
  settings.set_integrator("volpath");
  settings.set_sampler("independent");
  settings.set_spp(64);
  settings.set_max_depth(7);
  settings.set_seed(20);
  settings.set_intersection("robust");
  settings.set_direct_light("mis");
  settings.set_light_selection("tree");
  settings.set_traversal("single");
  old.set_width(640);
  old.set_height(480);
  old.mutable_crop()->set_x1(640);
  old.mutable_crop()->set_y1(480);
  old.set_tile_size(32);
  old.set_samples_per_unit(16);
  for (const char* aov : {"depth", "albedo", "depth"}) old.add_aovs(aov);
  old.set_isa("avx2");
  old.set_priority(-3);
  old.set_user("alice");
  old.add_required_tags("big");
  old.set_max_workers(2);
  old.set_build("0.1.0");
  old.set_bits(v1::BITS_ANY);
  return old;
}

TEST(OldSpec, FieldsThatAreGoneAreLeftOut) {
  v1::JobSpec job = *read_spec(old_spec().SerializeAsString());
  // The kind of mutations: every job of mlt had it.
  v1::MetropolisSettings& metropolis = *job.mutable_content()->mutable_algorithms()->mutable_mlt();
  metropolis.GetReflection()->MutableUnknownFields(&metropolis)->AddVarint(5, 1);
  EXPECT_FALSE(wire::check_known(job).ok());
  const absl::StatusOr<v1::JobSpec> read = read_spec(job.SerializeAsString());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(wire::check_known(*read).ok()) << wire::check_known(*read);
  EXPECT_TRUE(read->content().algorithms().has_mlt());
}

TEST(OldSpec, HasEverythingInItsPart) {
  const absl::StatusOr<v1::JobSpec> read = read_spec(old_spec().SerializeAsString());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_TRUE(WorkPlan::make(*read).ok()) << WorkPlan::make(*read).status();
  const v1::Algorithms& algorithms = read->content().algorithms();
  EXPECT_EQ(read->content().scene(), std::string(64, 'a'));
  EXPECT_EQ(read->content().build(), "0.1.0");
  EXPECT_EQ(algorithms.integrator(), "volpath");
  EXPECT_EQ(algorithms.intersection(), v1::INTERSECTION_ROBUST);
  EXPECT_EQ(algorithms.direct_light(), v1::DIRECT_LIGHT_MIS);
  EXPECT_EQ(algorithms.light_selection(), v1::LIGHT_SELECTION_TREE);
  EXPECT_EQ(algorithms.traversal(), v1::TRAVERSAL_SINGLE);
  EXPECT_EQ(read->view().width(), 640u);
  EXPECT_EQ(read->view().height(), 480u);
  EXPECT_THAT(read->view().aovs(), ElementsAre(v1::AOV_ALBEDO, v1::AOV_DEPTH));
  EXPECT_EQ(read->view().sampler(), v1::SAMPLER_INDEPENDENT);
  EXPECT_EQ(read->view().seed(), 20u);
  EXPECT_EQ(read->view().max_depth(), 7u);
  EXPECT_EQ(read->samples().spp(), 64u);
  EXPECT_EQ(read->cut().crop().x1(), 640u);
  EXPECT_EQ(read->cut().tile_size(), 32u);
  EXPECT_EQ(read->cut().samples_per_unit(), 16u);
  EXPECT_EQ(read->farm().blobs_size(), 2) << "the scene and what it refers to";
  EXPECT_EQ(read->farm().name(), "kitchen");
  EXPECT_EQ(read->farm().isa(), "avx2");
  EXPECT_EQ(read->farm().priority(), -3);
  EXPECT_EQ(read->farm().user(), "alice");
  EXPECT_THAT(read->farm().required_tags(), ElementsAre("big"));
  EXPECT_EQ(read->farm().max_workers(), 2u);
  EXPECT_EQ(read->farm().bits(), v1::BITS_ANY);
}

TEST(OldSpec, WordsThatNobodyKnowsAreTheDefault) {
  v1::OldJobSpec zigzag = old_spec(), shadow = old_spec();
  zigzag.mutable_settings()->set_traversal("zigzag");
  shadow.add_aovs("shadow");
  for (const v1::OldJobSpec& old : {zigzag, shadow}) {
    const absl::StatusOr<v1::JobSpec> read = read_spec(old.SerializeAsString());
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_TRUE(WorkPlan::make(*read).ok()) << WorkPlan::make(*read).status();
    EXPECT_EQ(read->view().aovs_size(), 2) << "the others";
  }
}

TEST(OldSpec, WhatIsNoSpecIsRefused) {
  EXPECT_EQ(read_spec("\xff\xff").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(OldSpec, NewOnesAreReadAsTheyAre) {
  const v1::JobSpec spec = square_spec("scene", 32);
  const absl::StatusOr<v1::JobSpec> read = read_spec(spec.SerializeAsString());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(difference_in_content(*read, spec), "");
  EXPECT_EQ(read->SerializeAsString(), spec.SerializeAsString());
}

}  // namespace
}  // namespace tessera::server
