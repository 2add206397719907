// Records of incoming radiance at glossy surfaces against path tracing, and their bits however they are made.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "statistical/reference/picture.h"
#include "support/picture/phases.h"
#include "support/picture/render_image.h"

namespace tessera::test::glossy_cache {  // apart from tests that are compiled with these
namespace {

/// A round room with a floor of metal, a varnished ball, one of coated metal and one with Blinn's lobe, a
/// mixture, and a lamp above. `alpha` is the facets' roughness.
std::string glossy_room(double alpha) {
  const auto rough = [&](const char* name = "roughness") {
    return absl::StrCat(name, " { u { constant: ", alpha, " } v { constant: ", alpha, " } }");
  };
  const auto ball = [](double x, double z, const char* material) {
    return absl::StrCat(" shapes { sphere { radius: 0.6 } material: '", material,
                        "' world_from_object { elements: [1,0,0,", x, ", 0,1,0,-0.4, 0,0,1,", z,
                        ", 0,0,0,1] } }");
  };
  return absl::StrCat(
      R"(
      camera { perspective { fov_degrees: 60 }
        world_from_camera { elements: [1,0,0,0, 0,1,0,0, 0,0,1,-3, 0,0,0,1] } }
      materials { name: 'paint' diffuse { reflectance { constant { rgb { r: 0.8 g: 0.6 b: 0.3 } } } } }
      materials { name: 'metal' conductor { reflectance { constant { constant: 0.8 } } )",
      rough(), R"( } }
      materials { name: 'varnish' coated_diffuse { reflectance { constant { constant: 0.4 } }
        eta { constant: 1.5 } )",
      rough(), R"( } }
      materials { name: 'blinn' phong { diffuse { constant { constant: 0.3 } }
        specular { constant { constant: 0.4 } }
                                        exponent { constant: )",
      2 / (alpha * alpha), R"( } lobe: BLINN } }
      materials { name: 'both' mix { a: 'paint' b: 'metal' amount { constant: 0.5 } } }
      shapes { sphere { radius: 4 } material: 'paint' }
      shapes { disk { radius: 3 } material: 'metal'
        world_from_object { elements: [1,0,0,0, 0,0,1,-1, 0,-1,0,0, 0,0,0,1] } }
      lights { point { position { x: 0 y: 2 z: -1 } intensity { constant: 20 } } })",
      ball(-0.9, 0.3, "varnish"), ball(0.5, 0.6, "blinn"), ball(1.1, -0.6, "both"));
}

constexpr double kWide = 0.4, kNarrow = 0.2;  // the default, 8 bands, keeps lobes from 0.25 on

PictureRequest request(const std::string& integrator, std::uint32_t seed) {
  PictureRequest request;
  request.scene = glossy_room(kWide);
  request.integrator = integrator;
  request.max_depth = 32;  // records hold the light of an event more: 0.8^32 of it
  request.spp = 2048;
  request.seed = seed;
  // Half of the usual error: with that, blocks are up to 6 % off, by which records there are, and these
  // differ between processors.
  request.settings = " irradiance_cache { error: 0.15 } ";
  return request;
}

TEST(GlossyCache, GlossyRoomsAreThoseOfPathTracing) {
  const Picture expected = measure_picture(request("path", 0));
  for (const std::uint32_t seed : {1, 2, 3}) {
    const Picture got = measure_picture(request("irradiance-cache", seed));
    expect_same(got, expected, 0.03);  // blocks
    for (int channel = 0; channel < 3; ++channel) {
      const auto &a = got.whole(channel), &b = expected.whole(channel);
      EXPECT_NEAR(a.mean, b.mean, 0.01 * b.mean + 6 * std::hypot(a.error, b.error)) << channel;
    }
  }
}

LoadedFile small_room(double alpha, std::uint32_t bands, bool view = false, std::uint32_t spp = 4) {
  SceneJob job;
  job.settings.set_integrator("irradiance-cache");
  job.settings.set_spp(spp);
  job.settings.set_max_depth(12);
  job.settings.mutable_irradiance_cache()->set_glossy_bands(bands);
  if (view) job.settings.mutable_irradiance_cache()->set_view(true);
  auto file =
      load_scene_text(absl::StrCat(glossy_room(alpha), " film { width: 48 height: 48 filter { kind: BOX } }"),
                      job, render::supported_isas().front());
  EXPECT_TRUE(file.ok()) << file.status();
  return *std::move(file);
}

constexpr std::size_t kHeaderBytes = 16, kEvenBytes = 116;

std::uint64_t number_at(const std::string& blob, std::size_t at) {
  std::uint64_t number = 0;
  EXPECT_LE(at + sizeof(number), blob.size());
  std::memcpy(&number, blob.data() + at, sizeof(number));
  return number;
}
/// Records at glossy surfaces, which come after the others.
std::uint64_t glossy_records(const std::string& blob) {
  return number_at(blob, kHeaderBytes + number_at(blob, 8) * kEvenBytes + 8);
}

TEST(GlossyCache, OnlyLobesThatTheHarmonicsKeepHaveRecords) {
  EXPECT_GT(glossy_records(make_phases(small_room(kWide, 8)).blobs.front()), 20u);
  EXPECT_EQ(glossy_records(make_phases(small_room(kNarrow, 8)).blobs.front()), 0u);
  EXPECT_GT(glossy_records(make_phases(small_room(kNarrow, 12)).blobs.front()), 20u) << "2 / 12 is narrower";
  EXPECT_EQ(glossy_records(make_phases(small_room(kWide, 0)).blobs.front()), 0u);
}

TEST(GlossyCache, PhasesHaveOneResultHoweverTheyAreMade) { expect_one_result(small_room(kWide, 8), 48); }

TEST(GlossyCache, BlobsOfOtherBandsAreRefused) {
  const LoadedFile file = small_room(kWide, 8), other = small_room(kWide, 6);
  const std::vector<std::string> own = make_phases(file).blobs, others = make_phases(other).blobs;
  const std::string_view mixed[] = {own[0], others[1]}, sound[] = {own[0], own[1]};
  EXPECT_TRUE(file.scene->prepare(sound).ok());
  EXPECT_FALSE(file.scene->prepare(mixed).ok());
  EXPECT_FALSE(file.scene->merge(0, mixed).ok());
  EXPECT_FALSE(other.scene->prepare(sound).ok());
}

TEST(GlossyCache, TheViewShowsRecordsOfGlossySurfaces) {
  // Below is the floor, of metal, which the lamp shines on: one sample is red alone where it meets a record
  // there. Paths that go on from the floor add the lamp's light to whatever red they find.
  const auto red_alone = [](bool view) {
    const LoadedFile file = small_room(kWide, 8, view, 1);
    const MadePhases phases = make_phases(file);
    const client::Image image = render_image(file, 0, phases.prepared.get());
    const std::vector<float>&r = image.find("R")->values, &g = image.find("G")->values;
    int count = 0;
    for (std::size_t i = 48 * 40; i < 48 * 48; ++i) count += r[i] > 0 && g[i] == 0;
    return count;
  };
  EXPECT_GT(red_alone(true), 20);
  EXPECT_EQ(red_alone(false), 0);
}

}  // namespace
}  // namespace tessera::test::glossy_cache
