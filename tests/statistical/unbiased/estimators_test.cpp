// However light is looked for, and however rays are traced, the picture is one: each choice that a job may
// make, against the default, with random numbers of its own.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

/// A scene file without its film and settings, which PictureRequest brings.
std::string scene_text(const std::string& name, const std::string& without = "") {
  std::ifstream file("tests/statistical/unbiased/scenes/" + name + ".textproto");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  text.resize(text.find("\nfilm {") + 1);
  if (!without.empty()) {
    const std::size_t at = text.find(without);
    text.erase(at, text.find('\n', at) - at);
  }
  return text;
}

struct Scene {
  const char* name;
  const char* integrator;
  std::uint32_t max_depth;
};
constexpr Scene kEstimated[] = {
    {"lens", "path", 5}, {"lens", "volpath", 5}, {"media", "volpath", 8}, {"solids", "path", 4}};

Picture picture(const Scene& scene, const std::string& settings, const std::string& isa = "",
                const std::string& without = "") {
  PictureRequest request;
  request.scene = scene_text(scene.name, without);
  request.integrator = scene.integrator;
  request.max_depth = scene.max_depth;
  request.settings = settings;
  request.isa = isa;
  request.spp = 512;
  return measure_picture(request);
}

/// The picture by default, made once.
const Picture& default_picture(const Scene& scene, const std::string& without) {
  static std::map<std::string, Picture> pictures;
  Picture& known = pictures[std::string(scene.name) + scene.integrator + without];
  if (known.values.empty()) known = picture(scene, "", "", without);
  return known;
}

void expect_same_as_default(const std::string& settings, const std::string& isa = "",
                            const std::string& left_out = "") {
  for (const Scene& scene : kEstimated) {
    SCOPED_TRACE(std::string(scene.name) + " by " + scene.integrator);
    const bool has = scene_text(scene.name).find(left_out) != std::string::npos;
    const std::string without = has ? left_out : "";
    const Picture& reference = default_picture(scene, without);
    const Picture other = picture(scene, settings, isa, without);
    ASSERT_FALSE(reference.values.empty() || other.values.empty());
    // A scene that is dark, or too noisy to tell anything, would prove nothing.
    EXPECT_GT(reference.whole(1).mean, 0.05);
    EXPECT_LT(other.whole(1).error, 0.02 * other.whole(1).mean);
    expect_same(reference, other);
  }
}

TEST(Estimators, LightFoundByChanceAlone) {
  // Chance never finds a spot.
  expect_same_as_default("direct_light: DIRECT_LIGHT_BSDF", "", "lights { spot");
}

TEST(Estimators, LightsPickedByPower) { expect_same_as_default("light_selection: LIGHT_SELECTION_POWER"); }

TEST(Estimators, LightsPickedEvenly) { expect_same_as_default("light_selection: LIGHT_SELECTION_UNIFORM"); }

TEST(Estimators, LightsPickedByTree) { expect_same_as_default("light_selection: LIGHT_SELECTION_TREE"); }

TEST(Estimators, SingleRays) { expect_same_as_default("traversal: TRAVERSAL_SINGLE"); }

TEST(Estimators, HitsFoundWithoutEmbree) { expect_same_as_default("accelerator: ACCELERATOR_BVH_SAH"); }

TEST(Estimators, RobustIntersection) { expect_same_as_default("intersection: INTERSECTION_ROBUST"); }

TEST(Estimators, EveryInstructionSet) {
  const auto isas = render::supported_isas();
  if (isas.size() < 2) GTEST_SKIP() << "this machine has one";
  for (std::size_t i = 1; i < isas.size(); ++i) expect_same_as_default("", isas[i]);
}

}  // namespace
}  // namespace tessera::test
