// Scenes written for one test, in a folder of their own.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "import/import.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

/// The translation of a matrix; empty matrices are the identity.
inline std::vector<double> column3(const v1::Matrix& m) {
  if (m.elements().empty()) return {0, 0, 0};
  return {m.elements(3), m.elements(7), m.elements(11)};
}

/// A folder that lives as long as the test.
class ImportTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "tessera-import-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    std::error_code error;
    std::filesystem::remove_all(folder_, error);
  }

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path path = folder_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

  /// Imports `text` as scene.pbrt.
  absl::StatusOr<ImportedScene> import_text(std::string_view text) const {
    return import_scene(write("scene.pbrt", text), {.threads = 2, .defines = {}});
  }

  /// The same of what stands behind WorldBegin.
  absl::StatusOr<ImportedScene> import_world(const std::string& world) const {
    return import_text("WorldBegin\n" + world);
  }

  /// Imports a file that must be accepted.
  ImportedScene world(const std::string& text) const {
    absl::StatusOr<ImportedScene> result = import_world(text);
    EXPECT_TRUE(result.ok()) << result.status().ToString();
    return result.ok() ? *std::move(result) : ImportedScene{};
  }

  /// The message that an import must fail with.
  std::string error_of(const absl::StatusOr<ImportedScene>& result) const {
    EXPECT_FALSE(result.ok());
    return result.ok() ? "" : std::string(result.status().message());
  }

  static std::string warnings_of(const ImportedScene& scene) {
    std::string all;
    for (const Diagnostic& warning : scene.warnings) all += to_string(warning) + "\n";
    return all;
  }

  std::filesystem::path folder_;
};

/// A triangle for scenes that need some shape.
inline constexpr char kTriangle[] =
    "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0  1 0 0  0 1 0 ] \"integer indices\" [ 0 1 2 ]\n";

}  // namespace tessera::client
