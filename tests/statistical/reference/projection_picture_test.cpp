// Pictures of projections by integrators that join points of the scene to the camera, against path tracing.
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test {
namespace {

constexpr const char* kWideFilter = "kind: TRIANGLE radius_x: 4 radius_y: 4";

struct ProjectionCase {
  const char* name;
  const char* camera;
  const char* filter = "";
};

/// An ST map that squeezes and swirls what a camera sees.
std::string map_of_places() {
  constexpr int kSide = 32;
  std::string pfm = absl::StrCat("PF\n", kSide, " ", kSide, "\n-1.0\n");
  for (int row = 0; row < kSide; ++row) {  // from the bottom
    for (int column = 0; column < kSide; ++column) {
      const float x = (static_cast<float>(column) + 0.5f) / kSide,
                  y = (static_cast<float>(row) + 0.5f) / kSide;
      const float texel[3] = {x + 0.1f * y * (1 - y), 0.1f + 0.8f * y + 0.1f * x * x, 0};
      pfm.append(reinterpret_cast<const char*>(texel), sizeof(texel));
    }
  }
  return pfm;
}

Pictures projection_pictures(const ProjectionCase& test, const std::string& integrator) {
  PictureRequest request;
  request.scene = absl::StrCat(things(kDiffuse), kLamp, camera(test.camera));
  request.filter = test.filter;
  request.integrator = integrator;
  request.blobs = light_blobs();
  request.blobs["places"] = map_of_places();
  request.spp = samples_of_form(1024);
  request.max_depth = 3;
  return measure_pictures(request);
}

class ProjectionPicture : public testing::TestWithParam<ProjectionCase> {};

TEST_P(ProjectionPicture, IsThatOfPathTracing) {
  const Pictures path = projection_pictures(GetParam(), "path");
  for (const char* const integrator : {"light", "bdpt", "vcm", "mlt"}) {
    SCOPED_TRACE(integrator);
    const Pictures joined = projection_pictures(GetParam(), integrator);
    // Merging blurs.
    const double relative = std::string(integrator) == "vcm" ? 0.01 : 1e-3;
    expect_same(path, joined, relative);
    // A difference of a tenth would be found.
    Pictures brighter = joined;
    for (Picture& picture : brighter)
      for (Picture::Value& value : picture.values) value.mean *= 1.1;
    EXPECT_LT(p_value_of(differences_of(path, brighter, relative)), 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cameras, ProjectionPicture,
    testing::Values(
        ProjectionCase{
            "Tilted",
            "perspective { fov_degrees: 45 lens_radius: 0.4 focal_distance: 4.5 tilt { x_degrees: -12 "
            "y_degrees: 5 focal_length: 1.2 } }"},
        ProjectionCase{
            "Distorted",
            "perspective { fov_degrees: 45 lens_radius: 0.1 focal_distance: 4 } distortion { opencv { k1: "
            "-0.4 k2: "
            "0.2 p1: 0.02 p2: -0.01 s1: 0.02 tau_x_radians: 0.1 } }",
            kWideFilter},
        ProjectionCase{"DistortedFisheye",
                       "fisheye { fov_degrees: 120 } distortion { opencv_fisheye { k1: 0.1 k2: -0.02 } }"},
        ProjectionCase{"Map",
                       "perspective { fov_degrees: 45 } distortion { map { image { digest: 'places' } } }",
                       kWideFilter},
        ProjectionCase{"Viewpoint",
                       "perspective { fov_degrees: 45 } viewpoint { x: 0.8 y: 0.3 convergence_distance: 3 }"},
        ProjectionCase{"EqualArea", "spherical { mapping: EQUAL_AREA_CYLINDRICAL }", kWideFilter},
        ProjectionCase{"Panorama", "panorama { }", kWideFilter},
        ProjectionCase{
            "LeftEye",
            "panorama { longitude_min_degrees: -70 longitude_max_degrees: 90 latitude_min_degrees: -90 "
            "latitude_max_degrees: 40 } viewpoint { x: -0.8 convergence_distance: 3 "
            "pole_merge_from_degrees: 30 "
            "pole_merge_to_degrees: 80 }"},
        ProjectionCase{"PanoramaLens", "panorama { lens_radius: 0.5 focal_distance: 4 }", kWideFilter},
        // The lower pole looks at the floor.
        ProjectionCase{
            "PanoramaBlades",
            "panorama { longitude_min_degrees: -90 longitude_max_degrees: 90 latitude_min_degrees: -90 "
            "latitude_max_degrees: 20 lens_radius: 0.7 focal_distance: 3 aperture { blades: 3 ratio: "
            "1.5 } }"},
        ProjectionCase{
            "PanoramaPicture",
            "panorama { longitude_min_degrees: -60 longitude_max_degrees: 60 latitude_min_degrees: -60 "
            "latitude_max_degrees: 30 lens_radius: 0.7 focal_distance: 6 aperture { image { digest: "
            "'places' path: 'places.pfm' } } }"},
        ProjectionCase{"CubeMap", "cube_map { layout: FRONT equiangular: true }", kWideFilter}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tessera::test
