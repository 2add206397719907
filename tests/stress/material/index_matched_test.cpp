// Glass of the index of what surrounds it is no glass.
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

/// A floor and a ball, a lamp with an extent and a dim sky; and, before, around and above the ball, panes and
/// a ball of glass.
std::string scene(const std::string& glass) {
  std::string text = R"(
    camera { perspective { fov_degrees: 45 }
      world_from_camera { elements: [1,0,0,0, 0,0.5448,0.8386,-4, 0,0.8386,-0.5448,3, 0,0,0,1] } }
    materials { name: 'floor' diffuse { reflectance { constant { rgb { r: 0.6 g: 0.5 b: 0.4 } } } } }
    shapes { disk { radius: 3 } material: 'floor' }
    shapes { sphere { radius: 0.6 } material: 'floor'
      world_from_object { elements: [1,0,0,-0.6, 0,1,0,0, 0,0,1,0.7, 0,0,0,1] } }
    shapes { disk { radius: 0.7 } area_light { radiance { constant: 3 } two_sided: true }
      world_from_object { elements: [1,0,0,0.3, 0,1,0,-0.4, 0,0,1,2.5, 0,0,0,1] } }
    lights { infinite { radiance { rgb { r: 0.1 g: 0.2 b: 0.3 } } } } )";
  if (glass.empty()) return text;
  return absl::StrCat(text, "materials { name: 'glass' ", glass, R"( }
    shapes { sphere { radius: 0.9 } material: 'glass'
      world_from_object { elements: [1,0,0,-0.6, 0,1,0,0, 0,0,1,0.95, 0,0,0,1] } }
    shapes { disk { radius: 1.5 } material: 'glass'
      world_from_object { elements: [1,0,0,0.3, 0,1,0,-0.4, 0,0,1,2.2, 0,0,0,1] } }
    shapes { disk { radius: 0.6 } material: 'glass'
      world_from_object { elements: [1,0,0,0.6, 0,0,-1,-1.5, 0,1,0,0.8, 0,0,0,1] } } )");
}

/// So many scattering events that passing the glass takes none from the floor's light.
Picture measure(const std::string& glass) {
  PictureRequest request;
  request.scene = scene(glass);
  request.max_depth = 100;
  request.spp = 2048;
  return measure_picture(request);
}

TEST(IndexMatchedGlass, IsNoGlass) {
  const Picture without = measure("");
  const std::string rough = "roughness { u { constant: 0.4 } v { constant: 0.4 } }",
                    turned = "roughness { u { constant: 0.1 } v { constant: 0.7 } }";
  for (const char* eta : {"1", "1.000001"}) {
    for (const std::string& glass : {absl::StrCat("dielectric { eta { constant: ", eta, " } }"),
                                     absl::StrCat("dielectric { eta { constant: ", eta, " } ", rough, " }"),
                                     absl::StrCat("dielectric { eta { constant: ", eta, " } ", turned, " }"),
                                     absl::StrCat("thin_dielectric { eta { constant: ", eta, " } }")}) {
      SCOPED_TRACE(glass);
      expect_same(without, measure(glass), 5e-4);
    }
  }
  SCOPED_TRACE("interface");
  expect_same(without, measure("interface { }"), 5e-4);
}

}  // namespace
}  // namespace tessera::test
