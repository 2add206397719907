// Integrators of other programs and what renders in their place.
#include "import/input/integrator_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "wire/algorithm.h"

namespace tessera::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr IntegratorName kNames[] = {
    {"tracing", "path", "path"}, {"lightpath", "light", "path"}, {"teleport", "teleporter", "volpath"}};

TEST(IntegratorChoice, NamesAreTheirsOrOurs) {
  ASSERT_TRUE(find_integrator(kNames, "lightpath").has_value());
  EXPECT_EQ(find_integrator(kNames, "lightpath")->ours, "light");
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    const auto own = find_integrator(kNames, algorithm.name);
    ASSERT_TRUE(own.has_value()) << algorithm.name;
    EXPECT_EQ(own->ours, algorithm.name);
  }
  EXPECT_FALSE(find_integrator(kNames, "magic").has_value());
  EXPECT_FALSE(find_integrator(kNames, "").has_value());
  EXPECT_EQ(list_of(kNames), "tracing, lightpath, teleport");
}

TEST(IntegratorChoice, WhatDoesNotExistIsRenderedByAnotherThatIsNamed) {
  const IntegratorChoice choice = choose_integrator(kNames[2], {});
  EXPECT_EQ(choice.name, "volpath");
  EXPECT_EQ(
      choice.warning,
      "integrator \"teleport\" is 'teleporter', which does not exist here: 'volpath' renders the scene");
  EXPECT_EQ(choose_integrator(kNames[0], {}).warning, "");
}

TEST(IntegratorChoice, WhatCannotRenderTheSceneIsReplaced) {
  v1::Scene scene;
  EXPECT_EQ(choose_integrator(kNames[1], scene).name, "light");
  v1::Scene lit;
  lit.add_lights()->mutable_infinite()->add_portal();
  EXPECT_EQ(choose_integrator(kNames[1], lit).name, "path");
  EXPECT_THAT(choose_integrator(kNames[1], lit).warning,
              AllOf(HasSubstr("'light', which cannot begin at a portal"), HasSubstr("'path' renders")));

  v1::Scene smoke;
  smoke.add_media();
  EXPECT_EQ(choose_integrator(kNames[1], smoke).name, "light") << "theirs sees no media, either";
  EXPECT_THAT(choose_integrator({"bidir", "light", "volpath", true}, smoke).warning,
              HasSubstr("sees no media: 'volpath' renders"));
}

}  // namespace
}  // namespace tessera::client
