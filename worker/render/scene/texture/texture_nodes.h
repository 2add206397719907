// Textures by name, for what looks them up.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/color/texture_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Nodes that are asked for are of use, so that their images will be decoded; images of others stay empty.
class TextureNodes {
 public:
  virtual ~TextureNodes() = default;

  /// The node of a texture. InvalidArgument where there is none of this name.
  virtual absl::StatusOr<int> node(const std::string& name) = 0;
  /// The same with images at full resolution: for what light passes or is emitted by, whose probabilities
  /// count on single texels.
  virtual absl::StatusOr<int> exact_node(const std::string& name) = 0;
  /// The same with images averaged over all of the footprint (kEwa), for heights that are differentiated over
  /// it; those that take the nearest texel stay so.
  virtual absl::StatusOr<int> filtered_node(const std::string& name) = 0;
  /// A node for an image that no texture names.
  virtual absl::StatusOr<int> normal_map(const v1::ImageTexture& image) = 0;
  /// A node for an image that is there already, looked up between its texels, which clamps.
  virtual int image_node(TextureImage image) = 0;
  /// A node that is `factor` times `node`.
  virtual int scaled(int node, float factor) = 0;
  /// All nodes that there are.
  virtual const TextureTable& table() const = 0;
};

}  // namespace tessera::render
