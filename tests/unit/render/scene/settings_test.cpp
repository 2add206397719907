// A job's settings alone.
#include "render/scene/view/settings.h"

#include <gtest/gtest.h>

#include <set>

#include "unit/render/scene/builder_inputs.h"
#include "wire/limits.h"
#include "wire/resolve_settings.h"

namespace tessera::render {
namespace {

Settings settings_of(const std::string& job) { return read_settings(message<v1::JobSpec>(job)); }

TEST(ReadSettings, WhatIsNotSpecifiedIsTheDefault) {
  const Settings settings = settings_of("");
  EXPECT_EQ(settings.algorithm, &wire::algorithms()[0]);
  EXPECT_EQ(settings.sampler.kind, SamplerKind::kSobol);
  EXPECT_EQ(settings.asked.ByteSizeLong(), 0u);
  EXPECT_EQ(settings.aovs.hit_aovs, 0u);
}

TEST(ReadSettings, TakesWhatTheJobNames) {
  const Settings settings = settings_of(R"(
      content { algorithms { integrator: 'volpath' intersection: INTERSECTION_ROBUST } }
      view { aovs: AOV_NORMAL sampler: SAMPLER_INDEPENDENT seed: 9 max_depth: 4000000000 })");
  EXPECT_STREQ(settings.algorithm->name, "volpath");
  EXPECT_EQ(settings.sampler.kind, SamplerKind::kIndependent);
  EXPECT_EQ(settings.sampler.seed, 9u);
  EXPECT_EQ(settings.max_depth, static_cast<std::int32_t>(wire::kMaxDepth));
  EXPECT_EQ(settings.asked.intersection(), v1::INTERSECTION_ROBUST);
  EXPECT_TRUE(settings.aovs.has(wire::HitAov::kNormal));
  EXPECT_FALSE(settings.aovs.has(wire::HitAov::kDepth));
  const Settings z = settings_of("view { sampler: SAMPLER_Z_SOBOL sample_bits: 5 }");
  EXPECT_EQ(z.sampler.kind, SamplerKind::kZSobol);
  EXPECT_EQ(z.sampler.sample_bits, 5);
}

TEST(ReadSettings, EveryAcceleratorButEmbreesIsAStructure) {
  EXPECT_FALSE(settings_of("").structure);
  EXPECT_FALSE(settings_of("content { algorithms { accelerator: ACCELERATOR_EMBREE } }").structure);
  std::set<StructureKind> kinds;
  for (int a = v1::ACCELERATOR_BRUTE; a <= v1::Accelerator_MAX; ++a) {
    v1::JobSpec job;
    job.mutable_content()->mutable_algorithms()->set_accelerator(static_cast<v1::Accelerator>(a));
    const Settings settings = read_settings(job);
    ASSERT_TRUE(settings.structure) << a;
    kinds.insert(*settings.structure);
  }
  EXPECT_EQ(static_cast<int>(kinds.size()), v1::Accelerator_MAX - 1);
}

/// A worker keeps scenes and a coordinator results under the digest of a job's content.
TEST(ReadSettings, JobsOfBeforeThereWereAcceleratorsKeepTheirDigests) {
  v1::JobSpec absent, named, other;
  v1::RenderSettings asked;
  wire::resolve_settings(asked, absent);
  asked.set_accelerator(v1::ACCELERATOR_EMBREE);
  asked.set_nesting(v1::NESTING_AUTO);
  wire::resolve_settings(asked, named);
  EXPECT_EQ(absent.SerializeAsString(), named.SerializeAsString());
  asked.set_accelerator(v1::ACCELERATOR_GRID);
  asked.set_nesting(v1::NESTING_KEPT);
  wire::resolve_settings(asked, other);
  EXPECT_EQ(other.content().algorithms().nesting(), v1::NESTING_KEPT);
  EXPECT_EQ(other.content().algorithms().accelerator(), v1::ACCELERATOR_GRID);
}

}  // namespace
}  // namespace tessera::render
