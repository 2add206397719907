#include "render/scene/texture/texture_builder.h"

#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/texture/node_parameters.h"
#include "render/scene/values/located.h"
#include "render/scene/values/spectra.h"
#include "wire/limits.h"

namespace tessera::render {

namespace {

constexpr int kUnknown = -1, kInProgress = -2, kFaulty = -3;

absl::Status set_filter(const v1::ImageTexture& image, TexelFilter unsaid, TextureNode& node) {
  node.filter = unsaid;
  if (image.has_filter()) {
    node.filter = image.filter() == v1::ImageTexture::NEAREST     ? TexelFilter::kNearest
                  : image.filter() == v1::ImageTexture::TRILINEAR ? TexelFilter::kTrilinear
                  : image.filter() == v1::ImageTexture::EWA       ? TexelFilter::kEwa
                                                                  : TexelFilter::kBilinear;
  }
  if (!image.has_max_anisotropy()) return absl::OkStatus();
  node.max_anisotropy = image.max_anisotropy();
  if (node.max_anisotropy >= 1 && node.max_anisotropy <= wire::kMaxAnisotropy) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("its max_anisotropy is ", node.max_anisotropy, "; 1 to ",
                                                 wire::kMaxAnisotropy, " was expected"));
}

WrapMode wrap_of(v1::ImageTexture::Wrap wrap) {
  switch (wrap) {
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

std::string place_of(const v1::Texture& texture) { return absl::StrCat("texture '", texture.name(), "'"); }

}  // namespace

absl::Status TextureBuilder::build(const Textures& textures) {
  FaultList faults(1);
  build(textures, faults);
  return faults.first();
}

void TextureBuilder::build(const Textures& textures, FaultList& faults) {
  textures_ = &textures;
  faults_ = &faults;
  nodes_.assign(static_cast<std::size_t>(textures.size()), kUnknown);
  for (int i = 0; i < textures.size(); ++i)
    faults.add(textures[i], place_of(textures[i]), names_.add(textures[i].name(), i));
  for (int i = 0; i < textures.size() && !faults.full(); ++i) static_cast<void>(made_node(i));
  faults_ = nullptr;
}

absl::StatusOr<int> TextureBuilder::node(const std::string& name) {
  auto node = named_node(name);
  if (node.ok()) need_images(*node);
  return node;
}

absl::StatusOr<int> TextureBuilder::variant(const std::string& name, bool filtered) {
  const auto node = named_node(name);
  if (!node.ok()) return node.status();
  const int result = refiltered(*node, filtered);
  need_images(result);
  return result;
}

int TextureBuilder::refiltered(int node, bool filtered) {
  const auto [known, is_new] = variants_.try_emplace({node, filtered}, node);
  if (!is_new) return known->second;
  TextureNode changed = table_.nodes[static_cast<std::size_t>(node)];
  bool differs = false;
  const TexelFilter wanted = filtered ? TexelFilter::kEwa : TexelFilter::kBilinear;
  if (changed.kind == TextureKind::kImage && changed.filter != TexelFilter::kNearest &&
      changed.filter != wanted) {
    changed.filter = wanted;
    changed.image = images_.twin(changed.image.get(), filtered);
    differs = true;
  }
  for (std::int32_t& input : changed.inputs) {
    if (input < 0) continue;
    const int other = refiltered(input, filtered);
    differs = differs || other != input;
    input = other;
  }
  return differs ? known->second = add(std::move(changed)) : node;
}

absl::StatusOr<int> TextureBuilder::normal_map(const v1::ImageTexture& image) {
  auto node = make_image(image);
  if (!node.ok()) return node.status();
  const int index = add(*std::move(node));
  need_images(index);
  return index;
}

int TextureBuilder::image_node(TextureImage image) {
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = std::make_shared<const TextureImage>(std::move(image));
  node.wrap = {WrapMode::kClamp, WrapMode::kClamp};
  return add(std::move(node));
}

int TextureBuilder::scaled(int node, float factor) {
  TextureNode product;
  product.kind = TextureKind::kScale;
  product.inputs[0] = node;
  product.inputs[1] = add(constant_node({factor, factor, factor}));
  return add(std::move(product));
}

int TextureBuilder::add(TextureNode node) {
  table_.nodes.push_back(std::move(node));
  return static_cast<int>(table_.nodes.size()) - 1;
}

void TextureBuilder::need_images(int node) {
  const auto index = static_cast<std::size_t>(node);
  needed_.resize(table_.nodes.size());
  if (needed_[index]) return;
  needed_[index] = true;
  const TextureNode& used = table_.nodes[index];
  images_.need(used.image.get());
  for (const std::int32_t input : used.inputs) {
    if (input >= 0) need_images(input);
  }
}

absl::StatusOr<int> TextureBuilder::named_node(const std::string& name) {
  const auto texture = names_.find(name);
  return texture.ok() ? made_node(*texture) : texture.status();
}

absl::StatusOr<int> TextureBuilder::made_node(int index) {
  int& node = nodes_[static_cast<std::size_t>(index)];
  if (node >= 0) return node;
  if (node == kFaulty || faults_ == nullptr) return fault_is_told();
  const v1::Texture& texture = (*textures_)[index];
  const auto refuse = [&](const absl::Status& status) {
    faults_->add(texture, place_of(texture), status);
    return fault_is_told();
  };
  if (node == kInProgress) return refuse(absl::InvalidArgumentError("it refers to itself"));
  if (nesting_ == wire::kMaxNesting) {
    return refuse(absl::InvalidArgumentError(
        absl::StrCat("more than ", wire::kMaxNesting, " textures within one another")));
  }
  node = kInProgress;
  ++nesting_;
  auto made = make_node(texture);
  --nesting_;
  auto added = made.ok() ? add_checked(*std::move(made)) : made.status();
  node = added.ok() ? *added : kFaulty;
  return added.ok() ? added : refuse(added.status());
}

absl::StatusOr<int> TextureBuilder::add_checked(TextureNode node) {
  // Inputs may share theirs, so that what one look-up costs may double with every texture.
  lookups_.resize(table_.nodes.size(), 1);
  double lookups = 1;
  for (const std::int32_t input : node.inputs) {
    if (input >= 0) lookups += lookups_[static_cast<std::size_t>(input)];
  }
  if (lookups > wire::kMaxTextureLookups) {
    return absl::InvalidArgumentError(absl::StrCat("it takes more than ", wire::kMaxTextureLookups,
                                                   " look-ups of the textures that it is made of"));
  }
  lookups_.push_back(lookups);
  return add(std::move(node));
}

absl::StatusOr<int> TextureBuilder::input(const v1::SpectrumValue& value, const spectra::Rgb& otherwise) {
  if (value.has_texture()) return named_node(value.texture());
  if (auto s = check_spectrum(value.constant(), "input"); !s.ok()) return s;
  return add(constant_node(value.has_constant() ? reflectance(value.constant()) : otherwise));
}

absl::StatusOr<TextureNode> TextureBuilder::make_image(const v1::ImageTexture& image) const {
  TextureNode node;
  node.kind = TextureKind::kImage;
  if (auto s = set_filter(image, unsaid_, node); !s.ok()) return s;
  node.image = images_.slot(image, is_filtered(node.filter));
  node.wrap = {wrap_of(image.wrap()), wrap_of(image.has_wrap_v() ? image.wrap_v() : image.wrap())};
  node.invert = image.invert();
  node.scale = image.has_scale() ? image.scale() : 1;
  // An enum of the wire may have any value, and the kernels read the texels at this offset.
  if (!v1::ImageTexture::Channel_IsValid(image.channel()))
    return absl::InvalidArgumentError("its channel is unknown");
  node.channel = image.channel() == v1::ImageTexture::ALL ? -1 : static_cast<int>(image.channel()) - 1;
  if (auto s = set_mapping(image.mapping(), space_, node); !s.ok()) return s;
  if (!std::isfinite(node.scale)) return absl::InvalidArgumentError("its scale is not finite");
  return node;
}

absl::StatusOr<TextureNode> TextureBuilder::make_attribute(const v1::MeshAttributeTexture& attribute) {
  TextureNode node;
  node.kind = TextureKind::kMeshAttribute;
  node.scale = attribute.has_scale() ? attribute.scale() : 1;
  if (!std::isfinite(node.scale)) return absl::InvalidArgumentError("its scale is not finite");
  const auto [it, added] = attribute_names_.try_emplace(attribute.attribute(), table_.attribute_names);
  if (added) ++table_.attribute_names;
  node.attribute = it->second;
  return node;
}

absl::StatusOr<TextureNode> TextureBuilder::make_node(const v1::Texture& texture) {
  TextureNode node;
  switch (texture.kind_case()) {
    case v1::Texture::kConstant:
      if (auto s = check_spectrum(texture.constant(), "constant"); !s.ok()) return s;
      return constant_node(reflectance(texture.constant()));
    case v1::Texture::kImage:
      return make_image(texture.image());
    case v1::Texture::kNoise:
      if (auto s = set_noise(texture.noise(), space_, node); !s.ok()) return s;
      return node;
    case v1::Texture::kMeshAttribute:
      return make_attribute(texture.mesh_attribute());
    case v1::Texture::KIND_NOT_SET:
      return absl::InvalidArgumentError("its kind is missing or unknown");
    default:
      return combine(texture);
  }
}

absl::StatusOr<TextureNode> TextureBuilder::combine(const v1::Texture& texture) {
  TextureNode node;
  std::vector<std::pair<const v1::SpectrumValue*, spectra::Rgb>> inputs;
  v1::SpectrumValue mix_amount;  // a scalar as a spectrum
  switch (texture.kind_case()) {
    case v1::Texture::kCheckerboard:
      node.kind = TextureKind::kCheckerboard;
      node.solid = texture.checkerboard().solid();
      if (auto s = set_mapping(texture.checkerboard().mapping(), space_, node); !s.ok()) return s;
      inputs = {{&texture.checkerboard().even(), {1, 1, 1}}, {&texture.checkerboard().odd(), {0, 0, 0}}};
      break;
    case v1::Texture::kScale:
      node.kind = TextureKind::kScale;
      inputs = {{&texture.scale().value(), {1, 1, 1}}, {&texture.scale().factor(), {1, 1, 1}}};
      break;
    case v1::Texture::kDots:
      node.kind = TextureKind::kDots;
      if (auto s = set_mapping(texture.dots().mapping(), space_, node); !s.ok()) return s;
      inputs = {{&texture.dots().inside(), {1, 1, 1}}, {&texture.dots().outside(), {0, 0, 0}}};
      break;
    case v1::Texture::kDirectionMix:
      node.kind = TextureKind::kDirectionMix;
      if (auto s = set_direction(texture.direction_mix().direction(), space_, node); !s.ok()) return s;
      inputs = {{&texture.direction_mix().a(), {0, 0, 0}}, {&texture.direction_mix().b(), {1, 1, 1}}};
      break;
    case v1::Texture::kMix: {
      node.kind = TextureKind::kMix;
      const v1::FloatValue& from = texture.mix().amount();
      if (from.has_texture()) {
        mix_amount.set_texture(from.texture());
      } else if (from.has_constant()) {
        mix_amount.mutable_constant()->set_constant(from.constant());
      }
      inputs = {{&texture.mix().a(), {0, 0, 0}},
                {&texture.mix().b(), {1, 1, 1}},
                {&mix_amount, {0.5f, 0.5f, 0.5f}}};
      break;
    }
    default:
      return absl::InternalError("it is not made of others");
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    auto made = input(*inputs[i].first, inputs[i].second);
    if (!made.ok()) return made.status();
    node.inputs[i] = *made;
  }
  fold(table_, node);
  return node;
}

}  // namespace tessera::render
