// Mitsuba scenes written for one test.
#pragma once

#include <string>

#include "unit/import/import_fixture.h"

namespace tessera::client {

/// Appends the bytes of a number.
template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

class MitsubaTest : public ImportTest {
 protected:
  absl::StatusOr<ImportedScene> import_xml(const std::string& text,
                                           const std::map<std::string, std::string>& defines = {}) const {
    return import_scene(write("scene.xml", text), {.threads = 2, .defines = defines});
  }

  /// A scene with a sensor and `body`, which begins in line 3.
  static std::string with_sensor(const std::string& body) {
    return "<scene version=\"3.0.0\">\n<sensor type=\"perspective\"/>\n" + body + "\n</scene>\n";
  }

  /// Imports a file that must be accepted.
  ImportedScene scene(const std::string& body, const std::map<std::string, std::string>& defines = {}) const {
    return succeed(import_xml(with_sensor(body), defines));
  }
  ImportedScene succeed(absl::StatusOr<ImportedScene> result) const {
    EXPECT_TRUE(result.ok()) << result.status().ToString();
    return result.ok() ? *std::move(result) : ImportedScene{};
  }

  /// The material of a rectangle with this bsdf, and the whole scene.
  v1::Material material(const std::string& bsdf, ImportedScene* whole = nullptr) const {
    ImportedScene imported = scene("<shape type=\"rectangle\">" + bsdf + "</shape>");
    const v1::Material result = find_material(imported, imported.scene.shapes(0).material());
    if (whole != nullptr) *whole = std::move(imported);
    return result;
  }
  static v1::Material find_material(const ImportedScene& imported, const std::string& name) {
    for (const v1::Material& candidate : imported.scene.materials()) {
      if (candidate.name() == name) return candidate;
    }
    ADD_FAILURE() << "no material " << name;
    return {};
  }
  static v1::Texture find_texture(const ImportedScene& imported, const std::string& name) {
    for (const v1::Texture& candidate : imported.scene.textures()) {
      if (candidate.name() == name) return candidate;
    }
    ADD_FAILURE() << "no texture " << name;
    return {};
  }

  static const SceneBlob& find_blob(const ImportedScene& imported, const std::string& digest) {
    for (const SceneBlob& blob : imported.blobs) {
      if (blob.ref.digest() == digest) return blob;
    }
    static const SceneBlob none;
    ADD_FAILURE() << "no blob " << digest;
    return none;
  }
  static wire::MeshView mesh_of(const ImportedScene& imported, const v1::Shape& shape) {
    const auto mesh = wire::decode_mesh(find_blob(imported, shape.mesh().blob().digest()).bytes);
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    return mesh.ok() ? *mesh : wire::MeshView{};
  }
};

inline std::vector<double> elements_of(const v1::Matrix& matrix) {
  if (matrix.elements().empty()) return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return {matrix.elements().begin(), matrix.elements().end()};
}

}  // namespace tessera::client
