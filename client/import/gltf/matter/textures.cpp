#include "import/gltf/matter/textures.h"

#include <algorithm>
#include <cmath>

#include "import/gltf/file/container.h"

namespace tessera::client::gltf {
namespace {

constexpr const char* kTransform = "KHR_texture_transform";

v1::ImageTexture::Wrap wrap_of(std::int64_t code) {
  if (code == 33071) return v1::ImageTexture::CLAMP;
  return code == 33648 ? v1::ImageTexture::MIRROR : v1::ImageTexture::REPEAT;
}

/// Meshes have v = 1 - v of glTF, so that images stand upright: with (u', v') = M (u, v) there, in its rows,
/// what M is here.
void write_mapping(const Json* transform, v1::UvMapping& mapping) {
  if (transform == nullptr) return;
  const auto pair = [&](const char* name, double fallback) {
    const Json* value = member(transform, name);
    return value == nullptr ? std::pair(fallback, fallback)
                            : std::pair((*value)[0].get<double>(), (*value)[1].get<double>());
  };
  const auto [offset_u, offset_v] = pair("offset", 0);
  const auto [scale_u, scale_v] = pair("scale", 1);
  const double rotation = number_of(transform, "rotation", 0);
  // The sample renderers read the extension so: offset + (c s; -s c) scale uv.
  const double a = std::cos(rotation) * scale_u, b = std::sin(rotation) * scale_v;
  const double c = -std::sin(rotation) * scale_u, d = std::cos(rotation) * scale_v;
  mapping.set_scale_u(static_cast<float>(a));
  mapping.set_u_from_v(static_cast<float>(-b));
  mapping.set_offset_u(static_cast<float>(b + offset_u));
  mapping.set_v_from_u(static_cast<float>(-c));
  mapping.set_scale_v(static_cast<float>(d));
  mapping.set_offset_v(static_cast<float>(1 - d - offset_v));
}

}  // namespace

int TextureUse::set() const {
  const Json* transform = extension(info, kTransform);
  const std::int64_t own = integer_of(info, "texCoord", 0);
  return static_cast<int>(transform == nullptr ? own : integer_of(transform, "texCoord", own));
}

std::optional<std::size_t> SceneTextures::image_of(const TextureUse& use) {
  const std::size_t index = *index_of(use.info, "index");
  const Json* texture = element(&context_.document, "textures", index);
  const std::string place = below("/textures", index);
  const std::size_t images = size_of(&context_.document, "images");
  for (const Json* object : {extension(texture, "EXT_texture_webp"), texture}) {
    const auto source = index_of(object, "source");
    if (source && *source < images) return source;
    if (!source) continue;
    context_.error(below(place, "source"),
                   concat("expected an index of one of ", images, " images, found ", *source));
    return std::nullopt;
  }
  context_.error(place, extension(texture, "KHR_texture_basisu") != nullptr
                            ? "KTX2 images (KHR_texture_basisu) are not read, and there is no other source"
                            : "a texture without a source");
  return std::nullopt;
}

std::optional<SceneTextures::Source> SceneTextures::read_source(std::size_t image) {
  const Json* json = element(&context_.document, "images", image);
  const std::string place = below("/images", image);
  const Json* uri = member(json, "uri");
  const std::optional<std::size_t> view = index_of(json, "bufferView");
  if ((uri != nullptr) == view.has_value()) {
    context_.error(place, "an image has either a uri or a bufferView");
    return std::nullopt;
  }
  Source source;
  source.name = text_of(json, "name", concat("image-", image));
  std::string problem;
  if (view) {
    const std::optional<std::string_view> bytes = buffers_.view(*view);
    if (!bytes) return std::nullopt;
    source.blob = context_.blobs.add_bytes(std::string(*bytes));
    source.bytes = context_.blobs.find(source.blob.digest())->bytes;
  } else if (const auto& text = uri->get_ref<const std::string&>(); is_data_uri(text)) {
    absl::StatusOr<std::string> bytes = decode_data_uri(text);
    if (!bytes.ok()) {
      context_.error(below(place, "uri"), std::string(bytes.status().message()));
      return std::nullopt;
    }
    source.blob = context_.blobs.add_bytes(*std::move(bytes));
    source.bytes = context_.blobs.find(source.blob.digest())->bytes;
  } else {
    const absl::StatusOr<std::filesystem::path> path = file_of_uri(context_.folder, text);
    absl::StatusOr<InputFile> file = path.ok() ? open_regular(*path) : path.status();
    absl::StatusOr<v1::BlobRef> blob = file.ok() ? context_.blobs.add_file(*path, text) : file.status();
    if (!blob.ok()) {
      context_.error(below(place, "uri"), std::string(blob.status().message()));
      return std::nullopt;
    }
    source.blob = *blob;
    source.bytes = (files_[path->string()] = *std::move(file)).bytes();
    if (!member(json, "name")) source.name = path->stem().string();
  }
  if (const auto size = images::image_size(source.bytes, source.name); !size.ok()) {
    context_.error(place, std::string(size.status().message()));
    return std::nullopt;
  }
  return source;
}

const SceneTextures::Source* SceneTextures::source(std::size_t image) {
  const auto [entry, is_new] = sources_.try_emplace(image);
  if (is_new) entry->second = read_source(image);
  return entry->second ? &*entry->second : nullptr;
}

std::optional<v1::ImageTexture> SceneTextures::image(const TextureUse& use, bool is_color, Channel channel) {
  const std::optional<std::size_t> index = image_of(use);
  const Source* found = index ? source(*index) : nullptr;
  if (found == nullptr) return std::nullopt;
  v1::ImageTexture result;
  *result.mutable_image() = found->blob;
  result.set_encoding(is_color ? v1::ImageTexture::SRGB : v1::ImageTexture::LINEAR);
  result.set_channel(channel);
  const Json* texture = element(&context_.document, "textures", *index_of(use.info, "index"));
  if (const std::optional<std::size_t> number = index_of(texture, "sampler")) {
    const Json* sampler = element(&context_.document, "samplers", *number);
    const std::int64_t wrap_s = integer_of(sampler, "wrapS", 10497),
                       wrap_t = integer_of(sampler, "wrapT", 10497);
    result.set_wrap(wrap_of(wrap_s));
    if (wrap_s != wrap_t) result.set_wrap_v(wrap_of(wrap_t));
    if (integer_of(sampler, "magFilter", 9729) == 9728) result.set_filter(v1::ImageTexture::NEAREST);
  }
  write_mapping(extension(use.info, kTransform), *result.mutable_mapping());
  return result;
}

std::optional<v1::ImageTexture> SceneTextures::changed_image(const TextureUse& use, const std::string& what,
                                                             bool grey, void (*change)(float (&)[4], double),
                                                             double parameter) {
  std::optional<v1::ImageTexture> result = image(use, false);
  if (!result) return std::nullopt;
  const Source& from = *source(*image_of(use));
  const absl::StatusOr<images::ImageSize> size = images::image_size(from.bytes, from.name);
  const std::uint64_t all =
      size.ok() ? static_cast<std::uint64_t>(size->width) * static_cast<std::uint64_t>(size->height) : 0;
  if (all > context_.pixels_left) {
    context_.error(use.place,
                   concat("more than ", std::uint64_t{1} << 28, " pixels of the file have to be changed"));
    return std::nullopt;
  }
  context_.pixels_left -= all;
  const absl::StatusOr<images::ImagePixels> pixels = images::decode_image(from.bytes, from.name);
  if (!pixels.ok()) {
    context_.error(below("/images", *image_of(use)), std::string(pixels.status().message()));
    return std::nullopt;
  }
  // The plainest of formats: PGM or PPM of 8 bits.
  std::string bytes =
      concat(grey ? "P5" : "P6", "\n", pixels->size.width, " ", pixels->size.height, "\n255\n");
  const std::size_t count =
      static_cast<std::size_t>(pixels->size.width) * static_cast<std::size_t>(pixels->size.height);
  bytes.reserve(bytes.size() + count * (grey ? 1 : 3));
  for (std::size_t i = 0; i < count; ++i) {
    float pixel[4];
    for (std::size_t c = 0; c < 4; ++c) {
      pixel[c] = pixels->floats.empty() ? static_cast<float>(pixels->bytes[i] >> (8 * c) & 255) / 255
                                        : pixels->floats[4 * i + c];
    }
    change(pixel, parameter);
    for (std::size_t c = 0; c < (grey ? 1 : 3); ++c)
      bytes += static_cast<char>(std::lround(std::clamp(pixel[c], 0.0f, 1.0f) * 255));
  }
  *result->mutable_image() = context_.blobs.add_bytes(std::move(bytes));
  result->mutable_image()->set_path(concat(from.name, "-", what));
  return result;
}

std::string SceneTextures::add(v1::Texture texture, const std::string& hint) {
  const auto [known, is_new] = name_of_message_.try_emplace(texture.SerializeAsString());
  if (!is_new) return known->second;
  const std::string name = names_.unique(hint);
  texture.set_name(name);
  *context_.scene.add_textures() = std::move(texture);
  return known->second = name;
}

std::string SceneTextures::add(const v1::ImageTexture& image, const std::string& hint) {
  v1::Texture texture;
  *texture.mutable_image() = image;
  return add(std::move(texture), hint);
}

std::string SceneTextures::add_product(const v1::SpectrumValue& a, const v1::SpectrumValue& b) {
  v1::Texture texture;
  *texture.mutable_scale()->mutable_value() = a;
  *texture.mutable_scale()->mutable_factor() = b;
  return add(std::move(texture), "product");
}

std::string SceneTextures::add_mix(const v1::SpectrumValue& a, const v1::SpectrumValue& b,
                                   const std::string& amount) {
  v1::Texture texture;
  *texture.mutable_mix()->mutable_a() = a;
  *texture.mutable_mix()->mutable_b() = b;
  texture.mutable_mix()->mutable_amount()->set_texture(amount);
  return add(std::move(texture), "mix");
}

std::string SceneTextures::add_attribute(const std::string& attribute) {
  v1::Texture texture;
  texture.mutable_mesh_attribute()->set_attribute(attribute);
  return add(std::move(texture), attribute);
}

}  // namespace tessera::client::gltf
