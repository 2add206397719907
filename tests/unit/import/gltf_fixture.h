// A small glTF file, and changes of it.
#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/escaping.h"
#include "unit/import/import_fixture.h"

namespace tessera::client {

class GltfTest : public ImportTest {
 protected:
  using Json = nlohmann::json;

  /// A triangle (0,0,0) (1,0,0) (0,1,0) on node 0, which an animation moves from the origin to (2,0,0) in a
  /// second; node 1 has a camera at (0,0,5).
  static Json triangle() {
    std::string bytes;
    const auto put = [&](std::initializer_list<float> values) {
      for (const float value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    put({0, 0, 0, 1, 0, 0, 0, 1, 0});             // view 0: positions
    bytes += std::string("\0\0\1\0\2\0\0\0", 8);  // view 1: indices, 16 bits
    put({0, 1});                                  // view 2: times
    put({0, 0, 0, 2, 0, 0});                      // view 3: translations
    Json document = Json::parse(R"({
      "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
      "nodes": [{"name": "leaf", "mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
      "materials": [{"name": "paint", "pbrMetallicRoughness": {"metallicFactor": 0.25, "roughnessFactor": 0.5}}],
      "animations": [{"samplers": [{"input": 2, "output": 3}],
                      "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
      "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
        {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6},
                      {"buffer": 0, "byteOffset": 44, "byteLength": 8},
                      {"buffer": 0, "byteOffset": 52, "byteLength": 24}]})");
    document["buffers"] = {{{"byteLength", bytes.size()}, {"uri", data_uri(bytes)}}};
    return document;
  }

  /// `document`, which is triangle(), with texture coordinates and texture 0: a pixel that is clamped along u
  /// and mirrored along v.
  static Json with_texture(Json document) {
    document["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 24}});
    document["accessors"].push_back(
        {{"bufferView", 4}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}});
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 4;
    document["images"] = {
        {{"uri",
          "data:image/"
          "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8z8BQDwAEhQGAhKmMIQ"
          "AAAABJRU5ErkJggg=="}}};
    document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    document["textures"] = {{{"source", 0}, {"sampler", 0}}};
    return document;
  }

  static std::string data_uri(const std::string& bytes) {
    return "data:application/octet-stream;base64," + absl::Base64Escape(bytes);
  }

  /// `document` with the operations of RFC 6902 that `patch` lists.
  static Json patched(const Json& document, const std::string& patch) {
    return document.patch(Json::parse(patch));
  }

  absl::StatusOr<ImportedScene> import_gltf(const Json& document, const GltfOptions& options = {}) const {
    return import_scene(write("scene.gltf", document.dump()), {.threads = 1, .defines = {}, .gltf = options});
  }

  /// Imports a document that must be accepted.
  ImportedScene accepted(const Json& document, const GltfOptions& options = {}) const {
    absl::StatusOr<ImportedScene> result = import_gltf(document, options);
    EXPECT_TRUE(result.ok()) << result.status().ToString();
    return result.ok() ? *std::move(result) : ImportedScene{};
  }

  /// A document in a .glb, with chunks as they come.
  static std::string glb(const std::vector<std::pair<std::string, std::string>>& chunks,
                         std::uint32_t version = 2) {
    const auto word = [](std::size_t value) {
      const auto number = static_cast<std::uint32_t>(value);
      return std::string(reinterpret_cast<const char*>(&number), sizeof number);
    };
    std::string body;
    for (const auto& [type, bytes] : chunks) body += word(bytes.size()) + type + bytes;
    return "glTF" + word(version) + word(body.size() + 12) + body;
  }
  static std::string padded(std::string text) { return text.append((4 - text.size() % 4) % 4, ' '); }

  static std::vector<double> place_of(const v1::Matrix& matrix) {
    const auto& m = matrix.elements();
    return m.empty() ? std::vector<double>{0, 0, 0} : std::vector<double>{m[3], m[7], m[11]};
  }
};

}  // namespace tessera::client
