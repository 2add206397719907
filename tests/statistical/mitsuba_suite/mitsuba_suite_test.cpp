// Mitsuba 3's own render tests: every scene at the suite's number of samples, held against its reference. The
// corpus lies beside the project; without it the tests are skipped by name.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "image/exr.h"
#include "support/needs.h"
#include "support/render_image.h"
#include "support/unpacked_corpus.h"
#include "support/ztest.h"

namespace tessera::test {
namespace {

// The suite renders this many samples a scene.
constexpr std::uint32_t kSamples = 2'000'000;

constexpr const char* kScenes[] = {"bsdf_spheres/test_arealight_path",
                                   "bsdf_spheres/test_bumpmap_path",
                                   "bsdf_spheres/test_constant_path",
                                   "bsdf_spheres/test_envmap_path",
                                   "bsdf_spheres/test_normalmap_path",
                                   "bsdf_spheres/test_roughplastic_linear_path",
                                   "bsdf_spheres/test_textured_diffuse_path",
                                   "bsdf_spheres/test_texturedprincipled1_path",
                                   "floating_sphere/test_directional_direct",
                                   "instancing/test_instancing_path",
                                   "mesh_attributes/test_mesh_attributes_1_face_direct",
                                   "mesh_attributes/test_mesh_attributes_3_vertex_direct",
                                   "participating_media/test_hetero_sigmat_volpath",
                                   "participating_media/test_homo_area_light_volpath",
                                   "participating_media/test_homo_dielectric_envmap_volpath",
                                   "participating_media/test_homo_null_envmap_volpath",
                                   "participating_media/test_homo_spectral_sigmat_volpathmis",
                                   "participating_media/test_surf_area_light_volpath",
                                   "projector/test_projector_constant_direct",
                                   "spot_light/test_spot_direct",
                                   "various_shapes/test_various_shapes_path"};

class MitsubaSuite : public testing::TestWithParam<const char*> {
 protected:
  static void SetUpTestSuite() { suite_ = find_corpus("mitsuba-suite"); }
  static void TearDownTestSuite() { suite_.reset(); }

  static inline std::optional<CorpusFolder> suite_;
};

/// As the suite is rendered: independent samples through the scene's own filter (the box, in all scenes but
/// one), with the variance of one sample. `least_spp`: more samples than the suite's, where those are fewer.
/// `box_filter` comes out.
client::Image render_scene(const std::filesystem::path& path, std::uint32_t least_spp, bool& box_filter) {
  v1::JobSpec job;
  job.mutable_settings()->set_sampler("independent");
  job.add_aovs("variance");
  const auto prepare = [&](v1::Scene& scene) {
    const std::uint32_t spp = kSamples / (scene.film().width() * scene.film().height());
    scene.mutable_settings()->set_spp(std::max(spp, least_spp));
    box_filter = scene.film().filter().kind() == v1::PixelFilter::BOX;
  };
  const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto file = load_scene_file(path.string(), job, render::supported_isas().front(), threads, prepare);
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  for (const std::string& warning : file->scene->warnings()) {
    // That borders of media are met by robust tests is as it should be.
    if (warning.find("--intersection") == std::string::npos) ADD_FAILURE() << warning;
  }
  return render_image(*file);
}

/// Three planes of an image; empty, with a failure, when one is missing.
ZImage planes(const client::Image& image, const std::string& prefix) {
  ZImage result{
      static_cast<std::size_t>(image.data.width()), static_cast<std::size_t>(image.data.height()), {}};
  result.rgb.resize(3 * image.pixel_count());
  for (std::size_t c = 0; c < 3; ++c) {
    const client::Channel* channel = image.find(prefix + "RGB"[c]);
    EXPECT_NE(channel, nullptr) << "no channel " << prefix << "RGB"[c];
    if (channel == nullptr) return {};
    for (std::size_t i = 0; i < channel->values.size(); ++i) result.rgb[3 * i + c] = channel->values[i];
  }
  return result;
}

/// A pixel's variance must be known better than a few lucky samples tell: where all of eight fell on one side
/// of an edge, they tell that there is none; and where the tail of a filter reaches over an edge, one sample
/// in thousands tells of it, as where light is scattered right before a lamp. It is a property of the
/// renderer, so a longer run may measure it.
std::uint32_t samples_for_variance(std::string_view scene, bool box_filter) {
  if (scene == "participating_media/test_homo_area_light_volpath") return 4096;
  return box_filter ? 256 : 16384;
}

TEST_P(MitsubaSuite, AgreesWithItsReference) {
  if (!suite_) GTEST_SKIP() << needs("../shared/scenes/mitsuba-suite.tar.xz");
  const std::filesystem::path scene = suite_->path() / "tests/scenes" / (std::string(GetParam()) + ".xml");
  bool box_filter = true;
  const client::Image image = render_scene(scene, 1, box_filter);
  if (image.channels.empty()) return;  // what failed has been said

  // test_NAME_INTEGRATOR.xml has the references refs/test_NAME_ref_rgb.exr and ..._var.exr.
  const std::string stem = scene.stem().string();
  const std::string reference =
      (scene.parent_path() / "refs" / stem.substr(0, stem.rfind('_'))).string() + "_ref_rgb";
  const auto mean = client::read_exr(reference + ".exr"), variance = client::read_exr(reference + "_var.exr");
  ASSERT_TRUE(mean.ok() && variance.ok()) << mean.status() << variance.status();
  ASSERT_EQ(mean->data.width(), image.data.width());
  ASSERT_EQ(mean->data.height(), image.data.height());

  // To look at a scene that fails.
  if (const char* folder = std::getenv("TESSERA_SUITE_IMAGES")) {
    EXPECT_TRUE(client::write_exr(image, std::string(folder) + "/" + stem + ".exr").ok());
  }
  const std::uint32_t least = samples_for_variance(GetParam(), box_filter);
  const client::Image longer =
      image.pixel_count() * least > kSamples ? render_scene(scene, least, box_filter) : image;
  if (longer.channels.empty()) return;
  ZOptions options;
  options.spp = kSamples / static_cast<std::uint32_t>(image.pixel_count());
  const ZResult result = z_test(planes(*mean, ""), planes(*variance, ""), planes(image, ""),
                                planes(longer, "variance."), options);
  EXPECT_TRUE(result.pass()) << result.report();
  std::printf("%s\n", result.report().c_str());
}

INSTANTIATE_TEST_SUITE_P(, MitsubaSuite, testing::ValuesIn(kScenes), [](const auto& scene) {
  std::string name = scene.param;
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
});

}  // namespace
}  // namespace tessera::test
