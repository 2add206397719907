// Layers at the door of the programs.
#include <gtest/gtest.h>

#include <ctime>
#include <string>
#include <vector>

#include "layers/automaton.h"
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

TEST(LayersOfJobs, AreRefusedWhereAnAlgorithmHasNoSuchPartsOfLight) {
  v1::JobSpec job;
  v1::Algorithms& algorithms = *job.mutable_content()->mutable_algorithms();
  v1::Layer& layer = *job.mutable_view()->add_layers();
  layer.set_name("a");
  const auto message = [&](const char* integrator, const char* expression) {
    algorithms.set_integrator(integrator);
    layer.set_expression(expression);
    return std::string(wire::check_settings(job).message());
  };
  EXPECT_EQ(message("bdpt", "s1t2"), "");
  EXPECT_EQ(message("bdpt", "unweighted s2t1:LS+DE"), "");
  EXPECT_EQ(message("bdpt", "shadow:LDE"), "");
  EXPECT_EQ(message("path", "shadow:LDE"), "");
  EXPECT_EQ(message("path", "s1t2"),
            "integrator 'path' has no strategies of its own: layer 'a' is not for it");
  EXPECT_EQ(message("light", "shadow"),
            "integrator 'light' does not see what is in the way of lights: layer 'a' is not for it");
  algorithms.set_direct_light(v1::DIRECT_LIGHT_BSDF);
  EXPECT_EQ(message("path", "shadow"),
            "integrator 'path' with direct_light 'bsdf' does not see what is in the way of lights: layer 'a' "
            "is not for it");
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

TEST(LayersOfJobs, KeepNoProgramBusyBeforeTheyAreRefused) {
  // 31 layers of many copies of long lists of names, and one whose automaton has 2^12 states and more.
  std::vector<layers::Layer> layers;
  for (std::size_t i = 0; i < layers::kMaxLayers - 1; ++i) {
    std::string names;
    for (std::size_t j = 0; names.size() < 4000; ++j)
      names += "'n" + std::to_string((i * 7 + j) % layers::kMaxNames) + "'";
    layers.push_back({"a" + std::to_string(i), "C<.[" + names + "]>{31}L"});
  }
  layers.push_back({"last", "C.*D.{12}L"});
  const std::clock_t begin = std::clock();
  const absl::Status status = layers::check_layers(layers);
  EXPECT_EQ(std::string(status.message()).find("layer 'last' is too much"), 0u) << status;
  // It was minutes; a second or so is usual.
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 20);
}

}  // namespace
}  // namespace tessera::test::layers_check
