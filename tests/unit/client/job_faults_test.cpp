// Faults of a scene, and what its job cannot do with it, are told before anything is submitted, all at once
// and at their places in the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/exit_code.h"
#include "command/render_options.h"
#include "unit/client/files.h"
#include "wire/algorithm.h"
#include "wire/volume_blob.h"

namespace tessera::client::job_faults {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;

constexpr char kFilmAndCamera[] = "film { width: 4 height: 4 }\ncamera { perspective { fov_degrees: 40 } }\n";

using Files = std::map<std::string, std::string>;  // bytes by name

/// Returns what load_job() prints of a scene's file; empty where it is loaded. `files` lie beside it;
/// `change` sets further options.
std::string refusal(
    const std::string& integrator, const std::string& scene, const std::string& name = "scene.textproto",
    const Files& files = {}, void (*change)(JobSettings&) = [](JobSettings&) {}) {
  const support::TempDir directory;
  RenderOptions options;
  options.scene = directory / name;
  options.quiet = true;
  options.job.settings.set_integrator(integrator);
  change(options.job);
  write_bytes(options.scene, scene);
  for (const auto& [file, bytes] : files) write_bytes(directory / file, bytes);
  int exit_code = kDone;
  testing::internal::CaptureStderr();
  const bool loaded = load_job(options, exit_code) != nullptr;
  const std::string printed = testing::internal::GetCapturedStderr();
  EXPECT_EQ(exit_code, loaded ? kDone : kBadScene) << printed;
  return printed;
}

TEST(JobFaults, AreToldAllAtOnceAtTheirPlaces) {
  const std::string told = refusal(
      "bdpt",
      absl::StrCat(kFilmAndCamera,
                   "lights { name: 'sky' infinite { radiance { constant: 1 } portal {} portal { x: 1 } "
                   "portal { x: 1 y: 1 } portal { y: 1 } } }\n",
                   "shapes { name: 'ground' half_space {} }\n", "shapes { sphere { radius: 1 } }\n",
                   "objects { name: 'tree'\n  shapes { half_space {} } }\n",
                   "objects { name: 'nowhere' shapes { half_space {} } }\n",
                   "instances { object: 'tree' }\n"));
  EXPECT_THAT(told,
              HasSubstr("scene.textproto:3:1: light (sky): integrator 'bdpt' cannot begin at a portal"));
  EXPECT_THAT(told, HasSubstr("scene.textproto:4:1: shape (ground): integrator 'bdpt' cannot start light at "
                              "infinity that falls on all of a half-space"));
  EXPECT_THAT(told, HasSubstr("scene.textproto:7:3: shape: integrator 'bdpt' cannot start light"));
  EXPECT_EQ(std::ranges::count(told, '\n'), 3) << told;
}

TEST(JobFaults, AreOfAlgorithmsThatCannotDoIt) {
  const std::string floor = absl::StrCat(kFilmAndCamera, "lights { distant { direction { z: -1 } } }\n",
                                         "shapes { half_space {} }\n");
  const std::string room = absl::StrCat(kFilmAndCamera, "lights { point {} }\nshapes { half_space {} }\n");
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    if (traits.diffuse_only) continue;
    EXPECT_EQ(refusal(traits.name, floor).empty(), !traits.starts_at_lights) << traits.name;
    EXPECT_THAT(refusal(traits.name, room), IsEmpty()) << traits.name;
  }
}

TEST(JobFaults, MotionCountsWhereThingsMove) {
  const auto moving = [](const char* x) {
    return absl::StrCat(
        " world_from_object { elements: [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } "
        "world_from_object_end { elements: [1,0,0,",
        x, ", 0,1,0,0, 0,0,1,0, 0,0,0,1] } }\n");
  };
  const auto of_cache = [&](const std::string& shape) {
    return refusal("irradiance-cache", absl::StrCat(kFilmAndCamera, shape));
  };
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 }", moving("2"))),
              HasSubstr(":3:1: shape: integrator 'irradiance-cache' wants a scene that stands still"));
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 }", moving("1"))), IsEmpty());
  EXPECT_THAT(of_cache(absl::StrCat("shapes { sphere { radius: 1 } area_light {}", moving("2"))),
              HasSubstr("wants a scene that stands still"));
  EXPECT_THAT(of_cache("objects { name: 'o' shapes { sphere { radius: 1 } } }\n"
                       "instances { object: 'o' world_from_instance_end { elements: [1,0,0,2, 0,1,0,0, "
                       "0,0,1,0, 0,0,0,1] } }\n"),
              HasSubstr(":4:1: instance (o): integrator 'irradiance-cache' wants"));
}

TEST(JobFaults, RadiosityNamesAllThatIsNotDiffuse) {
  const std::string scene = absl::StrCat(
      kFilmAndCamera, "materials { name: 'metal' conductor {} }\nmaterials { name: 'paint' diffuse {} }\n",
      "materials { name: 'unused' dielectric {} }\nmaterials { name: 'both' mix { a: 'paint' b: 'metal' } "
      "}\n",
      "shapes { box { low: [0, 0, 0] high: [1, 1, 1] } material: 'both' }\n",
      "shapes { sphere { radius: 1 } material: 'paint' }\n",
      "shapes { polygon { corners: [0,0,0, 1,0,0, 1,1,0] } alpha { constant: 0.5 } }\n");
  const std::string told = refusal("radiosity", scene);
  EXPECT_THAT(told,
              AllOf(HasSubstr(":3:1: material (metal): integrator 'radiosity' is for diffuse materials"),
                    HasSubstr(":8:1: shape: integrator 'radiosity' is for meshes of triangles"),
                    HasSubstr(":9:1: shape: integrator 'radiosity' is for closed surfaces")));
  EXPECT_EQ(std::ranges::count(told, '\n'), 3) << told;
}

TEST(JobFaults, OfTheCameraAreAtTheCamera) {
  EXPECT_THAT(refusal("path", "film { width: 4 height: 4 }\ncamera { perspective { fov_degrees: 200 } }\n"),
              HasSubstr("scene.textproto:2:1: camera: a field of view of 200"));
  EXPECT_THAT(
      refusal("light", "film { width: 4 height: 4 }\ncamera { fisheye { fov_degrees: 400 } }\n"),
      HasSubstr("scene.textproto:2:1: camera: a fisheye of mapping EQUIDISTANT cannot see a field of 400"));
}

/// An element of a scene, and what is told of it. Where that is empty, nothing is.
struct Hostile {
  const char* element;
  const char* message;
};

#define SINGULAR "{ elements: [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] }"
#define PROJECTIVE "{ elements: [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,1,1] }"
#define MIRROR "{ elements: [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }"

/// A line each, in one scene of this algorithm: all are told in one run, at their lines.
void expect_all_told(const std::string& integrator, std::span<const Hostile> lines, const Files& files = {}) {
  std::string scene = kFilmAndCamera;
  std::ptrdiff_t faults = 0;
  for (const Hostile& line : lines) {
    absl::StrAppend(&scene, line.element, "\n");
    faults += *line.message != '\0';
  }
  const std::string told = refusal(integrator, scene, "scene.textproto", files);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string place = absl::StrCat("scene.textproto:", i + 3, ":1: ");
    const std::size_t at = told.find(place);
    if (*lines[i].message == '\0') {
      EXPECT_EQ(at, std::string::npos) << told;
      continue;
    }
    ASSERT_NE(at, std::string::npos) << lines[i].element << " in\n" << told;
    EXPECT_THAT(told.substr(at, told.find('\n', at) - at), HasSubstr(lines[i].message));
  }
  EXPECT_EQ(std::ranges::count(told, '\n'), faults) << told;
}

TEST(JobFaults, OfLights) {
  constexpr Hostile kLights[] = {
      {"lights { spot {} }", "light: it has no direction"},
      {"textures { name: 't' constant { constant: 1 } }", ""},
      {"lights { spot { target { z: 1 } up { y: 1 } cone_angle_degrees: 90 texture: 't' } }",
       "a cone angle below 90 degrees"},
      {"lights { spot { target { z: 1 } cone_angle_degrees: 9 texture: 't' } }",
       "its orientation is not defined"},
      {"lights { name: 'sun' distant {} }", "light (sun): it has no direction"},
      {"lights { projection { fov_degrees: 180 } }", "not in (0, 180) degrees"},
      {"lights { projection { fov_degrees: 90 world_from_light " SINGULAR " } }",
       "its transform is singular"},
      {"lights { goniometric { world_from_light " PROJECTIVE " } }", "a matrix is not affine"},
      {"lights { goniometric { intensity { sampled { wavelengths_nm: [2, 1] values: [1, 1] } } } }",
       "must ascend"},
      {"lights { point { intensity { sampled {} } } }", "one value a wavelength"},
      {"lights { infinite { world_from_light " SINGULAR " } }", "its transform is singular"},
      {"lights { infinite { image { path: 'text.png' } } }", "image text.png: it is none of PNG"},
      {"lights { infinite { image { path: 'huge.pfm' } } }", "40000 x 40000 texels are more than the limit"},
      {"lights { infinite { image { path: 'long.pfm' } } }", "must be square, this one is 3 x 2"},
      {"lights { infinite { image { path: 'long.pfm' } mapping: LATITUDE_LONGITUDE } }", ""},
      {"lights { infinite { portal {} } }", "a portal has four corners"},
      {"lights { infinite { portal {} portal {} portal {} portal {} } }", "its portal has no area"},
      {"shapes { sphere { radius: 1 } area_light { interpolated_normal_pick: 2 } }",
       "shape: area light: a probability is not within 0 and 1"},
      {"shapes { sphere { radius: 1 } area_light { radiance { sampled {} } } }",
       "shape: area light: radiance"},
      {"shapes { polygon { corners: [0,0,0, 1,0,0, 0,1,0] } area_light { texture: 't' } }", ""}};
  expect_all_told(
      "path", kLights,
      {{"text.png", "no picture"}, {"huge.pfm", "PF\n40000 40000\n-1.0\n"}, {"long.pfm", "PF\n3 2\n-1.0\n"}});
}

TEST(JobFaults, OfSpectra) {
  constexpr Hostile kSpectra[] = {
      {"materials { name: 'a' diffuse { reflectance { constant { sampled { wavelengths_nm: [400, 500] "
       "values: [1, -1] } } } } }",
       "material (a): spectrum: the value of a spectrum at 500 nm is -1, which is negative"},
      {"materials { name: 'b' conductor { eta { constant { named: 'metal-Au-eta' } } k { constant { named: "
       "'metal-Auk' } } } }",
       "material (b): index of refraction: no spectrum is called 'metal-Auk'; did you mean 'metal-Au-k'?"},
      {"materials { name: 'c' dielectric { eta { named: 'glass-BK8' } } }", "did you mean 'glass-BK7'?"},
      {"materials { name: 'd' dielectric { eta { named: 'glass-BK7' } } }", ""},
      {"media { name: 'e' extinction { constant { sampled { wavelengths_nm: [700, 400] values: [1, 1] } } } "
       "}",
       "wavelengths of a spectrum must ascend"},
      {"media { name: 'f' albedo { constant { sampled { wavelengths_nm: [400] } } } }",
       "a spectrum needs one value a wavelength"},
      {"lights { point { intensity { named: 'stdillum-D6' } } }", "did you mean 'stdillum-D65'?"},
      {"lights { point { intensity { sampled { wavelengths_nm: [0.4, 0.7] values: [1, 1] } } } }",
       "none from 300 to 1000 nm"},
      {"lights { point { intensity { blackbody { } } } }", "a blackbody of 0 K is not above 0 K"}};
  expect_all_told("volpath", kSpectra);
}

TEST(JobFaults, OfTheFilmsOwnSensitivities) {
  const auto told = [](const std::string& sensitivities) {
    return refusal("path",
                   absl::StrCat("camera { perspective { fov_degrees: 40 } }\nfilm { width: 4 height: 4 ",
                                sensitivities, " }\n"),
                   "scene.textproto", {}, [](JobSettings& job) {
                     job.settings.set_color(v1::COLOR_SPECTRAL);
                     job.settings.set_sensor("film");
                   });
  };
  const std::string sound = "sensitivities { wavelengths_nm: [400, 500, 600] values: [0, 1, 0] } ";
  EXPECT_THAT(told(sound), IsEmpty());
  EXPECT_THAT(told(sound + sound + sound), IsEmpty());
  EXPECT_THAT(told(""), HasSubstr("sensor 'film' needs one or three sensitivities; it has 0"));
  EXPECT_THAT(told(sound + sound), AllOf(HasSubstr("scene.textproto:2"), HasSubstr("it has 2")));
  EXPECT_THAT(told("sensitivities { wavelengths_nm: [500, 400] values: [1, 1] }"),
              AllOf(HasSubstr("scene.textproto:2"), HasSubstr("sensitivity 1"), HasSubstr("must ascend")));
  EXPECT_THAT(told("sensitivities { wavelengths_nm: [400, 500] values: [1, -1] }"), HasSubstr("negative"));
  EXPECT_THAT(told("sensitivities { wavelengths_nm: [400, 500] values: [1, nan] }"), HasSubstr("not finite"));
  EXPECT_THAT(told("sensitivities { wavelengths_nm: [0.4, 0.7] values: [1, 1] }"), HasSubstr("nm"));
  EXPECT_THAT(told("sensitivities { wavelengths_nm: [400, 500] values: [0, 0] }"), HasSubstr("sees nothing"));
}

TEST(JobFaults, OfTextures) {
  constexpr Hostile kTextures[] = {
      {"textures { name: 'own' scale { value { texture: 'own' } } }", "texture (own): it refers to itself"},
      {"textures { name: 'user' scale { value { texture: 'own' } } }", ""},
      {"textures { name: 'one' scale { value { texture: 'two' } } }", "it refers to itself"},
      {"textures { name: 'two' scale { value { texture: 'one' } } }", ""},
      {"textures { name: 'a' constant { sampled {} } }", "constant: a spectrum needs one value"},
      {"textures { name: 'b' scale { value { constant { sampled {} } } } }", "input: a spectrum"},
      {"textures { name: 'c' noise { octaves: 65 } }", "it has 65 octaves, more than 64"},
      {"textures { name: 'd' noise { texture_from_world " PROJECTIVE " } }", "a matrix is not affine"},
      {"textures { name: 'e' direction_mix {} }", "its direction is zero"},
      {"textures { name: 'f' dots { mapping { texture_from_world " PROJECTIVE " } } }", "is not affine"},
      {"textures { name: 'g' image { image { path: 'dot.pfm' } max_anisotropy: 0.5 } }",
       "max_anisotropy is 0.5"},
      {"textures { name: 'h' image { image { path: 'text.png' } } }", "image text.png: it is none of PNG"},
      {"textures { name: 'i' image { image { path: 'huge.pfm' } filter: EWA } }", "40000 x 40000 texels"},
      {"textures { name: 'j' image { image { path: 'dot.pfm' } } }", ""},
      {"textures { name: 'k' image { image { path: 'more.png' } } }", ""},  // nothing looks it up
      {"textures { name: 'l' mesh_attribute { attribute: 'heat' } }", ""},
      {"materials { name: 'm' diffuse { reflectance { texture: 'h' } } back: 'n' }", ""},
      {"materials { name: 'n' diffuse { reflectance { texture: 'i' } } opacity { texture: 'j' } }", ""},
      {"materials { name: 'o' diffuse { reflectance { texture: 'own' } } normal_map { image { path: "
       "'more.png' } } }",
       ""},
      {"materials { name: 'p' diffuse {} normal_map { image { path: 'other.png' } } }",
       "material (p): image other.png: it is none of PNG"},
      {"shapes { mesh { blob { path: 'leaf.ply' } attributes { name: 'heat' channels: 1 blob { path: "
       "'text.png' } } } alpha { texture: 'l' } }",
       "shape: attribute 'heat': 10 bytes are not 3 values of 1 channels"}};
  expect_all_told(
      "path", kTextures,
      {{"text.png", "no picture"},
       {"more.png", "nor is this"},
       {"other.png", "nor is that"},
       {"dot.pfm", "PF\n1 1\n-1.0\n"},
       {"huge.pfm", "PF\n40000 40000\n-1.0\n"},
       {"leaf.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
        "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 "
        "2\n"}});
}

TEST(JobFaults, OfMaterials) {
  constexpr Hostile kMaterials[] = {
      {"materials { name: 'a' mix { a: 'a' b: 'fine' } }", "material (a): it mixes itself"},
      {"materials { name: 'b' mix { a: 'a' b: 'c' } }", ""},
      {"materials { name: 'fine' diffuse {} }", ""},
      {"materials { name: 'c' conductor { roughness { u { constant: -1 } } } }", "a roughness is below 0"},
      {"materials { name: 'd' conductor { eta { constant { sampled {} } } } }",
       "index of refraction: a spectrum"},
      {"materials { name: 'e' dielectric { eta { sampled {} } } }", "index of refraction: a spectrum"},
      {"materials { name: 'f' coated_diffuse { thickness: -1 } }", "the thickness of its coat is below 0"},
      {"materials { name: 'g' coated_conductor { thickness: -1 } }", "the thickness of its coat is below 0"},
      {"materials { name: 'h' plastic { roughness { u { constant: 0.1 } } } }",
       "the roughness of a plastic must be"},
      {"materials { name: 'i' principled { specular { constant: 2 } } }",
       "its specular is not between 0 and 1"},
      {"materials { name: 'j' gltf { iridescence_ior: 0.5 } }", "an iridescence_ior of 0.5"},
      {"materials { name: 'k' gltf { iridescence_thickness { constant: -1 } } }",
       "an iridescence_thickness of -1"},
      {"materials { name: 'l' gltf { dispersion: -1 } }", "a dispersion of -1"},
      {"materials { name: 'm' diffuse { reflectance { constant { sampled {} } } } }", "spectrum: a spectrum"},
      {"materials { name: 'n' diffuse {} normal_texture: 't' normal_map {} }", "exclude each other"},
      {"textures { name: 't' constant { constant: 1 } }", ""}};
  expect_all_told("path", kMaterials);
}

TEST(JobFaults, OfMediaWhereTheyAreSeen) {
  constexpr Hostile kMedia[] = {
      {"media { name: 'a' scale: -1 }", "medium (a): its scale is negative"},
      {"media { name: 'b' g: 1 }", "its asymmetry g is not within (-1, 1)"},
      {"media { name: 'c' extinction { constant { constant: -1 } } }",
       "extinction: a coefficient is negative"},
      {"media { name: 'd' emission { constant { sampled {} } } }", "emission: spectrum: a spectrum"},
      {"media { name: 'e' extinction { grid { blob { path: 'two.vol' } } } }", "a grid has 2 channels"},
      {"media { name: 'f' extinction { grid { blob { path: 'minus.vol' } } } }",
       "a grid has a negative sample"},
      {"media { name: 'g' extinction { grid { blob { path: 'text' } } } }", "volume blob"},
      {"media { name: 'h' extinction { grid { blob { path: 'one.vol' } world_from_grid " SINGULAR " } } }",
       "extinction: grid: its transform is singular"},
      {"media { name: 'i' extinction { grid { blob { path: 'one.vol' } } } scale: 1e9 }",
       "its optical depth"},
      {"media { name: 'l' extinction { grid { blob { path: 'one.vol' } factor { sampled { wavelengths_nm: "
       "[700, 400] values: [1, 1] } } } } }",
       "medium (l): extinction: factor: wavelengths of a spectrum must ascend"},
      {"media { name: 'm' sigma_s { grid { blob { path: 'one.vol' } factor { named: 'stdillum-D66' } } } }",
       "scattering: factor: no spectrum is called 'stdillum-D66'; did you mean 'stdillum-D65'?"},
      {"media { name: 'n' emission { grid { blob { path: 'one.vol' } factor { constant: -1 } } } }",
       "emission: a coefficient is negative"},
      {"media { name: 'j' world_from_bounds " SINGULAR " }", "bounds: its transform is singular"},
      {"media { name: 'k' extinction { grid { blob { path: 'one.vol' } } } }", ""}};
  const auto volume = [](std::uint32_t channels, const std::vector<float>& samples) {
    return wire::encode_volume({1, 1, 1, channels, samples});
  };
  const Files files = {{"two.vol", volume(2, {1, 1})},
                       {"minus.vol", volume(1, {-1})},
                       {"one.vol", volume(1, {1})},
                       {"text", "no volume"}};
  expect_all_told("volpath", kMedia, files);
  std::string scene = kFilmAndCamera;
  for (const Hostile& one : kMedia) absl::StrAppend(&scene, one.element, "\n");
  EXPECT_THAT(refusal("path", scene, "scene.textproto", files), IsEmpty());
}

TEST(JobFaults, OfObjectsAndInstances) {
  constexpr Hostile kInstances[] = {
      {"objects { name: 'o' shapes { sphere { radius: 1 } } }", ""},
      {"instances { object: 'o' world_from_instance " PROJECTIVE " }",
       "instance (o): a matrix is not affine"},
      {"instances { object: 'o' world_from_instance_end " MIRROR " }", "its motion turns it inside out"},
      {"instances { object: 'o' world_from_instance { elements: [1e-13,0,0,0, 0,1e-13,0,0, 0,0,1e-13,0, "
       "0,0,0,1] } }",
       "scales by more, or by less, than 32-bit floats hold"},
      {"objects { name: 'own' instances { object: 'own' } }", "object 'own' holds itself: 'own' > 'own'"},
      {"shapes { sphere { radius: 1 } world_from_object_end " SINGULAR " }",
       "end of its motion is singular"}};
  expect_all_told("path", kInstances);
}

TEST(JobFaults, OfHowMuchThereIs) {
  std::string scene = kFilmAndCamera;
  for (int i = 0; i < 8; ++i) {
    absl::StrAppend(&scene, "objects { name: '", i, "' ");
    for (int k = 0; k < 10; ++k) absl::StrAppend(&scene, "instances { object: '", i + 1, "' } ");
    absl::StrAppend(&scene, "}\n");
  }
  absl::StrAppend(&scene, "instances { object: '0' }\nobjects { name: '8' shapes { ");
  const std::string balls = scene + "sphere { radius: 1 } } }\n", planes = scene + "half_space {} } }\n";
  const std::string boxes = scene + "box { high: [1, 1, 1] low: [0, 0, 0] } } }\n";
  EXPECT_THAT(refusal("path", balls), IsEmpty());
  EXPECT_THAT(refusal("path", planes),
              HasSubstr("scene.textproto: half-spaces of objects stand in the world"));
  EXPECT_THAT(refusal("path", balls, "scene.textproto", {},
                      [](JobSettings& job) { job.settings.set_nesting(v1::NESTING_FLATTENED); }),
              HasSubstr("nesting 'flattened' places every object in the world"));
  EXPECT_THAT(refusal("radiosity", boxes),
              AllOf(HasSubstr("radiosity of 1200000000 triangles needs"),
                    HasSubstr("integrator 'radiosity' places every object in the "
                              "world, here 100000000 instances; at most 16777216")));
}

TEST(JobFaults, OfTheSceneAndOfTheJobAreToldTogether) {
  const std::string told =
      refusal("bdpt",
              "film { width: 4 height: 4 filter { radius_x: 2000 } }\n"
              "camera { spherical {} }\nlights { infinite {} } lights { spot {} }\n"
              "  shapes { half_space {} }\n",
              "scene.textproto", {}, [](JobSettings& job) { job.aovs = {v1::AOV_MOTION}; });
  // In the order of the file.
  EXPECT_THAT(told, MatchesRegex("tessera: .*scene.textproto:1:1: film: the pixel filter's parameters.*\n"
                                 ".*:2:1: camera: it sees all around, so that aov 'motion' has no film.*\n"
                                 ".*:3:24: light: it has no direction\n"
                                 ".*:4:3: shape: integrator 'bdpt' cannot start light at infinity.*\n"));
}

TEST(JobFaults, AreFoundBeforeAnIntegratorIsChosen) {
  const std::string scene = absl::StrCat(kFilmAndCamera, "lights { spot {} }\nlights { distant {} }\n");
  EXPECT_THAT(refusal("auto", scene), AllOf(HasSubstr("scene.textproto:3:1: light: it has no direction"),
                                            HasSubstr("scene.textproto:4:1: light: it has no direction")));
}

TEST(JobFaults, OfMitsubaFilesHaveTheirLines) {
  const std::string told = refusal("volpath", R"(<scene version="3.0.0">
  <sensor type="perspective"/>
  <shape type="sphere">
    <bsdf type="roughplastic"><float name="alpha" value="-1"/></bsdf>
  </shape>
  <shape type="sphere"><bsdf type="diffuse">
    <texture type="bitmap" name="reflectance"><string name="filename" value="text.png"/></texture>
  </bsdf></shape>
</scene>)",
                                   "scene.xml", {{"text.png", "no picture"}});
  EXPECT_THAT(told, AllOf(HasSubstr("scene.xml:4:5: bsdf \"roughplastic\": a roughness is below 0"),
                          HasSubstr("scene.xml:7:5: texture \"bitmap\": image text.png: it is none of")));
}

TEST(JobFaults, OfPbrtFilesHaveTheirLines) {
  const std::string faults =
      refusal("volpath",
              "Camera \"perspective\"\n"
              "WorldBegin\nTexture \"dents\" \"float\" \"imagemap\" \"string filename\" \"text.png\"\n"
              "  Material \"coateddiffuse\" \"float thickness\" -1\nShape \"sphere\"\n"
              "Material \"diffuse\" \"texture displacement\" \"dents\"\nShape \"sphere\"\n",
              "scene.pbrt", {{"text.png", "no picture"}});
  EXPECT_THAT(faults, AllOf(HasSubstr("scene.pbrt:3:1: texture (dents): image text.png: it is none of"),
                            HasSubstr("scene.pbrt:4:3: material (material 0): the thickness of its coat")));

  const std::string told = refusal("bdpt",
                                   "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\"\n"
                                   "Shape \"halfspace\"\n",
                                   "scene.pbrt");
  EXPECT_THAT(told, HasSubstr("scene.pbrt:4:"));
  EXPECT_THAT(told, HasSubstr("integrator 'bdpt' cannot start light at infinity"));
}

TEST(JobFaults, OfLensesAreAtTheirFieldsAndSurfaces) {
  const std::string thin = refusal("path",
                                   "film { width: 4 height: 4 }\ncamera { perspective { fov_degrees: 40\n"
                                   "  lens_radius: 0.1 focal_distance: 2\n  aperture { blades: 2\n"
                                   "    ratio: -1 } } }\n");
  EXPECT_THAT(thin, HasSubstr("scene.textproto:4:14: camera: an aperture has 3 to 64 blades, not 2"));
  EXPECT_THAT(thin, HasSubstr("scene.textproto:5:5: camera: an aperture's ratio is from 0.001"));
  const std::string system =
      refusal("path",
              "film { width: 4 height: 4 }\ncamera { lens {\n  lens {\n"
              "    surfaces { thickness_mm: 2 diameter_mm: 8 stop: true }\n"
              "    surfaces { radius_mm: 5 thickness_mm: 3 diameter_mm: 24 index: 1.5 }\n"
              "    surfaces { thickness_mm: -1 diameter_mm: 24 } }\n"
              "  blades: 70\n } }\n");
  EXPECT_THAT(system,
              HasSubstr("scene.textproto:5:5: camera: the lens: surface 2: an aperture of 24 mm is larger"));
  EXPECT_THAT(system, HasSubstr("scene.textproto:6:5: camera: the lens: surface 3: a thickness of -1 mm"));
  EXPECT_THAT(system, HasSubstr("scene.textproto:7:3: camera: the lens: a stop has 3 to 64 blades, not 70"));
}

}  // namespace
}  // namespace tessera::client::job_faults
