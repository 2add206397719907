// Layers at the door of the programs.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "wire/algorithm.h"
#include "wire/aov_channels.h"
#include "wire/job_check.h"
#include "wire/tile_result.h"

namespace tessera::test::layers_check {
namespace {

TEST(LayersOfJobs, AreRefusedWhereAnAlgorithmCannotTellThem) {
  wire::add_algorithm({.name = "cannot tell"});
  v1::JobSpec job;
  job.mutable_content()->mutable_algorithms()->set_integrator("cannot tell");
  EXPECT_TRUE(wire::check_settings(job).ok());
  v1::Layer& layer = *job.mutable_view()->add_layers();
  layer.set_name("a");
  layer.set_expression("LE");
  EXPECT_EQ(wire::check_settings(job).message(),
            "integrator 'cannot tell' cannot tell the paths of light apart: layers are not for it");
  job.mutable_content()->mutable_algorithms()->set_integrator("path");
  EXPECT_TRUE(wire::check_settings(job).ok());
  layer.set_expression("LX");
  EXPECT_EQ(std::string(wire::check_settings(job).message()).find("layer 'a': column 2: 'X' is unknown"), 0u);
}

TEST(LayersOfJobs, HaveTheirChannelsBehindAllOthers) {
  v1::JobSpec::View view;
  view.add_aovs(v1::AOV_DEPTH);
  view.add_aovs(v1::AOV_VARIANCE);
  for (const char* name : {"b", "a"}) view.add_layers()->set_name(name);
  std::vector<std::string> names;
  for (const wire::ChannelDesc& channel : wire::channels_of(view)) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"R", "G", "B", "A", "variance.R", "variance.G", "variance.B",
                                             "depth.Z", "b.R", "b.G", "b.B", "a.R", "a.G", "a.B"}));
}

TEST(LayersOfJobs, AsManyAsThereMayBeFitAResult) {
  v1::JobSpec::View view;
  for (const v1::AOV aov : {v1::AOV_VARIANCE, v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH})
    view.add_aovs(aov);
  for (std::size_t i = 0; i < layers::kMaxLayers; ++i) view.add_layers()->set_name("a" + std::to_string(i));
  EXPECT_LE(wire::channels_of(view).size(), wire::kMaxChannels);
}

}  // namespace
}  // namespace tessera::test::layers_check
