// Meaning of pbrt directives for camera, film and settings, and of what moves while the shutter is open.
#include <algorithm>
#include <numbers>
#include <vector>

#include "images/image_blob.h"
#include "import/input/concat.h"
#include "unit/import/import_fixture.h"
#include "wire/algorithm.h"

namespace tessera::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class PbrtCamera : public ImportTest {};

TEST_F(PbrtCamera, DefaultsAreThoseOfPbrt) {
  const ImportedScene scene = world("");
  EXPECT_EQ(scene.scene.film().width(), 1280u);
  EXPECT_EQ(scene.scene.film().height(), 720u);
  EXPECT_EQ(scene.scene.film().filter().kind(), v1::PixelFilter::GAUSSIAN);
  EXPECT_FLOAT_EQ(scene.scene.film().filter().radius_x(), 1.5f);
  EXPECT_FLOAT_EQ(scene.scene.film().filter().sigma(), 0.5f);
  EXPECT_FALSE(scene.scene.film().has_exposure());
  EXPECT_FLOAT_EQ(scene.scene.camera().perspective().fov_degrees(), 90);
  EXPECT_EQ(scene.scene.settings().sampler(), v1::SAMPLER_UNSPECIFIED);
  EXPECT_EQ(scene.scene.settings().spp(), 16u);
  EXPECT_EQ(scene.scene.settings().max_depth(), 5u);
  EXPECT_EQ(scene.scene.name(), "scene");
  EXPECT_EQ(warnings_of(scene), "");
}

TEST_F(PbrtCamera, CameraStandsWhereTheTransformPutsIt) {
  const auto result = import_text(
      "Scale -1 1 1 LookAt 1 2 3  1 2 10  0 1 0\n"
      "Camera \"perspective\" \"float fov\" 40 \"float lensradius\" .1 \"float focaldistance\" 7\n"
      "  \"float shutteropen\" 0 \"float shutterclose\" [ .5 ]\n"
      "Film \"rgb\" \"integer xresolution\" 40 \"integer yresolution\" [ 30 ] \"float iso\" 400 \"string "
      "filename\" "
      "\"a b.exr\"\n"
      "PixelFilter \"sinc\" Sampler \"independent\" \"integer pixelsamples\" 9 \"integer seed\" 5\n"
      "Integrator \"path\" \"integer maxdepth\" 0\nWorldBegin\n");
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::Scene& scene = result->scene;
  EXPECT_THAT(column3(scene.camera().world_from_camera()), ElementsAre(1, 2, 3));
  EXPECT_DOUBLE_EQ(scene.camera().world_from_camera().elements(0), -1);  // Scale -1 1 1 mirrors the image
  EXPECT_DOUBLE_EQ(scene.camera().world_from_camera().elements(10), 1);
  EXPECT_FLOAT_EQ(scene.camera().perspective().fov_degrees(), 40);
  EXPECT_FLOAT_EQ(scene.camera().perspective().lens_radius(), 0.1f);
  EXPECT_FLOAT_EQ(scene.film().exposure(), 2);  // half the time, four times the sensitivity
  EXPECT_EQ(scene.film().filter().kind(), v1::PixelFilter::LANCZOS);
  EXPECT_FLOAT_EQ(scene.film().filter().tau(), 3);
  EXPECT_EQ(scene.settings().sampler(), v1::SAMPLER_UNSPECIFIED);  // Tessera's own
  EXPECT_EQ(scene.settings().spp(), 9u);
  EXPECT_EQ(scene.settings().seed(), 5u);
  EXPECT_TRUE(scene.settings().has_max_depth());
  EXPECT_EQ(scene.settings().max_depth(), 0u);
  EXPECT_EQ(warnings_of(*result), "");
}

TEST_F(PbrtCamera, SensorsOfFilmsAreSettings) {
  const auto film = [&](const std::string& before, const std::string& type, const std::string& parameters) {
    const auto read = import_text(before + "Film \"" + type + "\" " + parameters + "\nWorldBegin\n");
    EXPECT_TRUE(read.ok()) << read.status();
    return read.ok() ? *read : ImportedScene{};
  };
  const auto settings = [&](const std::string& parameters) {
    return film("", "rgb", parameters).scene.settings();
  };
  // pbrt's usual sensor, and a balance for the white that there is, are what jobs of RGB have.
  for (const char* usual : {"", "\"string sensor\" \"cie1931\"", "\"float whitebalance\" 6500"}) {
    const ImportedScene read = film("", "rgb", usual);
    EXPECT_EQ(read.scene.settings().color(), v1::COLOR_UNSPECIFIED) << usual;
    EXPECT_EQ(warnings_of(read), "") << usual;
  }
  const ImportedScene canon = film("ColorSpace \"rec2020\" ", "rgb",
                                   "\"string sensor\" \"canon_eos_5d_mkii\" \"float whitebalance\" 5000 "
                                   "\"float iso\" 50");
  EXPECT_EQ(canon.scene.settings().color(), v1::COLOR_SPECTRAL);
  EXPECT_EQ(canon.scene.settings().sensor(), "canon-eos-5d-mark-ii");
  EXPECT_EQ(canon.scene.settings().rgb_space(), v1::RGB_SPACE_UNSPECIFIED);  // it has channels of its own
  EXPECT_FLOAT_EQ(canon.scene.film().exposure(), 0.5f);
  EXPECT_THAT(warnings_of(canon), HasSubstr("scene.pbrt:1:33: film sensor \"canon_eos_5d_mkii\""));
  // 5000 K is that of D50, by the radiation constant of its time.
  EXPECT_EQ(settings("\"float whitebalance\" 5000").white_balance(), "5002.78K");
  EXPECT_EQ(settings("\"float whitebalance\" 2856").white_balance(), "2857.59K");
  const ImportedScene absent = film("", "rgb", "\"string sensor\" \"nikon_d850\"");
  EXPECT_EQ(absent.scene.settings().sensor(), "");
  EXPECT_EQ(absent.scene.settings().color(), v1::COLOR_UNSPECIFIED);
  EXPECT_THAT(warnings_of(absent), HasSubstr("sensitivities of film sensor \"nikon_d850\" are not here"));

  const v1::RenderSettings bands =
      film("ColorSpace \"rec2020\" ", "spectral", "\"float lambdamin\" 400 \"integer nbuckets\" 31")
          .scene.settings();
  EXPECT_EQ(bands.color(), v1::COLOR_SPECTRAL);
  EXPECT_EQ(bands.film(), "spectral:31:400-830");
  EXPECT_EQ(bands.rgb_space(), v1::RGB_SPACE_REC2020);
  EXPECT_EQ(film("", "spectral", "").scene.settings().film(), "spectral:16:360-830");  // pbrt's own
  EXPECT_EQ(film("ColorSpace \"dci-p3\" ", "spectral", "").scene.settings().rgb_space(), v1::RGB_SPACE_P3);
  const ImportedScene aces = film("ColorSpace \"aces2065-1\" ", "spectral", "");
  EXPECT_EQ(aces.scene.settings().rgb_space(), v1::RGB_SPACE_ACESCG);
  EXPECT_THAT(warnings_of(aces), HasSubstr("ACEScg"));
  EXPECT_THAT(warnings_of(film("ColorSpace \"rec2020\" ", "rgb", "")),
              HasSubstr("--color spectral --set rgb-space=rec2020"));
  // An integrator without wavelengths is not the scene's, where it asks for bands.
  const auto sppm = import_text("Integrator \"sppm\"\nFilm \"spectral\"\nWorldBegin\n");
  ASSERT_TRUE(sppm.ok());
  EXPECT_TRUE(wire::find_algorithm(sppm->scene.settings().integrator())->wavelengths);
}

TEST_F(PbrtCamera, FaultsOfSensorsAreToldWhereTheyStandAllAtOnce) {
  const std::string message = error_of(import_text(
      "Film \"spectral\"\n  \"string sensor\" \"cannon_eos_5d_mkii\"\n  \"float whitebalance\" 100\n"
      "  \"float iso\" 0\n  \"integer nbuckets\" 0\nWorldBegin\n"));
  EXPECT_THAT(message,
              HasSubstr("scene.pbrt:2:3: there is no film sensor \"cannon_eos_5d_mkii\"; did you mean "
                        "'canon_eos_5d_mkii'?"));
  EXPECT_THAT(message, HasSubstr("scene.pbrt:3:3: \"whitebalance\": white balance is 100.0"));
  EXPECT_THAT(message, HasSubstr("scene.pbrt:4:3: an \"iso\" above 0 was expected, found 0"));
  EXPECT_THAT(message, HasSubstr("scene.pbrt:1:1: film: a spectral film has 1 to 512 bands, not '0'"));
  const auto of_bands = [&](const std::string& parameters) {
    return error_of(import_text("Film \"spectral\" " + parameters + "\nWorldBegin\n"));
  };
  EXPECT_THAT(of_bands("\"integer nbuckets\" 10000"), HasSubstr("1 to 512 bands, not '10000'"));
  EXPECT_THAT(of_bands("\"float lambdamax\" 1200"), HasSubstr("300 to 1000 nm"));
  EXPECT_THAT(of_bands("\"float lambdamin\" 700 \"float lambdamax\" 400"), HasSubstr("begins at 700 nm"));
}

TEST_F(PbrtCamera, RealisticCamerasHaveTheirLensFromAFile) {
  write("lens.dat", "# A singlet\n0 2 0 20\n50 6 1.5 24\n-90 60 0 24\n");
  const auto result = import_text(
      "Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float aperturediameter\" 12 "
      "\"float focusdistance\" 3\nFilm \"rgb\" \"float diagonal\" 40\nWorldBegin");
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::LensCamera& camera = result->scene.camera().lens();
  ASSERT_EQ(camera.lens().surfaces_size(), 3);
  EXPECT_EQ(camera.lens().name(), "A singlet");
  EXPECT_TRUE(camera.lens().surfaces(0).stop());
  EXPECT_EQ(camera.lens().surfaces(1).index(), 1.5);
  EXPECT_EQ(camera.stop_diameter_mm(), 12);
  EXPECT_EQ(camera.focus_distance(), 3);
  EXPECT_EQ(camera.film_diagonal_mm(), 40);
  EXPECT_EQ(camera.brightness(), v1::LensCamera::IRRADIANCE);
  EXPECT_EQ(warnings_of(*result), "");
}

TEST_F(PbrtCamera, AperturesArePicturesAsBrightAsACircle) {
  write("lens.dat", "# A singlet\n0 2 0 20\n50 6 1.5 24\n-90 60 0 24\n");
  const auto imported = [&](const std::string& aperture) {
    return import_text(
        "Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float aperturediameter\" 12 "
        "\"float focusdistance\" 3 \"string aperture\" \"" +
        aperture + "\"\nWorldBegin");
  };
  const auto picture = [&](const std::string& aperture) {
    const auto result = imported(aperture);
    EXPECT_TRUE(result.ok()) << result.status();
    const v1::BlobRef& ref = result->scene.camera().lens().stop_image();
    const auto blob = std::ranges::find_if(
        result->blobs, [&](const SceneBlob& b) { return b.ref.digest() == ref.digest(); });
    return *images::decode_image(blob->bytes, ref.path());
  };
  for (const char* const name : {"gaussian", "square", "pentagon", "star"}) {
    const images::ImagePixels pixels = picture(name);
    double sum = 0;
    for (std::size_t i = 0; i < pixels.floats.size(); i += 4) sum += double{pixels.floats[i]};
    EXPECT_NEAR(sum / (256 * 256), std::numbers::pi / 4, 1e-4) << name;
  }
  // A quarter of the square is open; a corner of the pentagon points down, as pbrt has it.
  const auto at = [](const images::ImagePixels& pixels, std::size_t x, std::size_t y) {
    return double{pixels.floats[4 * (y * 256 + x)]};
  };
  EXPECT_NEAR(at(picture("square"), 128, 70), std::numbers::pi, 1e-3);
  EXPECT_EQ(at(picture("square"), 128, 60), 0);
  EXPECT_GT(at(picture("pentagon"), 128, 225), 0);
  EXPECT_EQ(at(picture("pentagon"), 128, 30), 0);
  // The first row of a file is the upper one.
  const std::vector<float> rows = {0, 0, 1, 3};
  std::string pfm = "Pf\n2 2\n-1.0\n";
  pfm.append(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(float));
  write("own.pfm", pfm);
  const images::ImagePixels own = picture("own.pfm");
  EXPECT_EQ(own.floats[8], 0);
  EXPECT_NEAR(double{own.floats[4]} / double{own.floats[0]}, 3, 1e-5);
  EXPECT_THAT(error_of(imported("hexagon")), HasSubstr("nor is it \"gaussian\", \"square\""));
}

TEST_F(PbrtCamera, FaultsOfALensNameItsFile) {
  EXPECT_THAT(error_of(import_text("Camera \"realistic\"\nWorldBegin")), HasSubstr("needs a \"lensfile\""));
  write("lens.dat", "0 2 0 20\n5 6 1.5 24\n-90 60 nothing 24\n");
  const std::string camera = "Camera \"realistic\" \"string lensfile\" \"lens.dat\" \"float focusdistance\" ";
  EXPECT_THAT(error_of(import_text(camera + "3\nWorldBegin")),
              HasSubstr("lens.dat:3:8: 'nothing' is no number"));
  write("lens.dat", "0 2 0 20\n5 6 1.5 24\n-90 60 0 24\n");
  EXPECT_THAT(error_of(import_text(camera + "3\nWorldBegin")),
              HasSubstr("lens.dat:2: surface 2: an aperture of 24 mm is larger than its element"));
  write("lens.dat", "0 2 0 20\n50 6 1.5 24\n-90 60 0 24\n");
  EXPECT_THAT(error_of(import_text(camera + "0.1\nWorldBegin")), HasSubstr("nearer than possible"));
}

TEST_F(PbrtCamera, MotionWithinTheExposureHasItsTimes) {
  // From x = 0 at time 1 to x = 8 at time 3; the shutter is open from 0 to 4.
  const auto result = import_text(
      "TransformTimes 1 3\nActiveTransform EndTime Translate 0 0 -1 ActiveTransform All\n"
      "Camera \"perspective\" \"float shutteropen\" 0 \"float shutterclose\" 4\nWorldBegin\n"
      "AttributeBegin ActiveTransform EndTime Translate 8 0 0\n  Shape \"sphere\" AttributeEnd\n");
  ASSERT_TRUE(result.ok()) << result.status();
  const auto& keys = result->scene.shapes(0).motion();
  ASSERT_EQ(keys.size(), 2);
  EXPECT_EQ(keys[0].time(), 0.25);
  EXPECT_THAT(column3(keys[0].place()), ElementsAre(0, 0, 0));
  EXPECT_EQ(keys[1].time(), 0.75);
  EXPECT_THAT(column3(keys[1].place()), ElementsAre(8, 0, 0));
  const auto& of_camera = result->scene.camera().motion();
  ASSERT_EQ(of_camera.size(), 2);
  EXPECT_EQ(of_camera[1].time(), 0.75);
  EXPECT_THAT(column3(of_camera[1].place()), ElementsAre(0, 0, 1));
}

TEST_F(PbrtCamera, MotionIsCutToTheExposure) {
  // From x = 0 at time 0 to x = 8 at time 2; the shutter is open from 0.5 to 1.
  const auto result = import_text(
      "TransformTimes 0 2\nCamera \"perspective\" \"float shutteropen\" .5 \"float shutterclose\" "
      "1\nWorldBegin\n"
      "Shape \"sphere\"\nAttributeBegin ActiveTransform EndTime Translate 8 0 0 ActiveTransform All "
      "Translate 0 1 0\n"
      "  Shape \"sphere\" AttributeEnd\n"
      "ObjectBegin \"o\" Shape \"disk\" ObjectEnd ActiveTransform StartTime Translate 0 0 4 ObjectInstance "
      "\"o\"\n");
  ASSERT_TRUE(result.ok()) << result.status();
  const v1::Scene& scene = result->scene;
  EXPECT_FALSE(scene.shapes(0).has_world_from_object_end());
  EXPECT_THAT(column3(scene.shapes(1).world_from_object()), ElementsAre(2, 1, 0));
  EXPECT_THAT(column3(scene.shapes(1).world_from_object_end()), ElementsAre(4, 1, 0));
  EXPECT_THAT(column3(scene.instances(0).world_from_instance()), ElementsAre(0, 0, 3));
  EXPECT_THAT(column3(scene.instances(0).world_from_instance_end()), ElementsAre(0, 0, 2));
  EXPECT_FALSE(scene.camera().has_world_from_camera_end());
  EXPECT_EQ(warnings_of(*result), "");
}

TEST_F(PbrtCamera, IntegratorsOfAllVersionsHaveCounterparts) {
  for (const char* name :
       {"path", "volpath", "simplepath", "simplevolpath", "bdpt", "mlt", "sppm", "lightpath", "randomwalk",
        "ao", "ambientocclusion", "function", "directlighting", "whitted", "raycast"}) {
    const auto result = import_text(concat("Integrator \"", name, "\" \"integer maxdepth\" 7\nWorldBegin\n"));
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_NE(wire::find_algorithm(result->scene.settings().integrator()), nullptr) << name;
    EXPECT_EQ(result->scene.settings().max_depth(), 7u) << name;
  }
}

TEST_F(PbrtCamera, PhotonsAreThoseOfSppm) {
  const auto photons = [&](const std::string& parameters) {
    const auto result = import_text("Integrator \"sppm\" " + parameters + "\nWorldBegin\n");
    EXPECT_EQ(warnings_of(*result), "");
    return result->scene.settings().photon();
  };
  const v1::PhotonSettings named =
      photons("\"float radius\" .05 \"integer photonsperiteration\" 20000 \"integer maxdepth\" 7");
  EXPECT_FLOAT_EQ(static_cast<float>(named.radius()), 0.05f);
  EXPECT_EQ(named.photons(), 20000u);
  // -1 photons are as many as pixels.
  const v1::PhotonSettings usual = photons("\"integer photonsperiteration\" -1");
  EXPECT_FALSE(usual.has_radius());
  EXPECT_FALSE(usual.has_photons());
}

TEST_F(PbrtCamera, MetropolisHasItsSettings) {
  const auto result = import_text(
      "Integrator \"mlt\" \"float largestepprobability\" 0.4 \"float sigma\" 0.02 \"integer chains\" 500 "
      "\"integer bootstrapsamples\" 20000 \"integer mutationsperpixel\" 50\nWorldBegin\n");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(warnings_of(*result), "");
  const v1::RenderSettings& settings = result->scene.settings();
  EXPECT_EQ(settings.integrator(), "mlt");
  EXPECT_NEAR(settings.mlt().large_steps(), 0.4, 1e-6);
  EXPECT_NEAR(settings.mlt().step(), 0.02, 1e-6);
  EXPECT_EQ(settings.mlt().candidates(), 40u);
  EXPECT_FALSE(import_text("Integrator \"mlt\"\nWorldBegin\n")->scene.settings().has_mlt());
}

TEST_F(PbrtCamera, LightsThatAreNotSampledAreFoundByChance) {
  const auto lighting = [&](const std::string& integrator) {
    return import_text("Integrator " + integrator + "\nWorldBegin\n")->scene.settings().direct_light();
  };
  EXPECT_EQ(lighting("\"randomwalk\""), v1::DIRECT_LIGHT_BSDF);
  EXPECT_EQ(lighting("\"simplepath\" \"bool samplelights\" false"), v1::DIRECT_LIGHT_BSDF);
  EXPECT_EQ(lighting("\"simplepath\""), v1::DIRECT_LIGHT_UNSPECIFIED);
}

}  // namespace
}  // namespace tessera::client
