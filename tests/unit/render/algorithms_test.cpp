// The one list of algorithms, from both of its sides.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "render/integrator/kernel.h"
#include "render/renderer.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"

namespace tessera::render {
namespace {

using testing::HasSubstr;

TEST(Algorithms, KernelsOfEveryIsaHaveThemAll) {
  std::vector<std::string> names;
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) names.emplace_back(traits.name);
  for (const std::string& isa : supported_isas()) {
    std::vector<std::string> own;
    for (const Algorithm& algorithm : find_kernel(isa)->algorithms) own.emplace_back(algorithm.name);
    EXPECT_EQ(own, names) << isa;
  }
}

TEST(Algorithms, TheFirstIsTheDefault) {
  EXPECT_EQ(wire::find_algorithm(""), wire::algorithms().data());
  EXPECT_EQ(wire::find_algorithm("nosuch"), nullptr);
  EXPECT_THAT(std::string(wire::check_algorithm_name("nosuch").message()),
              HasSubstr("there is no integrator 'nosuch'"));
}

/// Whether each algorithm takes a job is what its traits say.
TEST(Algorithms, JobsAreHeldAgainstTheirTraits) {
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    v1::RenderSettings wishes;
    wishes.set_integrator(traits.name);
    v1::JobSpec job;
    wire::resolve_settings(wishes, job);
    wire::add_phases(job);
    EXPECT_TRUE(wire::check_settings(job).ok()) << traits.name;
    EXPECT_EQ(wire::works_in_passes(job), traits.work == wire::WorkKind::kPasses);

    v1::JobSpec noisy = job;
    noisy.mutable_samples()->set_noise(0.1);
    noisy.mutable_samples()->set_spp(16);
    noisy.mutable_cut()->set_samples_per_unit(16);
    noisy.mutable_cut()->set_tile_size(8);
    EXPECT_EQ(wire::check_settings(noisy).ok(), traits.noise) << traits.name;

    v1::JobSpec by_chance = job;
    by_chance.mutable_content()->mutable_algorithms()->set_direct_light(v1::DIRECT_LIGHT_BSDF);
    EXPECT_EQ(wire::check_settings(by_chance).ok(), traits.bsdf_lighting) << traits.name;

    for (const v1::AOV aov : {v1::AOV_ALBEDO, v1::AOV_NORMAL, v1::AOV_DEPTH, v1::AOV_ID}) {
      v1::JobSpec layered = job;
      layered.mutable_view()->add_aovs(aov);
      EXPECT_EQ(wire::check_settings(layered).ok(), traits.first_hit_aovs) << traits.name << " " << aov;
    }
    v1::JobSpec variance = job;
    variance.mutable_view()->add_aovs(v1::AOV_VARIANCE);
    EXPECT_TRUE(wire::check_settings(variance).ok()) << traits.name;

    v1::JobSpec layered = job;
    v1::Layer& layer = *layered.mutable_view()->add_layers();
    layer.set_name("seen");
    layer.set_expression("LE");
    EXPECT_EQ(wire::check_settings(layered).ok(), traits.layers != wire::LayerStates::kNone) << traits.name;

    v1::JobSpec in_phases = job;
    in_phases.mutable_cut()->add_phases()->set_name("guide");
    EXPECT_THAT(std::string(wire::check_settings(in_phases).message()),
                HasSubstr("has other phases than the job"))
        << traits.name;
  }
}

TEST(Algorithms, PhotonSettingsAreForThoseWithPhotonsAndInRange) {
  v1::RenderSettings wishes;
  wishes.mutable_photon()->set_radius(0.5);
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    // A scene's wishes wait for an algorithm that has photons; a job must not have them for another.
    v1::JobSpec job;
    wishes.set_integrator(traits.name);
    wire::resolve_settings(wishes, job);
    wire::add_phases(job);
    EXPECT_EQ(job.content().algorithms().has_photon(), traits.photons) << traits.name;
    EXPECT_TRUE(wire::check_settings(job).ok()) << traits.name;
    job.mutable_content()->mutable_algorithms()->mutable_photon()->set_photons(100);
    EXPECT_EQ(wire::check_settings(job).ok(), traits.photons) << traits.name;
    if (traits.photons) {
      EXPECT_EQ(job.content().algorithms().photon().radius(), 0.5);
      EXPECT_EQ(job.content().algorithms().photon().map(), v1::PHOTON_MAP_PROGRESSIVE);
    } else {
      EXPECT_THAT(std::string(wire::check_settings(job).message()), HasSubstr("traces no photons"));
    }
  }
  const auto fault = [](const auto& set) {
    v1::JobSpec job;
    job.mutable_content()->mutable_algorithms()->set_integrator("photon");
    set(*job.mutable_content()->mutable_algorithms()->mutable_photon());
    return std::string(wire::check_settings(job).message());
  };
  for (const double radius : {-1.0, 0.0, 1e-30, 1e30, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(fault([&](v1::PhotonSettings& photon) { photon.set_radius(radius); }),
                HasSubstr("photon.radius is "));
  }
  for (const std::uint64_t photons : {std::uint64_t{0}, std::uint64_t{1} << 40}) {
    EXPECT_THAT(fault([&](v1::PhotonSettings& photon) { photon.set_photons(photons); }),
                HasSubstr("1 to 1073741824 was expected"));
  }
  EXPECT_THAT(fault([](v1::PhotonSettings& photon) { photon.set_map(static_cast<v1::PhotonMap>(9)); }),
              HasSubstr("map is number 9"));
}

}  // namespace
}  // namespace tessera::render
