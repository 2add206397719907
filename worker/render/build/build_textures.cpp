#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "render/color/texture_load.h"
#include "wire/limits.h"

namespace tessera::render {

namespace {

constexpr int kInProgress = -2;

TexelEncoding encoding_of(const v1::ImageTexture& image) {
  switch (image.encoding()) {
    case v1::ImageTexture::LINEAR:
      return TexelEncoding::kLinear;
    case v1::ImageTexture::SRGB:
      return TexelEncoding::kSrgb;
    case v1::ImageTexture::GAMMA:
      return TexelEncoding::kGamma;
    default:
      return TexelEncoding::kAuto;
  }
}

WrapMode wrap_of(const v1::ImageTexture& image) {
  switch (image.wrap()) {
    case v1::ImageTexture::CLAMP:
      return WrapMode::kClamp;
    case v1::ImageTexture::BLACK:
      return WrapMode::kBlack;
    case v1::ImageTexture::MIRROR:
      return WrapMode::kMirror;
    default:
      return WrapMode::kRepeat;
  }
}

TextureNode constant_node(const Rgb& value) {
  TextureNode node;
  node.value[0] = value.r, node.value[1] = value.g, node.value[2] = value.b;
  return node;
}

}  // namespace

std::shared_ptr<const TextureImage> SceneBuilder::image_slot(const v1::ImageTexture& image) {
  // Every file once for each way of decoding it.
  const std::string key =
      absl::StrCat(image.image().digest(), "/", static_cast<int>(encoding_of(image)), "/", image.gamma());
  PendingImage& pending = images_[key];
  if (!pending.image) pending = {&image, std::make_shared<TextureImage>()};
  return pending.image;
}

void SceneBuilder::need_images(int node) {
  const auto index = static_cast<std::size_t>(node);
  needed_nodes_.resize(arrays_.textures.nodes.size());
  if (needed_nodes_[index]) return;
  needed_nodes_[index] = true;
  const TextureNode& used = arrays_.textures.nodes[index];
  for (auto& [key, pending] : images_) pending.needed |= pending.image == used.image;
  for (const std::int32_t input : used.inputs) {
    if (input >= 0) need_images(input);
  }
}

absl::Status SceneBuilder::decode_images() {
  std::vector<const PendingImage*> wanted;
  for (const auto& [key, pending] : images_) {
    if (pending.needed) wanted.push_back(&pending);
  }
  return parallel_for(wanted.size(), threads_, [&](std::size_t i) -> absl::Status {
    const v1::ImageTexture& image = *wanted[i]->source;
    auto bytes = blobs_(image.image().digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", image.image().path(), "'"));
    auto loaded = load_texture_image(bytes->bytes, image.image().path(), {encoding_of(image), image.gamma()});
    if (!loaded.ok()) return loaded.status();
    *wanted[i]->image = *std::move(loaded);
    return absl::OkStatus();
  });
}

absl::Status SceneBuilder::build_textures() {
  for (const v1::Texture& texture : scene_.textures()) {
    if (!textures_.emplace(texture.name(), &texture).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("texture '", texture.name(), "': the name is used twice"));
    }
  }
  for (const v1::Texture& texture : scene_.textures()) {
    if (auto node = named_node(texture.name()); !node.ok()) return node.status();
  }
  return absl::OkStatus();
}

absl::StatusOr<int> SceneBuilder::texture_node(const std::string& name) {
  auto node = named_node(name);
  if (node.ok()) need_images(*node);
  return node;
}

absl::StatusOr<int> SceneBuilder::named_node(const std::string& name) {
  if (auto it = texture_nodes_.find(name); it != texture_nodes_.end()) {
    if (it->second == kInProgress) {
      return absl::InvalidArgumentError(absl::StrCat("texture '", name, "': it refers to itself"));
    }
    return it->second;
  }
  const auto it = textures_.find(name);
  if (it == textures_.end())
    return absl::InvalidArgumentError(absl::StrCat("texture '", name, "' does not exist"));
  if (texture_nesting_ == wire::kMaxNesting) {
    return absl::InvalidArgumentError(
        absl::StrCat("texture '", name, "': more than ", wire::kMaxNesting, " textures within one another"));
  }
  texture_nodes_[name] = kInProgress;
  ++texture_nesting_;
  const auto node = add_node(*it->second);
  --texture_nesting_;
  if (!node.ok()) return located(node.status(), absl::StrCat("texture '", name, "'"));
  return texture_nodes_[name] = *node;
}

absl::StatusOr<int> SceneBuilder::add_node(const v1::Texture& texture) {
  auto made = make_node(texture);
  if (!made.ok()) return made.status();
  auto& nodes = arrays_.textures.nodes;
  // Inputs may share theirs, so that what one look-up costs may double with every texture.
  node_lookups_.resize(nodes.size(), 1);
  double lookups = 1;
  for (const std::int32_t input : made->inputs) {
    if (input >= 0) lookups += node_lookups_[static_cast<std::size_t>(input)];
  }
  if (lookups > wire::kMaxTextureLookups) {
    return absl::InvalidArgumentError(absl::StrCat("it takes more than ", wire::kMaxTextureLookups,
                                                   " look-ups of the textures that it is made of"));
  }
  nodes.push_back(*std::move(made));
  node_lookups_.push_back(lookups);
  return static_cast<int>(nodes.size()) - 1;
}

absl::StatusOr<int> SceneBuilder::texture_input(const v1::SpectrumValue& value, const Rgb& otherwise) {
  if (value.has_texture()) return named_node(value.texture());
  if (auto s = check_spectrum(value.constant(), "input"); !s.ok()) return s;
  arrays_.textures.nodes.push_back(
      constant_node(value.has_constant() ? reflectance(value.constant()) : otherwise));
  return static_cast<int>(arrays_.textures.nodes.size()) - 1;
}

absl::Status SceneBuilder::set_texture_space(const v1::Matrix& texture_from_world, TextureNode& node) {
  const auto from_world = Transform::from_proto(texture_from_world);
  if (!from_world.ok()) return from_world.status();
  Transform world_from_render;
  if (!render_from_world_.invert(world_from_render)) return absl::InternalError("render space is singular");
  node.texture_from_render = (*from_world * world_from_render).to_affine();
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_mapping(const v1::UvMapping& mapping, TextureNode& node) {
  node.scale_u = mapping.has_scale_u() ? mapping.scale_u() : 1;
  node.scale_v = mapping.has_scale_v() ? mapping.scale_v() : 1;
  node.offset_u = mapping.offset_u();
  node.offset_v = mapping.offset_v();
  node.u_from_v = mapping.u_from_v();
  node.v_from_u = mapping.v_from_u();
  switch (mapping.source()) {
    case v1::UvMapping::SPHERICAL:
      node.source = UvSource::kSpherical;
      break;
    case v1::UvMapping::CYLINDRICAL:
      node.source = UvSource::kCylindrical;
      break;
    case v1::UvMapping::PLANAR:
      node.source = UvSource::kPlanar;
      break;
    default:
      node.source = UvSource::kSurface;
      break;
  }
  node.plain_uv = node.source == UvSource::kSurface && node.u_from_v == 0 && node.v_from_u == 0;
  return set_texture_space(mapping.texture_from_world(), node);
}

absl::Status SceneBuilder::set_noise(const v1::NoiseTexture& noise, TextureNode& node) {
  constexpr std::uint32_t kMostOctaves = 64;
  node.kind = TextureKind::kNoise;
  switch (noise.kind()) {
    case v1::NoiseTexture::WRINKLED:
      node.noise = NoiseKind::kWrinkled;
      break;
    case v1::NoiseTexture::WINDY:
      node.noise = NoiseKind::kWindy;
      break;
    case v1::NoiseTexture::MARBLE:
      node.noise = NoiseKind::kMarble;
      break;
    default:
      node.noise = NoiseKind::kFbm;
      break;
  }
  if (noise.octaves() > kMostOctaves) {
    return absl::InvalidArgumentError(
        absl::StrCat("it has ", noise.octaves(), " octaves, more than ", kMostOctaves));
  }
  if (noise.has_octaves()) node.octaves = static_cast<std::int32_t>(noise.octaves());
  if (noise.has_roughness()) node.roughness = noise.roughness();
  if (noise.has_scale()) node.scale = noise.scale();
  if (noise.has_variation()) node.variation = noise.variation();
  for (const float x : {node.roughness, node.scale, node.variation}) {
    if (!std::isfinite(x)) return absl::InvalidArgumentError("a number of its noise is not finite");
  }
  return set_texture_space(noise.texture_from_world(), node);
}

absl::Status SceneBuilder::set_direction(const v1::Point3& world, TextureNode& node) const {
  const Point d = render_from_world_.apply_vector({world.x(), world.y(), world.z()});
  const double l = length(d);
  if (!(l > 0) || !std::isfinite(l)) return absl::InvalidArgumentError("its direction is zero or not finite");
  const double components[] = {d.x / l, d.y / l, d.z / l};
  for (int i = 0; i < 3; ++i) node.direction[i] = static_cast<float>(components[i]);
  return absl::OkStatus();
}

void SceneBuilder::fold(TextureNode& node) const {
  const auto input = [&](int i) -> const TextureNode& {
    return arrays_.textures.nodes[static_cast<std::size_t>(node.inputs[i])];
  };
  const int count = node.kind == TextureKind::kMix ? 3 : node.kind == TextureKind::kScale ? 2 : 0;
  for (int i = 0; i < count; ++i) {
    if (input(i).kind != TextureKind::kConstant) return;
  }
  if (count == 0) return;
  TextureNode folded;
  for (int c = 0; c < 3; ++c) {
    if (node.kind == TextureKind::kScale) {
      folded.value[c] = input(0).value[c] * input(1).value[c];
    } else {
      const float* amount = input(2).value;
      const float t = (amount[0] + amount[1] + amount[2]) / 3;
      folded.value[c] = (1 - t) * input(0).value[c] + t * input(1).value[c];
    }
  }
  node = folded;
}

absl::StatusOr<TextureNode> SceneBuilder::image_node(const v1::ImageTexture& image) {
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = image_slot(image);
  node.wrap = wrap_of(image);
  node.nearest = image.filter() == v1::ImageTexture::NEAREST;
  node.invert = image.invert();
  node.scale = image.has_scale() ? image.scale() : 1;
  // An enum of the wire may have any value, and the kernels read the texels at this offset.
  if (!v1::ImageTexture::Channel_IsValid(image.channel()))
    return absl::InvalidArgumentError("its channel is unknown");
  node.channel = image.channel() == v1::ImageTexture::ALL ? -1 : static_cast<int>(image.channel()) - 1;
  if (auto s = set_mapping(image.mapping(), node); !s.ok()) return s;
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
    case v1::Texture::kImage:
      return image_node(texture.image());
    case v1::Texture::kCheckerboard:
      node.kind = TextureKind::kCheckerboard;
      node.solid = texture.checkerboard().solid();
      if (auto s = set_mapping(texture.checkerboard().mapping(), node); !s.ok()) return s;
      inputs = {{&texture.checkerboard().even(), {1, 1, 1}}, {&texture.checkerboard().odd(), {0, 0, 0}}};
      break;
    case v1::Texture::kScale:
      node.kind = TextureKind::kScale;
      inputs = {{&texture.scale().value(), {1, 1, 1}}, {&texture.scale().factor(), {1, 1, 1}}};
      break;
    case v1::Texture::kDots:
      node.kind = TextureKind::kDots;
      if (auto s = set_mapping(texture.dots().mapping(), node); !s.ok()) return s;
      inputs = {{&texture.dots().inside(), {1, 1, 1}}, {&texture.dots().outside(), {0, 0, 0}}};
      break;
    case v1::Texture::kNoise:
      if (auto s = set_noise(texture.noise(), node); !s.ok()) return s;
      return node;
    case v1::Texture::kDirectionMix:
      node.kind = TextureKind::kDirectionMix;
      if (auto s = set_direction(texture.direction_mix().direction(), node); !s.ok()) return s;
      inputs = {{&texture.direction_mix().a(), {0, 0, 0}}, {&texture.direction_mix().b(), {1, 1, 1}}};
      break;
    case v1::Texture::kMix: {
      node.kind = TextureKind::kMix;
      const v1::FloatValue& from = texture.mix().amount();
      if (from.has_texture()) {
        amount.set_texture(from.texture());
      } else if (from.has_constant()) {
        amount.mutable_constant()->set_constant(from.constant());
      }
      inputs = {
          {&texture.mix().a(), {0, 0, 0}}, {&texture.mix().b(), {1, 1, 1}}, {&amount, {0.5f, 0.5f, 0.5f}}};
      break;
    }
    case v1::Texture::kMeshAttribute: {
      node.kind = TextureKind::kMeshAttribute;
      node.scale = texture.mesh_attribute().has_scale() ? texture.mesh_attribute().scale() : 1;
      if (!std::isfinite(node.scale)) return absl::InvalidArgumentError("its scale is not finite");
      const auto [it, added] =
          attributes_.try_emplace(texture.mesh_attribute().attribute(), arrays_.textures.attribute_names);
      if (added) ++arrays_.textures.attribute_names;
      node.attribute = it->second;
      return node;
    }
    case v1::Texture::KIND_NOT_SET:
      return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    auto input = texture_input(*inputs[i].first, inputs[i].second);
    if (!input.ok()) return input.status();
    node.inputs[i] = *input;
  }
  fold(node);
  return node;
}

absl::StatusOr<int> SceneBuilder::normal_map_node(const v1::ImageTexture& image) {
  auto node = image_node(image);
  if (!node.ok()) return node.status();
  arrays_.textures.nodes.push_back(*std::move(node));
  const int index = static_cast<int>(arrays_.textures.nodes.size()) - 1;
  need_images(index);
  return index;
}

}  // namespace tessera::render
