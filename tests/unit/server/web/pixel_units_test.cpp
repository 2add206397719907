#include "service/web/pixel_units.h"

#include <gtest/gtest.h>

#include "store/blobs/blob_store.h"

namespace tessera::server {
namespace {

/// Counts the bytes that are read.
class TextReader final : public BlobReader {
 public:
  explicit TextReader(std::string bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  absl::StatusOr<std::string> read(std::uint64_t offset, std::size_t size) const override {
    if (offset > bytes_.size()) return absl::OutOfRangeError("beyond the end");
    std::string piece = bytes_.substr(offset, size);
    bytes_read += piece.size();
    return piece;
  }
  mutable std::size_t bytes_read = 0;

 private:
  std::string bytes_;
};

v1::Scene scene_with(double cd_per_m2, double exposure = 1) {
  v1::Scene scene;
  scene.mutable_camera()->mutable_perspective();
  scene.mutable_film()->set_exposure(static_cast<float>(exposure));
  if (cd_per_m2 > 0) scene.mutable_units()->set_cd_per_m2(cd_per_m2);
  return scene;
}

v1::JobSpec rgb_job() {
  v1::JobSpec spec;
  spec.mutable_content()->mutable_algorithms()->set_color(v1::COLOR_RGB);
  return spec;
}

TEST(SceneHead, IsReadWithoutTheRestOfTheScene) {
  v1::Scene scene = scene_with(72983);
  scene.set_name(std::string(3'000'000, 'a'));
  scene.add_textures()->set_name(std::string(5'000'000, 'b'));
  for (int i = 0; i < 1000; ++i) scene.add_shapes()->set_name("shape " + std::to_string(i));
  const TextReader blob(scene.SerializeAsString());
  const auto head = read_scene_head(blob);
  ASSERT_TRUE(head.ok()) << head.status();
  EXPECT_EQ(head->units().cd_per_m2(), 72983);
  EXPECT_TRUE(head->camera().has_perspective());
  EXPECT_EQ(head->film().exposure(), 1);
  EXPECT_EQ(head->shapes_size(), 0);
  EXPECT_LT(blob.bytes_read, 1'000'000u) << "of 8 million";
}

TEST(SceneHead, RefusesWhatIsNoScene) {
  const std::string sound = scene_with(1).SerializeAsString();
  EXPECT_TRUE(read_scene_head(TextReader("")).ok()) << "an empty scene";
  for (std::size_t length = 1; length < sound.size(); ++length) {
    const auto head = read_scene_head(TextReader(sound.substr(0, length)));
    v1::Scene whole;
    EXPECT_EQ(head.ok(), whole.ParseFromString(sound.substr(0, length))) << length;
  }
  EXPECT_FALSE(read_scene_head(TextReader(std::string(100, '\xff'))).ok());
}

TEST(PixelUnits, AreThoseOfTheScene) {
  const PixelUnits usual = pixel_units_of(scene_with(0), rgb_job());
  EXPECT_EQ(usual.cd_per_m2, 683);
  EXPECT_EQ(usual.radiance, 1);
  EXPECT_NE(usual.about.find("does not say"), std::string::npos);
  EXPECT_NEAR(usual.weights[1], 0.7152, 1e-4);
  const PixelUnits said = pixel_units_of(scene_with(72983), rgb_job());
  EXPECT_EQ(said.cd_per_m2, 72983);
  EXPECT_EQ(said.radiance, 0) << "it is not in W/(m^2 sr)";
  EXPECT_EQ(said.about, "");
  const PixelUnits brighter = pixel_units_of(scene_with(683, 4), rgb_job());
  EXPECT_EQ(brighter.cd_per_m2, 683 / 4.0) << "without the film's exposure";
  EXPECT_EQ(brighter.radiance, 1 / 4.0);
}

TEST(PixelUnits, TakePhotographicExposuresBack) {
  v1::Scene scene = scene_with(0);
  scene.mutable_film()->clear_exposure();
  v1::PhotographicExposure& exposure = *scene.mutable_film()->mutable_photographic_exposure();
  exposure.set_f_number(8);
  exposure.set_shutter_seconds(0.01);
  exposure.set_iso(100);
  // docs/cameras.md: pixel = 0.018 S t pi / (4 N^2) L.
  const double pixel = 0.018 * 100 * 0.01 * M_PI / (4 * 64);
  const PixelUnits units = pixel_units_of(scene, rgb_job());
  EXPECT_NEAR(units.cd_per_m2, 1 / pixel, 1e-6 / pixel) << "its lights are in cd/m^2";
  EXPECT_EQ(units.radiance, 0);
  exposure.set_f_number(-1);
  EXPECT_EQ(pixel_units_of(scene, rgb_job()).cd_per_m2, 0);
}

TEST(PixelUnits, AreNoneOfASensorsOwnChannels) {
  v1::JobSpec spec = rgb_job();
  spec.mutable_content()->mutable_algorithms()->set_color(v1::COLOR_SPECTRAL);
  spec.mutable_view()->set_sensor("nikon-d5100");
  const PixelUnits camera = pixel_units_of(scene_with(683), spec);
  EXPECT_EQ(camera.cd_per_m2, 0);
  EXPECT_EQ(camera.weights[1], 0);
  EXPECT_NE(camera.about, "");
  spec.mutable_view()->set_sensor("cie1931");
  spec.mutable_view()->set_rgb_space(v1::RGB_SPACE_REC2020);
  EXPECT_NEAR(pixel_units_of(scene_with(683), spec).weights[1], 0.6780, 1e-4) << "of Rec.2020";
}

TEST(PixelUnits, AreTheUsualOnesWithoutAScene) {
  const PixelUnits units = usual_pixel_units(rgb_job());
  EXPECT_EQ(units.cd_per_m2, 683);
  EXPECT_NE(units.about.find("cannot be read any more"), std::string::npos);
}

}  // namespace
}  // namespace tessera::server
