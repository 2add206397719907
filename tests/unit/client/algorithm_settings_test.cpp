// Settings of how light is found: what integrators can do, and what they are asked for.
#include "command/jobs/job_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "unit/client/job_scene.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"

namespace tessera::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(AlgorithmSettings, IntegratorsAreRefusedWhatTheyCannotDo) {
  const ImportedScene scene = scene_of(64, 48);
  JobSettings layers, lighting;
  layers.settings.set_integrator("light");
  lighting.settings.set_integrator("light");
  layers.aovs = {v1::AOV_ALBEDO};
  lighting.settings.set_direct_light(v1::DIRECT_LIGHT_BSDF);
  for (const JobSettings& request : {layers, lighting}) {
    const auto job = prepare_job(request, scene, "");
    EXPECT_EQ(job.status().code(), absl::StatusCode::kOutOfRange);
    EXPECT_THAT(std::string{job.status().message()}, HasSubstr("integrator 'light'"));
  }
  // The file's own fault, not the command line's.
  ImportedScene wrong = scene;
  wrong.scene.mutable_settings()->set_integrator("light");
  wrong.scene.mutable_settings()->set_direct_light(v1::DIRECT_LIGHT_BSDF);
  EXPECT_EQ(prepare_job({}, wrong, "").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(AlgorithmSettings, SamplesGoIntoSeveralPixelsWhereTheFilterGainsAndTheRestAllowsIt) {
  ImportedScene scene = scene_of(64, 64);
  scene.scene.mutable_settings()->set_path_sharing(v1::PATH_SHARING_OFF);
  const auto reconstruction = [&](const JobSettings& request = {}) {
    const auto job = prepare_job(request, scene, "");
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? std::pair((*job)->spec.view().reconstruction(), (*job)->spec.cut().tile_size())
                    : std::pair(v1::RECONSTRUCTION_AUTO, 0u);
  };
  const std::pair one(v1::RECONSTRUCTION_SAMPLE, 32u), several(v1::RECONSTRUCTION_SCATTER, 128u);
  EXPECT_EQ(reconstruction(), one) << "a box";
  v1::PixelFilter& filter = *scene.scene.mutable_film()->mutable_filter();
  for (const auto kind : {v1::PixelFilter::TRIANGLE, v1::PixelFilter::GAUSSIAN, v1::PixelFilter::MITCHELL,
                          v1::PixelFilter::LANCZOS}) {
    filter.set_kind(kind);
    EXPECT_EQ(reconstruction(), several) << kind;
  }
  filter.set_kind(v1::PixelFilter::GAUSSIAN);
  filter.set_sigma(0.2f);
  EXPECT_EQ(reconstruction(), one) << "narrow";
  filter.set_sigma(0.5f);
  filter.set_radius_x(0.5f);
  EXPECT_EQ(reconstruction(), one) << "narrow one way";
  filter.set_radius_x(40);
  EXPECT_EQ(reconstruction(), one) << "too wide";
  filter.set_radius_x(2);
  JobSettings request;
  request.tile_size = 16;
  EXPECT_EQ(reconstruction(request).second, 16u);
  request.settings.set_noise(0.1);
  EXPECT_EQ(reconstruction(request).first, v1::RECONSTRUCTION_SCATTER);
  request = {};
  request.settings.set_reconstruction(v1::RECONSTRUCTION_SAMPLE);
  EXPECT_EQ(reconstruction(request), one);
  request = {};
  request.settings.set_integrator("bdpt");
  EXPECT_EQ(reconstruction(request), one);

  request.settings.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  EXPECT_THAT(std::string(prepare_job(request, scene, "").status().message()),
              HasSubstr("integrator 'bdpt' has its own way from samples to pixels"));
  request.several_integrators = true;
  EXPECT_EQ(reconstruction(request), one);
  request = {};
  request.settings.set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  filter.set_radius_x(17);
  const auto wide = prepare_job(request, scene, "");
  EXPECT_EQ(wide.status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_THAT(std::string(wide.status().message()), HasSubstr("the pixel filter's radius is 17"));
  scene.scene.mutable_settings()->set_reconstruction(v1::RECONSTRUCTION_SCATTER);
  EXPECT_EQ(prepare_job({}, scene, "").status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(AlgorithmSettings, LightPassesGlassUnbentWithAWarning) {
  const ImportedScene scene = scene_of(64, 64);
  JobSettings request;
  request.settings.set_glass_shadows(v1::GLASS_SHADOWS_STRAIGHT);
  const auto job = prepare_job(request, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.content().algorithms().glass_shadows(), v1::GLASS_SHADOWS_STRAIGHT);
  EXPECT_THAT((*job)->warnings, testing::Contains(HasSubstr("the picture is an approximation")));
  request.settings.set_integrator("bdpt");
  EXPECT_THAT(std::string(prepare_job(request, scene, "").status().message()),
              HasSubstr("glass_shadows 'straight' is not for it"));
  request.several_integrators = true;
  EXPECT_TRUE(prepare_job(request, scene, "").ok());
}

TEST(AlgorithmSettings, PixelsShareLightWhereTheIntegratorCanAndNoLayersAreAskedFor) {
  const ImportedScene scene = scene_of(64, 64);
  const auto sharing = [&](const JobSettings& request = {}) {
    const auto job = prepare_job(request, scene, "");
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? (*job)->spec.view().path_sharing() : v1::PATH_SHARING_AUTO;
  };
  EXPECT_EQ(sharing(), v1::PATH_SHARING_AUTO);
  JobSettings request;
  request.settings.set_noise(0.1);
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_AUTO);
  request = {};
  request.aovs = {v1::AOV_VARIANCE};
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_OFF);
  request = {};
  request.denoise = DenoiseMethod::kStatistical;
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_AUTO);
  request = {};
  request.settings.set_path_sharing(v1::PATH_SHARING_OFF);
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_OFF);
  request.settings.set_path_sharing(v1::PATH_SHARING_16);
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_16);
  request.settings.set_integrator("guided");
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_16);
  request.settings.set_integrator("bdpt");
  EXPECT_THAT(std::string(prepare_job(request, scene, "").status().message()),
              HasSubstr("integrator 'bdpt' has no paths that pixels share"));
  request.several_integrators = true;
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_OFF);
  request = {};
  request.settings.set_integrator("bdpt");
  EXPECT_EQ(sharing(request), v1::PATH_SHARING_OFF);
}

TEST(AlgorithmSettings, WarnsWherePixelsDoNotShareLightForWhatIsAskedForBesideThePicture) {
  const ImportedScene scene = scene_of(64, 64);
  const auto warnings = [&](const JobSettings& request) {
    const auto job = prepare_job(request, scene, "");
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() ? (*job)->warnings : std::vector<std::string>{};
  };
  JobSettings request;
  request.aovs = {v1::AOV_ALBEDO, v1::AOV_DEPTH, v1::AOV_NORMAL};
  EXPECT_THAT(warnings(request), IsEmpty());  // these share
  request.aovs = {v1::AOV_VARIANCE};
  EXPECT_THAT(warnings(request),
              ElementsAre(HasSubstr("do not share the light of their paths, because of --aov variance")));
  request.aovs = {};
  request.layers.shadow = true;
  EXPECT_THAT(warnings(request),
              ElementsAre(HasSubstr("do not share the light of their paths, because of layers")));
  // Nothing is lost where none would have shared.
  request.settings.set_path_sharing(v1::PATH_SHARING_OFF);
  EXPECT_THAT(warnings(request), IsEmpty());
  request.settings.clear_path_sharing();
  request.settings.set_max_depth(1);
  EXPECT_THAT(warnings(request), IsEmpty());
  request.settings.clear_max_depth();
  request.settings.set_integrator("bdpt");
  EXPECT_THAT(warnings(request), IsEmpty());
}

TEST(AlgorithmSettings, IrradianceCachesHaveDefaultsAndWhatTheSceneAsksFor) {
  ImportedScene scene = scene_of(64, 64);
  scene.scene.mutable_settings()->set_integrator("irradiance-cache");
  scene.scene.mutable_settings()->mutable_irradiance_cache()->set_samples(256);
  JobSettings request;
  request.settings.mutable_irradiance_cache()->set_error(0.5);
  const auto job = prepare_job(request, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  const v1::IrradianceCache& cache = (*job)->spec.content().algorithms().irradiance_cache();
  EXPECT_EQ(cache.error(), 0.5);
  EXPECT_EQ(cache.samples(), 256u);
  EXPECT_EQ(cache.most_reach(), 32);
  EXPECT_EQ(cache.glossy_bands(), 8u);
  EXPECT_EQ((*job)->spec.cut().phases_size(), 2);
  // Another integrator has no use for what the scene asks for, and it changes nothing for it.
  request.settings.clear_irradiance_cache();
  request.settings.set_integrator("path");
  const auto other = prepare_job(request, scene, "");
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_FALSE((*other)->spec.content().algorithms().has_irradiance_cache());
}

TEST(AlgorithmSettings, CachesThatMakeNoSenseAreRefused) {
  const ImportedScene scene = scene_of(64, 64);
  const auto refusal = [&](auto change) {
    JobSettings request;
    request.settings.set_integrator("irradiance-cache");
    change(request);
    const auto job = prepare_job(request, scene, "");
    EXPECT_EQ(job.status().code(), absl::StatusCode::kOutOfRange);
    return std::string{job.status().message()};
  };
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_error(0); }),
              HasSubstr("irradiance-cache.error is 0;"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_error(-1); }),
              HasSubstr("irradiance-cache.error is -1"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_error(NAN); }),
              HasSubstr("irradiance-cache.error is nan"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_samples(15); }),
              HasSubstr("samples is 15; 16 to 65536"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_least_reach(0); }),
              HasSubstr("least-reach is 0;"));
  EXPECT_THAT(refusal([](JobSettings& r) {
                r.settings.mutable_irradiance_cache()->set_least_reach(4);
                r.settings.mutable_irradiance_cache()->set_most_reach(3);
              }),
              HasSubstr("most-reach is 3; 4 to"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_glossy_bands(1); }),
              HasSubstr("glossy-bands is 1; 0 or 2 to 12"));
  EXPECT_THAT(refusal([](JobSettings& r) { r.settings.mutable_irradiance_cache()->set_glossy_bands(13); }),
              HasSubstr("glossy-bands is 13;"));
  EXPECT_THAT(refusal([](JobSettings& r) {
                r.settings.set_integrator("path");
                r.settings.mutable_irradiance_cache()->set_view(true);
              }),
              HasSubstr("integrator 'path' has no settings 'irradiance-cache'"));
}

TEST(AlgorithmSettings, OptionsOfOneIntegratorAreRefusedWithAnother) {
  const ImportedScene scene = scene_of(64, 64);
  const auto prepared = [&](const std::string& integrator, bool several, auto change) {
    JobSettings request;
    request.settings.set_integrator(integrator);
    request.several_integrators = several;
    change(request.settings);
    return prepare_job(request, scene, "");
  };
  const auto check = [&](const std::string& own, auto change) {
    EXPECT_TRUE(prepared(own, false, change).ok()) << prepared(own, false, change).status();
    const auto refused = prepared("volpath", false, change);
    EXPECT_EQ(refused.status().code(), absl::StatusCode::kOutOfRange);
    EXPECT_THAT(std::string{refused.status().message()},
                HasSubstr("integrator 'volpath' has no settings '" + own + "'"));
    EXPECT_TRUE(prepared("volpath", true, change).ok());
  };
  using Settings = v1::RenderSettings;
  check("photon", [](Settings& own) { own.mutable_photon()->set_radius(1); });
  check("photon", [](Settings& own) { own.mutable_photon()->set_map(v1::PHOTON_MAP_CLASSIC); });
  check("mlt", [](Settings& own) { own.mutable_mlt()->set_mutations(64); });
  check("radiosity", [](Settings& own) { own.mutable_radiosity()->set_ignore_non_diffuse(true); });
  check("irradiance-cache", [](Settings& own) { own.mutable_irradiance_cache()->set_samples(64); });
  check("ao", [](Settings& own) { own.mutable_ao()->set_distance(0); });
  check("guided", [](Settings& own) { own.mutable_guided()->set_samples(2); });
}

TEST(AlgorithmSettings, AnOptionOfZeroIsAskedFor) {
  ImportedScene scene = scene_of(64, 64);
  scene.scene.mutable_settings()->mutable_ao()->set_distance(3);
  JobSettings request;
  request.settings.set_integrator("ao");
  request.settings.mutable_ao()->set_distance(0);
  const auto job = prepare_job(request, scene, "");
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ((*job)->spec.content().algorithms().ao().distance(), 0);
}

TEST(AlgorithmSettings, LightIsSentIntoLensesThatHaveGhosts) {
  ImportedScene scene = scene_of(64, 64);
  scene.scene.mutable_camera()->mutable_lens()->set_ghosts(true);
  const auto found = [&](const JobSettings& request) {
    const auto job = prepare_job(request, scene, "");
    EXPECT_TRUE(job.ok()) << job.status();
    return job.ok() && (*job)->spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS;
  };
  JobSettings request;
  EXPECT_TRUE(found(request));
  const auto job = prepare_job(request, scene, "");
  EXPECT_TRUE(wire::works_in_passes((*job)->spec));
  EXPECT_EQ((*job)->spec.view().path_sharing(), v1::PATH_SHARING_OFF);
  EXPECT_TRUE((*job)->warnings.empty());
  request.settings.set_noise(0.1);
  EXPECT_FALSE(found(request));
  request = {};
  request.settings.set_path_sharing(v1::PATH_SHARING_8);
  EXPECT_FALSE(found(request));
  request = {};
  request.settings.set_lens_ghosts(v1::LENS_GHOSTS_FILM);
  EXPECT_FALSE(found(request));
  request.settings.set_lens_ghosts(v1::LENS_GHOSTS_LIGHTS);
  EXPECT_TRUE(found(request));
  request.settings.set_noise(0.1);
  EXPECT_THAT(std::string(prepare_job(request, scene, "").status().message()),
              HasSubstr("lens_ghosts 'lights' does not go with noise"));
  request.settings.clear_noise();
  request.settings.set_integrator("whitted");
  EXPECT_THAT(std::string(prepare_job(request, scene, "").status().message()),
              HasSubstr("integrator 'whitted' sends no light into the lens"));
  scene.scene.mutable_camera()->mutable_lens()->clear_ghosts();
  EXPECT_FALSE(found({}));
}

}  // namespace
}  // namespace tessera::client
