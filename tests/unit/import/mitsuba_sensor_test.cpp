// Sensors, films, samplers and integrators of Mitsuba scenes.
#include <cmath>
#include <numbers>

#include "import/input/concat.h"
#include "unit/import/mitsuba_fixture.h"
#include "wire/algorithm.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::FloatEq;
using testing::HasSubstr;

class MitsubaSensor : public MitsubaTest {
 protected:
  v1::Scene sensor(const std::string& type, const std::string& inside) const {
    return succeed(import_xml("<scene version='3.0.0'><sensor type='" + type + "'>" + inside +
                              "</sensor></scene>"))
        .scene;
  }
  static std::string film(const std::string& inside) { return "<film type='hdrfilm'>" + inside + "</film>"; }
};

constexpr char kWide[] = "<integer name='width' value='400'/><integer name='height' value='200'/>";

TEST_F(MitsubaSensor, FieldOfViewIsThatOfTheAxisAskedFor) {
  // tan(fov_y / 2) is half of tan(fov_x / 2) where the film is twice as wide as high.
  const auto fov = [&](const std::string& more) {
    return sensor("perspective", more + film(kWide)).camera().perspective().fov_degrees();
  };
  const auto degrees = [](double tangent) {
    return static_cast<float>(2 * std::atan(tangent) * 180 / std::numbers::pi);
  };
  EXPECT_THAT(fov("<float name='fov' value='90'/>"), FloatEq(degrees(0.5)));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='y'/>"), FloatEq(90));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='smaller'/>"), FloatEq(90));
  EXPECT_THAT(fov("<float name='fov' value='90'/><string name='fov_axis' value='diagonal'/>"),
              FloatEq(degrees(1 / std::sqrt(5.0))));
  // 50 mm: half the diagonal of a 36 x 24 frame over the focal length is the tangent of half the diagonal
  // angle.
  EXPECT_THAT(fov(""), FloatEq(degrees(std::hypot(18.0, 12.0) / 50 / std::sqrt(5.0))));
}

TEST_F(MitsubaSensor, XPointsRightHere) {
  const v1::Scene scene = sensor("perspective",
                                 "<transform name='to_world'><lookat origin='1 2 3' target='1 2 4' "
                                 "up='0 1 0'/></transform>");
  EXPECT_THAT(elements_of(scene.camera().world_from_camera()),
              ElementsAre(-1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1));
  EXPECT_FLOAT_EQ(scene.camera().near_clip(), 0.01f);
  EXPECT_FLOAT_EQ(scene.camera().far_clip(), 10000);
}

TEST_F(MitsubaSensor, CropWindowsAndShiftedCentresMoveTheScreen) {
  const v1::Scene scene =
      sensor("perspective", "<float name='principal_point_offset_x' value='0.25'/>" +
                                film(std::string(kWide) +
                                     "<integer name='crop_offset_x' value='100'/><integer name='crop_width' "
                                     "value='200'/><integer name='crop_offset_y' value='150'/>"));
  EXPECT_EQ(scene.film().width(), 200u);
  EXPECT_EQ(scene.film().height(), 50u);
  // The screen is [-2, 2] x [-1, 1]. Columns 100 to 300 are [-1, 1], moved by a quarter of the width; rows
  // 150 to 200 are the lowest quarter.
  EXPECT_THAT(scene.camera().screen_window(), ElementsAre(0, 2, -1, -0.5f));
}

TEST_F(MitsubaSensor, ThinLensesFocus) {
  const v1::Camera camera = sensor("thinlens",
                                   "<float name='aperture_radius' value='.5'/>"
                                   "<float name='focus_distance' value='7'/>")
                                .camera();
  EXPECT_EQ(camera.perspective().lens_radius(), 0.5f);
  EXPECT_EQ(camera.perspective().focal_distance(), 7);
}

TEST_F(MitsubaSensor, OrthographicFilmsAreTwoUnitsWide) {
  const v1::Camera camera =
      sensor("orthographic", "<transform name='to_world'><scale x='10' y='10'/></transform>" + film(kWide))
          .camera();
  ASSERT_TRUE(camera.has_orthographic());
  EXPECT_THAT(camera.screen_window(), ElementsAre(-10, 10, -5, 5));
  EXPECT_THAT(elements_of(camera.world_from_camera()),
              ElementsAre(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
}

TEST_F(MitsubaSensor, FiltersHaveMitsubasWidths) {
  const auto filter = [&](const std::string& rfilter) {
    return sensor("perspective", film(rfilter)).film().filter();
  };
  EXPECT_EQ(filter("").kind(), v1::PixelFilter::GAUSSIAN);
  EXPECT_EQ(filter("").radius_x(), 2);
  EXPECT_EQ(filter("<rfilter type='gaussian'><float name='stddev' value='.25'/></rfilter>").radius_y(), 1);
  EXPECT_EQ(filter("<rfilter type='box'/>").radius_x(), 0.5f);
  EXPECT_EQ(filter("<rfilter type='tent'/>").radius_x(), 1);
  EXPECT_EQ(filter("<rfilter type='catmullrom'/>").c(), 0.5f);
  EXPECT_EQ(filter("<rfilter type='lanczos'/>").tau(), 3);
}

TEST_F(MitsubaSensor, IntegratorsCountSegments) {
  const auto settings = [&](const std::string& integrator) { return scene(integrator).scene.settings(); };
  const std::string two = "<integer name='max_depth' value='2'/>";
  EXPECT_EQ(settings("").integrator(), "path");
  EXPECT_EQ(settings("").max_depth(), wire::kMaxDepth);
  EXPECT_EQ(
      settings("<integrator type='moment'><integrator type='path'>" + two + "</integrator></integrator>")
          .max_depth(),
      1u);
  EXPECT_EQ(settings("<integrator type='direct'/>").integrator(), "direct");
  EXPECT_EQ(settings("<integrator type='volpathmis'>" + two + "</integrator>").integrator(), "volpath");
  EXPECT_EQ(settings("<integrator type='ptracer'/>").integrator(), "light");
  EXPECT_THAT(
      warnings_of(scene("<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>")),
      HasSubstr("hide_emitters is not supported"));
}

TEST_F(MitsubaSensor, IntegratorsOfVersion06HaveCounterparts) {
  for (const char* name : {"bdpt", "pssmlt", "mlt", "erpt", "photonmapper", "ppm", "sppm", "irrcache", "ao",
                           "volpath_simple", "prb", "depth", "whitted"}) {
    const ImportedScene read =
        scene(concat("<integrator type='", name, "'><integer name='max_depth' value='4'/></integrator>"));
    EXPECT_NE(wire::find_algorithm(read.scene.settings().integrator()), nullptr) << name;
    EXPECT_EQ(read.scene.settings().max_depth(), 3u) << name;
  }
  EXPECT_EQ(scene("<integrator type='irrcache'><integrator type='direct'/></integrator>")
                .scene.settings()
                .max_depth(),
            wire::kMaxDepth);
}

TEST_F(MitsubaSensor, PhotonsAreThoseOfTheFile) {
  const ImportedScene progressive = scene(
      "<integrator type='sppm'><integer name='photon_count' value='5000'/><float name='initial_radius' "
      "value='.25'/><float name='alpha' value='.7'/></integrator>");
  EXPECT_EQ(warnings_of(progressive), "");
  EXPECT_EQ(progressive.scene.settings().photon().photons(), 5000u);
  EXPECT_EQ(progressive.scene.settings().photon().radius(), 0.25);
  const ImportedScene classic = scene(
      "<integrator type='photonmapper'><integer name='global_photons' value='6000'/><float "
      "name='global_lookup_radius' value='.05'/></integrator>");
  EXPECT_THAT(warnings_of(classic), HasSubstr("lookup radii"));
  EXPECT_EQ(classic.scene.settings().photon().photons(), 6000u);
  EXPECT_FALSE(classic.scene.settings().photon().has_radius());
}

TEST_F(MitsubaSensor, SamplersSayHowManySamplesOnly) {
  const auto settings = [&](const std::string& type) {
    return sensor("perspective",
                  "<sampler type='" + type + "'><integer name='sample_count' value='9'/></sampler>")
        .settings();
  };
  for (const char* type : {"independent", "multijitter"}) {
    EXPECT_EQ(settings(type).sampler(), v1::SAMPLER_UNSPECIFIED) << type;
    EXPECT_EQ(settings(type).spp(), 9u) << type;
  }
}

}  // namespace
}  // namespace tessera::client
