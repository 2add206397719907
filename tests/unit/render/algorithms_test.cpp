// The one list of algorithms, from both of its sides.
#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "render/kernel/kernel.h"
#include "render/renderer.h"
#include "wire/algorithm.h"
#include "wire/job_check.h"
#include "wire/resolve_settings.h"
#include "wire/settings.h"

namespace tessera::render {
namespace {

using testing::HasSubstr;

TEST(Algorithms, KernelsOfEveryIsaHaveThemAll) {
  std::vector<std::string> names;
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) names.emplace_back(traits.name);
  for (const std::string& isa : supported_isas()) {
    std::vector<std::string> own;
    for (const Algorithm& algorithm : find_kernel(isa)->algorithms) own.emplace_back(algorithm.name);
    EXPECT_THAT(own, testing::UnorderedElementsAreArray(names)) << isa;
  }
}

TEST(Algorithms, KernelsForWavelengthsHaveThoseThatCarryThem) {
  for (const std::string& isa : supported_isas()) {
    std::set<std::string> own;
    for (const Algorithm& algorithm : find_kernel(isa, KernelLight::kWavelengths)->algorithms)
      own.emplace(algorithm.name);
    for (const wire::AlgorithmTraits& traits : wire::algorithms())
      EXPECT_EQ(own.contains(traits.name), traits.wavelengths) << traits.name << ", " << isa;
  }
}

TEST(Algorithms, WhatCarriesNoWavelengthsSaysWhy) {
  const auto fault = [](const std::string& settings) {
    v1::RenderSettings asked;
    EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString("color: COLOR_SPECTRAL " + settings, &asked));
    v1::JobSpec job;
    wire::resolve_settings(asked, job);
    wire::add_phases(job);
    return std::string(wire::check_settings(job).message());
  };
  EXPECT_EQ(fault("integrator: 'vcm'"), "");
  EXPECT_THAT(
      fault("integrator: 'irradiance-cache'"),
      HasSubstr("'irradiance-cache' carries red, green and blue, as records of its cache are met by paths "
                "of all wavelengths: color 'spectral' is for path, "));
  EXPECT_THAT(fault("integrator: 'radiosity'"), HasSubstr("as light of its patches is met by paths"));
  EXPECT_EQ(fault("integrator: 'photon'"), "");
  EXPECT_THAT(fault("integrator: 'photon' photon { map: PHOTON_MAP_CLASSIC }"),
              HasSubstr("one set of wavelengths for the whole picture"));
}

TEST(Algorithms, TheFirstIsTheDefault) {
  EXPECT_EQ(wire::find_algorithm(""), wire::algorithms().data());
  EXPECT_EQ(wire::find_algorithm("nosuch"), nullptr);
  EXPECT_THAT(std::string(wire::check_algorithm_name("nosuch").message()),
              HasSubstr("there is no integrator 'nosuch'"));
  EXPECT_THAT(std::string(wire::check_algorithm_name("preview").message()),
              HasSubstr("there is no integrator 'preview' any more; 'raycast' shows"));
}

/// Whether each algorithm takes a job is what its traits say.
TEST(Algorithms, JobsAreHeldAgainstTheirTraits) {
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    v1::RenderSettings asked;
    asked.set_integrator(traits.name);
    v1::JobSpec job;
    wire::resolve_settings(asked, job);
    wire::add_phases(job);
    EXPECT_TRUE(wire::check_settings(job).ok()) << traits.name;
    EXPECT_EQ(wire::works_in_passes(job), traits.work == wire::WorkKind::kPasses);

    v1::JobSpec noisy = job;
    noisy.mutable_samples()->set_noise(0.1);
    noisy.mutable_samples()->set_spp(16);
    noisy.mutable_cut()->set_samples_per_unit(16);
    noisy.mutable_cut()->set_tile_size(8);
    wire::add_phases(noisy);
    EXPECT_EQ(wire::check_settings(noisy).ok(), traits.noise) << traits.name;

    v1::JobSpec coloured = job;
    coloured.mutable_content()->mutable_algorithms()->set_color(v1::COLOR_SPECTRAL);
    EXPECT_EQ(wire::check_settings(coloured).ok(), traits.wavelengths) << traits.name;

    v1::JobSpec scattered = job;
    scattered.mutable_view()->set_reconstruction(v1::RECONSTRUCTION_SCATTER);
    EXPECT_EQ(wire::check_settings(scattered).ok(), traits.scatters) << traits.name;
    v1::JobSpec sharing = job;
    sharing.mutable_view()->set_path_sharing(v1::PATH_SHARING_8);
    EXPECT_EQ(wire::check_settings(sharing).ok(), traits.shares_paths) << traits.name;
    if (traits.scatters) {
      v1::JobSpec both = noisy;
      both.mutable_view()->set_reconstruction(v1::RECONSTRUCTION_SCATTER);
      EXPECT_TRUE(wire::check_settings(both).ok()) << traits.name;
    }

    v1::JobSpec by_chance = job;
    by_chance.mutable_content()->mutable_algorithms()->set_direct_light(v1::DIRECT_LIGHT_BSDF);
    EXPECT_EQ(wire::check_settings(by_chance).ok(), traits.bsdf_lighting) << traits.name;

    v1::JobSpec straight = job;
    straight.mutable_content()->mutable_algorithms()->set_glass_shadows(v1::GLASS_SHADOWS_STRAIGHT);
    EXPECT_EQ(wire::check_settings(straight).ok(), traits.straight_shadows) << traits.name;
    EXPECT_EQ(wire::kind_of(straight.content().algorithms()), "biased");
    EXPECT_EQ(wire::kind_of(job.content().algorithms()), wire::word_of(traits.bias));

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

TEST(Algorithms, EachHasItsOwnSettingsAlone) {
  v1::RenderSettings asked;
  asked.mutable_photon()->set_radius(0.5);
  asked.mutable_mlt()->set_mutations(5);
  asked.mutable_radiosity()->set_residual(0.5);
  asked.mutable_irradiance_cache()->set_error(0.5);
  asked.mutable_ao()->set_distance(0.5);
  asked.mutable_guided()->set_samples(0.5);
  for (const wire::AlgorithmTraits& traits : wire::algorithms()) {
    // Settings of a scene wait for an algorithm that has such settings; a job has its own alone.
    v1::JobSpec job;
    asked.set_integrator(traits.name);
    wire::resolve_settings(asked, job);
    wire::add_phases(job);
    EXPECT_TRUE(wire::check_settings(job).ok()) << traits.name << wire::check_settings(job);
    v1::Algorithms& algorithms = *job.mutable_content()->mutable_algorithms();
    const wire::FieldType* const own = wire::own_settings(*v1::Algorithms::descriptor(), traits.name);
    std::vector<const wire::FieldType*> present;
    algorithms.GetReflection()->ListFields(algorithms, &present);
    std::erase_if(present, [](const wire::FieldType* field) { return field->message_type() == nullptr; });
    EXPECT_EQ(present, own == nullptr ? std::vector<const wire::FieldType*>{} : std::vector{own})
        << traits.name;
    EXPECT_FALSE(wire::check_owner(asked, traits.name).ok()) << traits.name;

    if (own != nullptr) {
      v1::JobSpec without;
      without.mutable_content()->mutable_algorithms()->set_integrator(traits.name);
      wire::add_phases(without);
      EXPECT_THAT(std::string(wire::check_settings(without).message()), HasSubstr("the job has none"));
    }
    if (traits.name == std::string("photon")) {
      EXPECT_EQ(algorithms.photon().radius(), 0.5);
      EXPECT_EQ(algorithms.photon().map(), v1::PHOTON_MAP_PROGRESSIVE);
    } else {
      algorithms.mutable_photon()->set_photons(100);
      EXPECT_THAT(std::string(wire::check_settings(job).message()),
                  HasSubstr("has no settings 'photon', which are for 'photon'"));
    }
  }
}

TEST(Algorithms, PhotonSettingsAreInRange) {
  const auto fault = [](const auto& set) {
    v1::JobSpec job;
    job.mutable_content()->mutable_algorithms()->set_integrator("photon");
    set(*job.mutable_content()->mutable_algorithms()->mutable_photon());
    return std::string(wire::check_settings(job).message());
  };
  for (const double radius : {-1.0, 0.0, 1e-30, 1e30, std::nan(""), HUGE_VAL}) {
    EXPECT_THAT(fault([&](v1::PhotonSettings& photon) { photon.set_radius(radius); }),
                HasSubstr("photon.radius is "));
    EXPECT_THAT(fault([&](v1::PhotonSettings& photon) { photon.set_caustic_radius(radius); }),
                HasSubstr("photon.caustic-radius is "));
  }
  for (const std::uint64_t photons : {std::uint64_t{0}, std::uint64_t{1} << 40}) {
    EXPECT_THAT(fault([&](v1::PhotonSettings& photon) { photon.set_photons(photons); }),
                HasSubstr("1 to 1073741824 was expected"));
  }
  EXPECT_THAT(fault([](v1::PhotonSettings& photon) { photon.set_map(static_cast<v1::PhotonMap>(9)); }),
              HasSubstr("map is number 9"));
}

TEST(Algorithms, MetropolisSettingsAreInRange) {
  using Settings = v1::MetropolisSettings;
  const auto fault = [](const auto& set) {
    v1::RenderSettings asked;
    asked.set_integrator("mlt");
    v1::JobSpec job;
    wire::resolve_settings(asked, job);
    set(*job.mutable_content()->mutable_algorithms()->mutable_mlt());
    return std::string(wire::check_settings(job).message());
  };
  EXPECT_EQ(fault([](Settings&) {}), "");
  for (const std::uint32_t many : {0u, (1u << 20) + 1}) {
    EXPECT_THAT(fault([&](Settings& s) { s.set_mutations(many); }), HasSubstr("mlt.mutations is"));
    EXPECT_THAT(fault([&](Settings& s) { s.set_candidates(many); }), HasSubstr("mlt.candidates is"));
  }
  for (const double bad : {0.0, -1.0, 1.5, std::nan("")}) {
    EXPECT_THAT(fault([&](Settings& s) { s.set_large_steps(bad); }), HasSubstr("mlt.large-steps is"));
    EXPECT_THAT(fault([&](Settings& s) { s.set_step(bad); }), HasSubstr("mlt.step is"));
  }
}

}  // namespace
}  // namespace tessera::render
