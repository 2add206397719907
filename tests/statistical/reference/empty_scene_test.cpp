// A scene without shapes and lights, by every algorithm: tables are empty, and nothing may be read from them.
#include <gtest/gtest.h>

#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "support/picture/phases.h"
#include "support/picture/render_image.h"
#include "wire/algorithm.h"

namespace tessera::test::empty_scene {  // apart from tests that are compiled with these
namespace {

TEST(EmptyScene, IsBlackOrRefused) {
  int rendered = 0;
  for (const wire::AlgorithmTraits& algorithm : wire::algorithms()) {
    SCOPED_TRACE(algorithm.name);
    const auto file = load_scene_text(
        absl::StrCat("camera { perspective { fov_degrees: 40 } } film { width: 24 height: 16 }",
                     " settings { integrator: '", algorithm.name, "' spp: 2 }"),
        {}, render::supported_isas().front());
    if (!file.ok()) {
      EXPECT_TRUE(absl::IsInvalidArgument(file.status())) << file.status();
      continue;
    }
    const MadePhases made = make_phases(*file);
    const client::Image image = render_image(*file, 0, made.prepared.get());
    ASSERT_NE(image.find("G"), nullptr);
    for (const float value : image.find("G")->values) EXPECT_EQ(value, 0);
    ++rendered;
  }
  EXPECT_GE(rendered, 5);
}

}  // namespace
}  // namespace tessera::test::empty_scene
