#include <cmath>
#include <set>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "render/color/texture_load.h"

namespace tessera::render {

namespace {

constexpr int kInProgress = -2;

TexelEncoding encoding_of(const v1::ImageTexture& image) {
  switch (image.encoding()) {
    case v1::ImageTexture::LINEAR: return TexelEncoding::kLinear;
    case v1::ImageTexture::SRGB: return TexelEncoding::kSrgb;
    case v1::ImageTexture::GAMMA: return TexelEncoding::kGamma;
    default: return TexelEncoding::kAuto;
  }
}

WrapMode wrap_of(const v1::ImageTexture& image) {
  switch (image.wrap()) {
    case v1::ImageTexture::CLAMP: return WrapMode::kClamp;
    case v1::ImageTexture::BLACK: return WrapMode::kBlack;
    case v1::ImageTexture::MIRROR: return WrapMode::kMirror;
    default: return WrapMode::kRepeat;
  }
}

void set_mapping(const v1::UvMapping& mapping, TextureNode& node) {
  node.scale_u = mapping.has_scale_u() ? mapping.scale_u() : 1;
  node.scale_v = mapping.has_scale_v() ? mapping.scale_v() : 1;
  node.offset_u = mapping.offset_u();
  node.offset_v = mapping.offset_v();
}

TextureNode constant_node(const Rgb& value) {
  TextureNode node;
  node.value[0] = value.r, node.value[1] = value.g, node.value[2] = value.b;
  return node;
}

}  // namespace

std::shared_ptr<const TextureImage>& SceneBuilder::image_slot(const v1::ImageTexture& image) {
  return images_[absl::StrCat(image.image().digest(), "/", static_cast<int>(encoding_of(image)), "/", image.gamma())];
}

absl::Status SceneBuilder::load_images() {
  // Every file once for each way of decoding it, in parallel.
  std::vector<std::pair<const v1::ImageTexture*, std::shared_ptr<const TextureImage>*>> wanted;
  std::set<const void*> seen;
  const auto want = [&](const v1::ImageTexture& image) {
    auto& slot = image_slot(image);
    if (seen.insert(&slot).second) wanted.emplace_back(&image, &slot);
  };
  for (const v1::Texture& texture : scene_.textures()) {
    if (texture.has_image()) want(texture.image());
  }
  for (const v1::Material& material : scene_.materials()) {
    if (material.has_normal_map()) want(material.normal_map());
  }
  return parallel_for(wanted.size(), threads_, [&](std::size_t i) -> absl::Status {
    const v1::ImageTexture& image = *wanted[i].first;
    auto bytes = blobs_(image.image().digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", image.image().path(), "'"));
    auto loaded = load_texture_image(bytes->bytes, image.image().path(), {encoding_of(image), image.gamma()});
    if (!loaded.ok()) return loaded.status();
    *wanted[i].second = std::make_shared<TextureImage>(*std::move(loaded));
    return absl::OkStatus();
  });
}

absl::Status SceneBuilder::build_textures() {
  for (const v1::Texture& texture : scene_.textures()) {
    if (!textures_.emplace(texture.name(), &texture).second) {
      return absl::InvalidArgumentError(absl::StrCat("texture '", texture.name(), "': the name is used twice"));
    }
  }
  for (const v1::Texture& texture : scene_.textures()) {
    if (auto node = texture_node(texture.name()); !node.ok()) return node.status();
  }
  return absl::OkStatus();
}

absl::StatusOr<int> SceneBuilder::texture_node(const std::string& name) {
  if (auto it = texture_nodes_.find(name); it != texture_nodes_.end()) {
    if (it->second == kInProgress) {
      return absl::InvalidArgumentError(absl::StrCat("texture '", name, "': it refers to itself"));
    }
    return it->second;
  }
  const auto it = textures_.find(name);
  if (it == textures_.end()) return absl::InvalidArgumentError(absl::StrCat("texture '", name, "' does not exist"));
  texture_nodes_[name] = kInProgress;
  auto node = make_node(*it->second);
  if (!node.ok()) return located(node.status(), absl::StrCat("texture '", name, "'"));
  tables_.textures.nodes.push_back(*std::move(node));
  return texture_nodes_[name] = static_cast<int>(tables_.textures.nodes.size()) - 1;
}

absl::StatusOr<int> SceneBuilder::texture_input(const v1::SpectrumValue& value, const Rgb& otherwise) {
  if (value.has_texture()) return texture_node(value.texture());
  if (auto s = check_spectrum(value.constant(), "input"); !s.ok()) return s;
  tables_.textures.nodes.push_back(constant_node(value.has_constant() ? reflectance(value.constant()) : otherwise));
  return static_cast<int>(tables_.textures.nodes.size()) - 1;
}

absl::StatusOr<TextureNode> SceneBuilder::image_node(const v1::ImageTexture& image) {
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = image_slot(image);
  node.wrap = wrap_of(image);
  node.nearest = image.filter() == v1::ImageTexture::NEAREST;
  node.invert = image.invert();
  node.scale = image.has_scale() ? image.scale() : 1;
  node.channel = image.channel() == v1::ImageTexture::ALL ? -1 : static_cast<int>(image.channel()) - 1;
  set_mapping(image.mapping(), node);
  if (!std::isfinite(node.scale)) return absl::InvalidArgumentError("its scale is not finite");
  return node;
}

absl::StatusOr<TextureNode> SceneBuilder::make_node(const v1::Texture& texture) {
  TextureNode node;
  std::vector<std::pair<const v1::SpectrumValue*, Rgb>> inputs;
  v1::SpectrumValue amount;
  switch (texture.kind_case()) {
    case v1::Texture::kConstant:
      if (auto s = check_spectrum(texture.constant(), "constant"); !s.ok()) return s;
      return constant_node(reflectance(texture.constant()));
    case v1::Texture::kImage: return image_node(texture.image());
    case v1::Texture::kCheckerboard:
      node.kind = TextureKind::kCheckerboard;
      set_mapping(texture.checkerboard().mapping(), node);
      inputs = {{&texture.checkerboard().even(), {1, 1, 1}}, {&texture.checkerboard().odd(), {0, 0, 0}}};
      break;
    case v1::Texture::kScale:
      node.kind = TextureKind::kScale;
      inputs = {{&texture.scale().value(), {1, 1, 1}}, {&texture.scale().factor(), {1, 1, 1}}};
      break;
    case v1::Texture::kMix: {
      node.kind = TextureKind::kMix;
      const v1::FloatValue& from = texture.mix().amount();
      if (from.has_texture()) {
        amount.set_texture(from.texture());
      } else if (from.has_constant()) {
        amount.mutable_constant()->set_constant(from.constant());
      }
      inputs = {{&texture.mix().a(), {0, 0, 0}}, {&texture.mix().b(), {1, 1, 1}}, {&amount, {0.5f, 0.5f, 0.5f}}};
      break;
    }
    case v1::Texture::kMeshAttribute: {
      node.kind = TextureKind::kMeshAttribute;
      node.scale = texture.mesh_attribute().has_scale() ? texture.mesh_attribute().scale() : 1;
      if (!std::isfinite(node.scale)) return absl::InvalidArgumentError("its scale is not finite");
      const auto [it, added] = attributes_.try_emplace(texture.mesh_attribute().attribute(), tables_.textures.attribute_names);
      if (added) ++tables_.textures.attribute_names;
      node.attribute = it->second;
      return node;
    }
    case v1::Texture::KIND_NOT_SET: return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    auto input = texture_input(*inputs[i].first, inputs[i].second);
    if (!input.ok()) return input.status();
    node.inputs[i] = *input;
  }
  return node;
}

absl::StatusOr<int> SceneBuilder::normal_map_node(const v1::ImageTexture& image) {
  auto node = image_node(image);
  if (!node.ok()) return node.status();
  tables_.textures.nodes.push_back(*std::move(node));
  return static_cast<int>(tables_.textures.nodes.size()) - 1;
}

}  // namespace tessera::render
