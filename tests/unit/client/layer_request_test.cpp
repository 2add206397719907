#include "command/jobs/layer_request.h"

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "command/jobs/job_settings.h"

namespace tessera::client {
namespace {

using ::testing::HasSubstr;

v1::Scene scene_with_lights() {
  v1::Scene scene;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(
      R"(film { width: 8 height: 8 }
         shapes { name: "lamp 1" area_light { group: "key" } material: "gold" }
         shapes { name: "lamp 2" area_light { group: "key" } }
         objects { name: "tree" shapes { name: "leaf" } }
         lights { name: "sky's" infinite {} }
         lights { point {} }
         settings { layers { name: "own" expression: "LDE" } })",
      &scene));
  return scene;
}

/// "name=expression" of each.
std::vector<std::string> lines(const absl::StatusOr<std::vector<layers::Layer>>& layers) {
  EXPECT_TRUE(layers.ok()) << layers.status();
  std::vector<std::string> result;
  if (!layers.ok()) return result;
  for (const layers::Layer& layer : *layers) result.push_back(layer.name + "=" + layer.expression);
  EXPECT_TRUE(layers::check_layers(*layers).ok()) << layers::check_layers(*layers);
  return result;
}

LayerRequest asked_of(const std::vector<std::string>& words) {
  LayerRequest asked;
  for (const std::string& word : words) {
    const auto taken = take_layer_word(word, asked);
    EXPECT_TRUE(taken.ok() && *taken) << word;
  }
  return asked;
}

LayerRequest one_layer(const std::string& expression) {
  LayerRequest asked;
  asked.layers = std::vector<layers::Layer>{{"a", expression}};
  return asked;
}

using Lines = std::vector<std::string>;

TEST(LayerRequest, OptionsReplaceTheScenesLayers) {
  EXPECT_EQ(lines(layers_of_job({}, scene_with_lights(), 5)), Lines{"own=LDE"});
  EXPECT_EQ(lines(layers_of_job(one_layer("LE"), scene_with_lights(), 5)), Lines{"a=LE"});
}

TEST(LayerRequest, TheLastBounceTakesTheRest) {
  EXPECT_EQ(lines(layers_of_job(asked_of({"bounce0..bounce2", "emission"}), scene_with_lights(), 5)),
            (Lines{"own=LDE", "bounce0=LE", "bounce1=L.{1}E", "bounce2=L.{2,}E", "emission=LE"}));
}

TEST(LayerRequest, LightsAreKnownByGroupOrName) {
  v1::Scene scene = scene_with_lights();
  scene.clear_settings();
  EXPECT_EQ(lines(layers_of_job(asked_of({"lights"}), scene, 5)),
            (Lines{"light.key=C.*<L.'key'>", "light.sky_s=C.*<L.\"sky's\">",
                   "light.rest=C.*<L.[^'key'\"sky's\"]>"}));
  scene.clear_shapes();
  scene.clear_lights();
  EXPECT_EQ(lines(layers_of_job(asked_of({"lights"}), scene, 5)), Lines{"light.rest=C.*L"});
  for (int i = 0; i < 32; ++i) scene.add_lights()->set_name("a" + std::to_string(i));
  EXPECT_THAT(std::string(layers_of_job(asked_of({"lights"}), scene, 5).status().message()),
              HasSubstr("32 names of lights; at most 31"));
}

TEST(LayerRequest, StrategiesAreThoseOfTheJobsPaths) {
  v1::Scene scene = scene_with_lights();
  scene.clear_settings();
  EXPECT_EQ(lines(layers_of_job(asked_of({"strategies"}), scene, 1)),
            (Lines{"s0t2=s0t2", "s0t3=s0t3", "s1t2=s1t2", "s2t1=s2t1"}));
  EXPECT_EQ(lines(layers_of_job(asked_of({"unweighted-strategies", "shadow"}), scene, 1)),
            (Lines{"shadow=shadow:L(D|G|V)S*E", "unweighted.s0t2=unweighted s0t2",
                   "unweighted.s0t3=unweighted s0t3", "unweighted.s1t2=unweighted s1t2",
                   "unweighted.s2t1=unweighted s2t1"}));
  EXPECT_EQ(lines(layers_of_job(asked_of({"strategies"}), scene, 5)).size(), 26u);
  const Lines longer = lines(layers_of_job(asked_of({"strategies"}), scene, 6));
  EXPECT_EQ(longer.size(), 27u);
  EXPECT_EQ(longer.back(), "longer=d6+");
}

TEST(LayerRequest, NamesMustBeThere) {
  const auto of = [](const char* expression) {
    return std::string(layers_of_job(one_layer(expression), scene_with_lights(), 5).status().message());
  };
  for (const char* known : {"key", "lamp 2", "gold", "tree", "leaf"})
    EXPECT_EQ(of(("C.*<..'" + std::string(known) + "'>L").c_str()), "");
  EXPECT_EQ(of("C<RD'treee'>L"),
            "layers name 'treee', but nothing in the scene has this name; did you mean 'tree'?");
}

TEST(LayerRequest, OtherWordsAreNotTheirs) {
  LayerRequest asked;
  EXPECT_FALSE(*take_layer_word("albedo", asked));
  for (const char* wrong : {"bounce", "bounce1..bounce3", "bounce0", "bounce0..bounce32", "bounce0..3",
                            "bounce0..", "bounce0..bounce-1"}) {
    EXPECT_THAT(std::string(take_layer_word(wrong, asked).status().message()),
                HasSubstr("bounce0..bounceN with N from 1 to 31 was expected"))
        << wrong;
  }
  EXPECT_FALSE(asked.any());
}

TEST(LayerRequest, GoIntoTheJobAndAreCheckedThere) {
  ImportedScene imported;
  imported.scene = scene_with_lights();
  JobSettings request;
  request.layers = asked_of({"bounce0..bounce1"});
  const auto job = prepare_job(request, imported, "");
  ASSERT_TRUE(job.ok()) << job.status();
  ASSERT_EQ((*job)->spec.view().layers_size(), 3);
  EXPECT_EQ((*job)->spec.view().layers(2).name(), "bounce1");
  request.layers = one_layer("LXE");
  const auto wrong = prepare_job(request, imported, "");
  EXPECT_EQ(wrong.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(wrong.status().message()), HasSubstr("layer 'a': column 2: 'X' is unknown"));
}

}  // namespace
}  // namespace tessera::client
