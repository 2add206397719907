// Inputs of a builder that is tested alone: messages from text, blobs from memory, and textures that no
// TextureBuilder made.
#pragma once

#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/texture/texture_nodes.h"
#include "wire/algorithm.h"

namespace tessera::render {

/// A message in protobuf's text form.
template <class Message>
Message message(const std::string& text) {
  Message result;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &result)) << text;
  return result;
}

/// Blobs by the names that stand for their digests; notes which of them are asked for.
class BlobsInMemory {
 public:
  explicit BlobsInMemory(std::map<std::string, std::string> blobs = {}) : blobs_(std::move(blobs)) {}

  void add(const std::string& name, std::string bytes) { blobs_[name] = std::move(bytes); }
  const std::vector<std::string>& asked() const { return asked_; }
  const BlobSource source = [this](const std::string& digest) -> absl::StatusOr<BlobBytes> {
    asked_.push_back(digest);
    const auto it = blobs_.find(digest);
    if (it == blobs_.end()) return absl::NotFoundError(absl::StrCat("there is no blob ", digest));
    return BlobBytes{it->second, nullptr};
  };

 private:
  std::map<std::string, std::string> blobs_;
  std::vector<std::string> asked_;
};

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Nodes by name, as many as a test puts in.
class NamedTextures final : public TextureNodes {
 public:
  void add(const std::string& name, TextureNode node) {
    nodes_[name] = static_cast<int>(table_.nodes.size());
    table_.nodes.push_back(std::move(node));
  }
  void add_constant(const std::string& name, float value) {
    TextureNode node;
    for (float& v : node.value) v = value;
    add(name, node);
  }
  void add_noise(const std::string& name) {
    TextureNode node;
    node.kind = TextureKind::kNoise;
    add(name, node);
  }

  absl::StatusOr<int> node(const std::string& name) override {
    const auto it = nodes_.find(name);
    if (it == nodes_.end()) return absl::InvalidArgumentError(absl::StrCat("no texture ", name));
    return it->second;
  }
  absl::StatusOr<int> exact_node(const std::string& name) override { return node(name); }
  absl::StatusOr<int> filtered_node(const std::string& name) override { return node(name); }
  absl::StatusOr<int> normal_map(const v1::ImageTexture&) override {
    add("a normal map", {});
    return static_cast<int>(table_.nodes.size()) - 1;
  }
  int image_node(TextureImage image) override {
    TextureNode node;
    node.kind = TextureKind::kImage;
    node.image = std::make_shared<const TextureImage>(std::move(image));
    add("an image", std::move(node));
    return static_cast<int>(table_.nodes.size()) - 1;
  }
  int scaled(int node, float factor) override {
    scales.emplace_back(node, factor);
    add("scaled", {});
    return static_cast<int>(table_.nodes.size()) - 1;
  }
  const TextureTable& table() const override { return table_; }

  std::vector<std::pair<int, float>> scales;  // calls of scaled()

 private:
  std::map<std::string, int> nodes_;
  TextureTable table_;
};

inline const wire::AlgorithmTraits kSurfacesAlone{.name = "surfaces"};
inline const wire::AlgorithmTraits kSeesMedia{.name = "media", .media = true};
inline const wire::AlgorithmTraits kFromLights{.name = "from lights",
                                               .work = wire::WorkKind::kPasses,
                                               .samples_all_light = true,
                                               .starts_at_lights = true};

}  // namespace tessera::render
