// Files of light fields: what is written is read, damage is named, other versions are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "absl/strings/str_replace.h"
#include "light_field/tile_pixels.h"
#include "support/needs.h"
#include "support/process/process.h"
#include "unit/client/light_field/synthetic_set.h"

namespace tessera::client::light_field_test {
namespace {

using light_field::Compression;
using ::testing::HasSubstr;

constexpr ViewSize kSize{40, 24};  // tiles at the right and lower edges are cut

Shader test_plane() { return plane(5, 0, waves); }

TEST(LightFieldManifest, ComesBackAsItWas) {
  const support::TempDir directory;
  Manifest written = write_set(directory / "a.lf", grid_plan(3, 0.1, 5, kSize), kSize, test_plane());
  written.metres = 0.001;
  written.views[4].name = "middle";
  written.provenance.scene = "a \"scene\".pbrt";
  written.provenance.seed = ~std::uint64_t{0};
  written.provenance.defines = {"a=1"};
  const auto read = light_field::manifest_from_json(to_json(written));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(to_json(*read), to_json(written));
  EXPECT_EQ(read->provenance.seed, written.provenance.seed);
  for (std::size_t v = 0; v < written.views.size(); ++v) {
    EXPECT_EQ(read->views[v].camera, written.views[v].camera) << "to the last bit";
    EXPECT_EQ(read->views[v].tiles, written.views[v].tiles);
  }
}

TEST(LightFieldManifest, OfAnotherVersionIsRefusedWithBoth) {
  const support::TempDir directory;
  const Manifest manifest = write_set(directory / "a.lf", grid_plan(2, 0.1, 5, kSize), kSize, test_plane());
  const std::string json = to_json(manifest);
  const auto other =
      light_field::manifest_from_json(absl::StrReplaceAll(json, {{"\"version\": 1", "\"version\": 7"}}));
  EXPECT_THAT(std::string(other.status().message()), HasSubstr("version 7"));
  EXPECT_THAT(std::string(other.status().message()), HasSubstr("version 1"));
}

TEST(LightFieldManifest, SaysWhatIsWrongWithIt) {
  const support::TempDir directory;
  Manifest manifest = write_set(directory / "a.lf", grid_plan(2, 0.1, 5, kSize), kSize, test_plane());
  const auto fault = [](const Manifest& faulty) {
    return std::string(light_field::manifest_from_json(to_json(faulty)).status().message());
  };
  Manifest faulty = manifest;
  faulty.views[2].tiles.pop_back();
  EXPECT_THAT(fault(faulty), HasSubstr("view 2: it has 5 tiles, and its size has 6"));
  faulty = manifest;
  faulty.views[1].tiles[3].offset = faulty.views[1].file_bytes;
  EXPECT_THAT(fault(faulty), HasSubstr("view 1: tile 3 ends behind its file"));
  faulty = manifest;
  faulty.views[3].file = "../../etc/passwd";
  EXPECT_THAT(fault(faulty), HasSubstr("view 3: its file has no name"));
  faulty = manifest;
  faulty.arrangement.grids[0].rows = 3;
  EXPECT_THAT(fault(faulty), HasSubstr("grid 'plane' has 2 x 3 cameras"));
  faulty = manifest;
  faulty.tile_size = 24;
  EXPECT_THAT(fault(faulty), HasSubstr("powers of two"));
  faulty = manifest;
  faulty.views[0].camera.world_from_camera = {};
  EXPECT_THAT(fault(faulty), HasSubstr("view 0: its world_from_camera has no inverse"));
  EXPECT_FALSE(light_field::manifest_from_json("{").ok());
  EXPECT_FALSE(light_field::manifest_from_json("[]").ok());
  EXPECT_THAT(std::string(LightField::open(directory / "none.lf").status().message()),
              HasSubstr("there is no light field at"));
}

TEST(LightFieldFiles, HoldTheirPixels) {
  const support::TempDir directory;
  const CapturePlan plan = grid_plan(2, 0.1, 5, kSize);
  for (const Compression compression : {Compression::kNone, Compression::kZip}) {
    for (const bool half : {false, true}) {
      const std::string folder = directory / (std::string(word_of(compression)) + (half ? "-half" : ""));
      write_set(folder, plan, kSize, test_plane(), {compression, half});
      const auto field = open(folder);
      const Image truth = shaded(plan.cameras[3], kSize.width, kSize.height, test_plane());
      field->pixels(3).load();
      for (std::size_t i = 0; i < truth.pixel_count(); ++i) {
        const light_field::Rgba pixel = field->pixels(3).pixel(i);
        for (std::size_t c = 0; c < 4; ++c) {
          const float value = truth.channels[c].values[i];
          // A half has 11 significant bits.
          EXPECT_NEAR(pixel[c], value, half ? value / 2048 : 0) << i;
        }
        // All of the plane is at z = 5; the distance and its inverse are rounded.
        EXPECT_NEAR(field->pixels(3).inverse_z(i), 0.2f, 1e-6f);
      }
      EXPECT_TRUE(field->damage().empty());
    }
  }
}

TEST(LightFieldFiles, TellWhatDwaLoses) {
  const support::TempDir directory;
  const Manifest manifest = write_set(directory / "a.lf", grid_plan(2, 0.1, 5, kSize), kSize, test_plane(),
                                      {Compression::kDwaa, true});
  EXPECT_GT(manifest.psnr_db, 30) << "of what is smooth";
  const auto field = open(directory / "a.lf");
  field->pixels(0).load();
  // Depth is without loss.
  EXPECT_NEAR(field->pixels(0).inverse_z(7), 0.2f, 1e-6f);
}

/// Changes a byte of a tile.
void damage_tile(const std::string& folder, const light_field::View& view, std::size_t tile) {
  const std::string path = light_field::data_file(folder, view);
  std::string bytes = read_bytes(path);
  char& byte = bytes[view.tiles[tile].offset + view.tiles[tile].bytes / 2];
  byte = static_cast<char>(byte ^ 0x55);
  write_bytes(path, bytes);
}

TEST(LightFieldDamage, IsNamedTileByTile) {
  const support::TempDir directory;
  const std::string folder = directory / "a.lf";
  const Manifest manifest = write_set(folder, grid_plan(2, 0.1, 5, kSize), kSize, test_plane());
  for (std::uint32_t v = 0; v < 4; ++v) EXPECT_TRUE(light_field::check_view(manifest, folder, v).empty());
  damage_tile(folder, manifest.views[1], 4);  // the second row of three columns
  const std::vector<light_field::Damage> found = light_field::check_view(manifest, folder, 1);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].text(), HasSubstr("view 1, tile 1,1: its hash is "));
  EXPECT_THAT(found[0].text(), HasSubstr(light_field::hash_text(manifest.views[1].tiles[4].hash)));

  const auto field = open(folder);
  light_field::Seen seen;
  EXPECT_FALSE(field->pixels(1).look(20, 20, seen));
  EXPECT_TRUE(field->pixels(1).look(5, 5, seen)) << "other tiles are sound";
  ASSERT_EQ(field->damage().size(), 1u);
  EXPECT_EQ(field->damage()[0].text(), found[0].text());
}

TEST(LightFieldDamage, OfWholeFilesIsNoCrash) {
  const support::TempDir directory;
  const std::string folder = directory / "a.lf";
  const Manifest manifest = write_set(folder, grid_plan(2, 0.1, 5, kSize), kSize, test_plane());
  std::filesystem::remove(light_field::data_file(folder, manifest.views[0]));
  const std::string path = light_field::data_file(folder, manifest.views[1]);
  const std::string bytes = read_bytes(path);
  write_bytes(path, bytes.substr(0, manifest.views[1].tiles.back().offset + 1));
  write_bytes(light_field::data_file(folder, manifest.views[2]), "no picture");
  const auto texts = [&](std::uint32_t view) {
    std::string text;
    for (const light_field::Damage& damage : light_field::check_view(manifest, folder, view))
      text += damage.text() + "\n";
    return text;
  };
  EXPECT_THAT(texts(0), HasSubstr("view 0: its file is not there"));
  EXPECT_THAT(texts(1), HasSubstr("view 1, tile 2,1: its hash is that of no bytes"));
  EXPECT_THAT(texts(2), HasSubstr("view 2: its file is not there, or not the one that was written"));
  const auto field = open(folder);
  light_field::Seen seen;
  EXPECT_FALSE(field->pixels(0).look(1, 1, seen));
  EXPECT_FALSE(field->pixels(1).look(39, 23, seen));
  EXPECT_TRUE(field->pixels(1).look(1, 1, seen));
  EXPECT_FALSE(field->pixels(2).look(1, 1, seen));
}

TEST(LightFieldFiles, AreNotWrittenOver) {
  const support::TempDir directory;
  Manifest manifest = write_set(directory / "a.lf", grid_plan(2, 0.1, 5, kSize), kSize, test_plane());
  EXPECT_THAT(std::string(SetWriter(directory / "a.lf", manifest).begin().message()),
              HasSubstr("is there already"));
}

TEST(LightFieldFiles, AreReadByThePythonOfTheDocuments) {
  const char* const python = "/usr/bin/python3";
  const auto patience = std::chrono::minutes(5);
  if (!std::filesystem::exists(python) ||
      support::run_program({python, "-c", "import numpy"}, patience).status.code != 0) {
    GTEST_SKIP() << test::needs("python3-numpy");
  }
  const support::TempDir directory;
  const CapturePlan plan = grid_plan(2, 0.1, 5, kSize);
  for (const Compression compression : {Compression::kNone, Compression::kZip}) {
    for (const bool half : {false, true}) {
      const std::string folder = directory / (std::string(word_of(compression)) + (half ? "-half" : ""));
      const Manifest manifest = write_set(folder, plan, kSize, test_plane(), {compression, half});
      const auto read = [&] {
        return support::run_program({python, "-B", "docs/light_field_reader.py", folder, "2", "37", "19"},
                                    patience);
      };
      const support::Finished done = read();
      ASSERT_EQ(done.status.code, 0) << done.err;
      const Image truth = shaded(plan.cameras[2], kSize.width, kSize.height, test_plane());
      const std::size_t pixel = 19 * kSize.width + 37;
      std::istringstream numbers(done.out);
      for (const std::size_t channel : {3, 2, 1, 0, 4}) {  // A, B, G, R, depth.Z
        double value = 0;
        numbers >> value;
        const float expected = truth.channels[channel].values[pixel];
        EXPECT_NEAR(value, expected, half && channel != 4 ? expected / 2048 : 0);
      }
      V3d place, direction;
      numbers >> place.x >> place.y >> place.z >> direction.x >> direction.y >> direction.z;
      EXPECT_LT((place - plan.cameras[2].place()).length(), 1e-12);
      EXPECT_LT((direction - plan.cameras[2].direction(37.5, 19.5).normalized()).length(), 1e-12);
      damage_tile(folder, manifest.views[2], 5);
      EXPECT_THAT(read().err, HasSubstr("view 2, tile 2,1 is damaged"));
    }
  }
}

}  // namespace
}  // namespace tessera::client::light_field_test
