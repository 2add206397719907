// Textures of a scene's messages -> nodes of the TextureTable.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/texture/texture_images.h"
#include "render/scene/texture/texture_nodes.h"
#include "render/scene/values/fault_list.h"
#include "render/scene/values/name_table.h"
#include "spectra/color/rgb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class TextureBuilder final : public TextureNodes {
 public:
  using Textures = google::protobuf::RepeatedPtrField<v1::Texture>;

  /// Fills the nodes of `table`, whose images come from `images`; `unsaid`: how they are filtered that do not
  /// say it.
  TextureBuilder(const RenderSpace& space, TextureImages& images, TextureTable& table,
                 TexelFilter unsaid = TexelFilter::kBilinear)
      : space_(space), images_(images), table_(table), unsaid_(unsaid) {}

  /// Makes the nodes of all textures, which must outlive this. InvalidArgument names the texture.
  absl::Status build(const Textures& textures);
  /// The same, but goes on after a fault, until the list is full.
  void build(const Textures& textures, FaultList& faults);
  /// The values over meshes that textures look up: their numbers in TextureTable::attribute_of_shape.
  const std::map<std::string, int>& attribute_names() const { return attribute_names_; }

  absl::StatusOr<int> node(const std::string& name) override;
  absl::StatusOr<int> exact_node(const std::string& name) override { return variant(name, false); }
  absl::StatusOr<int> filtered_node(const std::string& name) override { return variant(name, true); }
  absl::StatusOr<int> normal_map(const v1::ImageTexture& image) override;
  int image_node(TextureImage image) override;
  int scaled(int node, float factor) override;
  const TextureTable& table() const override { return table_; }

 private:
  absl::StatusOr<int> named_node(const std::string& name);
  /// The node of a texture, made at the first call; its fault is told in faults_.
  absl::StatusOr<int> made_node(int texture);
  absl::StatusOr<int> add_checked(TextureNode node);
  absl::StatusOr<TextureNode> make_node(const v1::Texture& texture);
  absl::StatusOr<TextureNode> make_image(const v1::ImageTexture& image) const;
  absl::StatusOr<TextureNode> make_attribute(const v1::MeshAttributeTexture& attribute);
  /// Makes a node of other nodes; `amount`: of a mix, as a spectrum.
  absl::StatusOr<TextureNode> combine(const v1::Texture& texture);
  absl::StatusOr<int> input(const v1::SpectrumValue& value, const spectra::Rgb& otherwise);
  absl::StatusOr<int> variant(const std::string& name, bool filtered);
  /// `node` with all its images filtered (kEwa), or none: itself where that is so already.
  int refiltered(int node, bool filtered);
  int add(TextureNode node);
  void need_images(int node);

  const RenderSpace& space_;
  TextureImages& images_;
  TextureTable& table_;
  const TexelFilter unsaid_;
  const Textures* textures_ = nullptr;
  FaultList* faults_ = nullptr;  // during build()
  NameTable names_{"texture"};   // places among textures_
  std::vector<int> nodes_;       // node of each of textures_, or kUnknown, kInProgress or kFaulty
  std::map<std::string, int> attribute_names_;
  std::map<std::pair<int, bool>, int> variants_;  // refiltered() of its arguments
  std::vector<bool> needed_;                      // nodes that need_images() has seen
  std::vector<double> lookups_;                   // number of lookups that a node takes; beyond the end: 1
  int nesting_ = 0;
};

}  // namespace tessera::render
