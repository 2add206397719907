// Sensors, films, samplers and integrators of Mitsuba scenes.
#include <cmath>
#include <numbers>

#include "import/input/concat.h"
#include "spectra/light/daylight.h"
#include "spectra/sensor/sensor_response.h"
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

constexpr char kShutter[] = "<float name='shutter_open' value='1'/><float name='shutter_close' value='3'/>";

std::string sliding(const std::string& keys) { return "<animation name='to_world'>" + keys + "</animation>"; }
std::string at(const std::string& time, const std::string& x) {
  return "<transform time='" + time + "'><translate x='" + x + "'/></transform>";
}

TEST_F(MitsubaSensor, AnimationsAreCutToTheShutter) {
  const v1::Scene scene =
      succeed(import_xml(
                  "<scene version='0.6.0'><sensor type='perspective'>" +
                  std::string("<float name='shutterOpen' value='1'/><float name='shutterClose' value='3'/>") +
                  "<animation name='toWorld'>" + at("0", "0") + at("2", "4") + at("4", "4") +
                  "</animation></sensor><shape type='sphere'><point name='center' x='0' y='1' z='0'/>" +
                  "<animation name='toWorld'>" + at("1.5", "1") + at("2.5", "3") +
                  "</animation></shape></scene>"))
          .scene;
  EXPECT_EQ(scene.camera().world_from_camera().elements(3), 2);
  ASSERT_EQ(scene.camera().motion_size(), 2);
  EXPECT_EQ(scene.camera().motion(0).time(), 0.5);
  EXPECT_THAT(elements_of(scene.camera().motion(0).place()),
              ElementsAre(-1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1));
  EXPECT_EQ(scene.camera().motion(1).time(), 1);
  const v1::Shape& ball = scene.shapes(0);
  EXPECT_THAT(elements_of(ball.world_from_object()),
              ElementsAre(1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1));
  ASSERT_EQ(ball.motion_size(), 3);
  EXPECT_EQ(ball.motion(0).time(), 0.25);
  EXPECT_EQ(ball.motion(1).time(), 0.75);
  EXPECT_THAT(elements_of(ball.motion(1).place()),
              ElementsAre(1, 0, 0, 3, 0, 1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1));
}

TEST_F(MitsubaSensor, EmittersGoThroughAllTheirPlaces) {
  const std::string way = sliding(at("1", "1") + at("2", "0.5") + at("3", "5"));
  const v1::Scene scene =
      succeed(import_xml("<scene version='3.0.0'><sensor type='perspective'>" + std::string(kShutter) +
                         "</sensor><emitter type='point'>" + way + "</emitter><emitter type='spot'>" + way +
                         "</emitter><emitter type='directional'>" + way +
                         "</emitter><emitter type='projector'>" + way + "</emitter></scene>"))
          .scene;
  EXPECT_EQ(scene.lights(0).point().position().x(), 1);
  EXPECT_EQ(scene.lights(1).spot().target().x(), 1);
  for (const v1::Light& light : scene.lights()) {
    ASSERT_EQ(light.motion_size(), 2);
    EXPECT_EQ(light.motion(0).time(), 0.5);
    EXPECT_EQ(light.motion(1).time(), 1);
    // Those with a matrix are where they are; points are moved from where they were.
    const double from = light.has_projection() ? 0 : 1;
    EXPECT_EQ(light.motion(0).place().elements(3), 0.5 - from);
    EXPECT_EQ(light.motion(1).place().elements(3), 5 - from);
  }
}

TEST_F(MitsubaSensor, WithoutAShutterAnimationsStand) {
  const v1::Scene scene = sensor("perspective", sliding(at("0", "1") + at("1", "3")));
  EXPECT_EQ(scene.camera().world_from_camera().elements(3), 1);
  EXPECT_EQ(scene.camera().motion_size(), 0);
}

TEST_F(MitsubaSensor, AnimationsThatAreWrongAreRefused) {
  const auto refusal = [&](const std::string& keys) {
    const auto result = import_xml("<scene version='3.0.0'><sensor type='perspective'>" +
                                   std::string(kShutter) + sliding(keys) + "</sensor></scene>");
    EXPECT_FALSE(result.ok()) << keys;
    return std::string(result.status().message());
  };
  EXPECT_THAT(refusal(""), HasSubstr("an <animation> has a <transform> at least"));
  EXPECT_THAT(refusal(at("1", "0") + at("1", "2")),
              HasSubstr("the time 1 is not after that of the transform before"));
  EXPECT_THAT(refusal(at("soon", "0")), HasSubstr("found \"soon\""));
  EXPECT_THAT(refusal("<float name='x' value='1'/>"), HasSubstr("<float> cannot stand inside <animation>"));
  EXPECT_THAT(refusal(at("1", "0") + "<transform time='2'><scale x='0'/></transform>"),
              HasSubstr("its transform at time 2 is singular"));
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

TEST_F(MitsubaSensor, BatchesAreViewsSideBySide) {
  const std::string lens =
      "<float name='aperture_radius' value='.5'/><float name='focus_distance' value='7'/>";
  const ImportedScene read = succeed(import_xml(
      "<scene version='3.0.0'><sensor type='batch'><float name='shutter_close' value='2'/>" +
      film("<integer name='width' value='600'/><integer name='height' value='100'/>") +
      "<sampler type='independent'><integer name='sample_count' value='9'/></sampler>"
      // The film, the sampler and the shutter of its own do not count.
      "<sensor type='perspective' id='front'><float name='fov' value='90'/>" +
      film(kWide) + "<sampler type='independent'><integer name='sample_count' value='5'/></sampler>" +
      "<float name='shutter_close' value='1'/>" + sliding(at("0", "0") + at("2", "4")) +
      "</sensor><sensor type='thinlens' name='aside'>" + lens + "<float name='near_clip' value='2'/>" +
      "<transform name='to_world'><translate x='5'/></transform></sensor>"
      "<sensor type='orthographic'/></sensor></scene>"));
  EXPECT_EQ(warnings_of(read), "");
  const v1::Scene& scene = read.scene;
  EXPECT_EQ(scene.film().width(), 200u);
  EXPECT_EQ(scene.film().height(), 100u);
  EXPECT_EQ(scene.settings().spp(), 9u);
  ASSERT_EQ(scene.views_size(), 2);
  // The tangent of half the angle across the width is 1; the height is half of that.
  EXPECT_THAT(scene.camera().perspective().fov_degrees(),
              FloatEq(static_cast<float>(2 * std::atan(0.5) * 180 / std::numbers::pi)));
  EXPECT_THAT(scene.camera().screen_window(), ElementsAre(-2, 2, -1, 1));
  EXPECT_EQ(scene.camera().view_name(), "front");
  ASSERT_EQ(scene.camera().motion_size(), 1);
  EXPECT_EQ(scene.camera().motion(0).place().elements(3), 4);
  EXPECT_EQ(scene.views(0).view_name(), "aside");
  EXPECT_EQ(scene.views(0).perspective().lens_radius(), 0.5f);
  EXPECT_EQ(scene.views(0).near_clip(), 2);
  EXPECT_EQ(scene.views(0).world_from_camera().elements(3), 5);
  EXPECT_TRUE(scene.views(1).has_orthographic());
  EXPECT_EQ(scene.views(1).view_name(), "");
}

TEST_F(MitsubaSensor, BatchesThatDoNotFitTheirFilmAreRefused) {
  const auto refusal = [&](const std::string& inside) {
    return error_of(
        import_xml("<scene version='3.0.0'><sensor type='batch'>\n" + inside + "</sensor></scene>"));
  };
  const std::string two = "<sensor type='perspective'/><sensor type='perspective'/>";
  EXPECT_THAT(refusal(""), HasSubstr("expected at least one <sensor> within it"));
  EXPECT_THAT(refusal(film("<integer name='width' value='401'/>") + two),
              HasSubstr("the width of its film, 401, is not a multiple of its number of sensors, 2"));
  EXPECT_THAT(refusal(film(std::string(kWide) + "<integer name='crop_width' value='100'/>") + two),
              HasSubstr("a crop window of a film that several sensors share"));
  EXPECT_THAT(refusal("<sensor type='perspective'/>\n<sensor type='irradiancemeter'/>"),
              testing::AllOf(HasSubstr("scene.xml:3"),
                             HasSubstr("sensor \"irradiancemeter\" is not supported: expected perspective")));
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

TEST_F(MitsubaSensor, ResponseFunctionsAreTheFilmsOwnSensor) {
  const auto film_of = [&](const std::string& bands) {
    return succeed(import_xml("<scene version='3.0.0'><sensor type='perspective'><film type='specfilm'>" +
                              bands + "</film></sensor></scene>"));
  };
  const ImportedScene three = film_of(
      "<spectrum name='b' value='400:0, 450:1, 500:0'/><spectrum name='r' value='550:0, 600:1, 650:0'/>"
      "<spectrum name='g' value='500:0, 550:2, 600:0'/>");
  EXPECT_EQ(warnings_of(three), "");
  EXPECT_EQ(three.scene.settings().color(), v1::COLOR_SPECTRAL);
  EXPECT_EQ(three.scene.settings().sensor(), "film");
  EXPECT_EQ(three.scene.settings().white_balance(), "none");
  ASSERT_EQ(three.scene.film().sensitivities_size(), 3);
  EXPECT_THAT(three.scene.film().sensitivities(0).wavelengths_nm(), ElementsAre(550, 600, 650));
  EXPECT_THAT(three.scene.film().sensitivities(1).values(), ElementsAre(0, 2, 0));
  EXPECT_THAT(three.scene.film().sensitivities(2).wavelengths_nm(), ElementsAre(400, 450, 500));
  // A channel is the integral of radiance times its function: of daylight of luminance 1, what the sensor of
  // the job says without exposure, times that.
  const std::vector<spectra::Curve> curves = {
      {{550, 600, 650}, {0, 1, 0}}, {{500, 550, 600}, {0, 2, 0}}, {{400, 450, 500}, {0, 1, 0}}};
  const auto response =
      spectra::sensor_response(*spectra::parse_sensor("film"), std::nullopt, spectra::kRec709, curves);
  ASSERT_TRUE(response.ok());
  const spectra::Triple seen = spectra::seen(*response, spectra::unit_d65());
  for (std::size_t c = 0; c < 3; ++c) {
    double integral = 0;
    constexpr double kStepNm = 0.01;
    for (double nm = 400; nm < 650; nm += kStepNm) {
      const spectra::Curve& curve = curves[c];
      if (nm < curve.nm.front() || nm > curve.nm.back()) continue;
      integral += kStepNm * curve.at(nm) * spectra::unit_d65().at(nm);
    }
    EXPECT_NEAR(seen[c] * three.scene.film().exposure(), integral, 1e-3 * integral) << c;
  }
  const ImportedScene one =
      film_of("<texture name='all' type='uniform'><float name='value' value='0.5'/></texture>");
  ASSERT_EQ(one.scene.film().sensitivities_size(), 1);
  EXPECT_THAT(one.scene.film().sensitivities(0).wavelengths_nm(), ElementsAre(360, 830));
  const ImportedScene two =
      film_of("<spectrum name='a' value='500:1, 600:1'/><spectrum name='b' value='400:1, 500:1'/>");
  EXPECT_EQ(two.scene.film().sensitivities_size(), 0);
  EXPECT_EQ(two.scene.settings().color(), v1::COLOR_SPECTRAL);
  EXPECT_THAT(warnings_of(two), HasSubstr("film \"specfilm\" has 2 spectra, and a sensor one or three"));
}

TEST_F(MitsubaSensor, AResponseOfTheSensorIsAllThatItSees) {
  const std::string srf = "<spectrum name='srf' value='500:0, 550:1, 600:0'/>";
  const ImportedScene read =
      succeed(import_xml("<scene version='3.0.0'><sensor type='perspective'>" + srf + "</sensor></scene>"));
  ASSERT_EQ(read.scene.film().sensitivities_size(), 1);
  EXPECT_EQ(read.scene.settings().sensor(), "film");
  EXPECT_THAT(warnings_of(read), HasSubstr("parameter \"srf\" of sensor \"perspective\""));
}

TEST_F(MitsubaSensor, FaultsOfResponsesAreToldWhereTheyStandAllAtOnce) {
  const auto told = [&](const std::string& inside) {
    return error_of(
        import_xml("<scene version='3.0.0'><sensor type='perspective'>\n" + inside + "</sensor></scene>"));
  };
  const std::string message = told(
      "<film type='specfilm'>\n"
      "<texture name='dark' type='irregular'><string name='wavelengths' value='400, 500'/>"
      "<string name='values' value='0, 0'/></texture>\n"
      "<texture name='picture' type='checkerboard'/>\n<rgb name='red' value='1, 0, 0'/></film>\n");
  EXPECT_THAT(message, HasSubstr("scene.xml:3"));
  EXPECT_THAT(message, HasSubstr("it sees nothing of daylight from 300 to 1000 nm"));
  EXPECT_THAT(message, HasSubstr("scene.xml:4"));
  EXPECT_THAT(message, HasSubstr("expected a spectrum"));
  EXPECT_THAT(told("<film type='specfilm'/>"), HasSubstr("scene.xml:2"));
  EXPECT_THAT(told("<film type='specfilm'><spectrum name='a' value='500:1, 600:1'/></film>\n"
                   "<spectrum name='srf' value='500:1, 600:1'/>"),
              HasSubstr("its film has response functions already"));
  EXPECT_THAT(told("<film type='specfilm'><spectrum name='a' value='600:1, 500:1'/></film>"),
              HasSubstr("must ascend"));
}

TEST_F(MitsubaSensor, PixelFormatsOtherThanRgbAreWarnedOf) {
  const auto warnings = [&](const std::string& format) {
    return warnings_of(succeed(import_xml("<scene version='3.0.0'><sensor type='perspective'>" +
                                          film("<string name='pixel_format' value='" + format + "'/>") +
                                          "</sensor></scene>")));
  };
  EXPECT_EQ(warnings("rgba"), "");
  EXPECT_THAT(warnings("xyz"), HasSubstr("pixel_format \"xyz\" is not supported"));
  EXPECT_THAT(warnings("luminanc"), HasSubstr("did you mean 'luminance'?"));
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
