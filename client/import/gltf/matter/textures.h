// Textures of glTF materials.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "images/image_blob.h"
#include "import/gltf/context.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/matter/unique_names.h"

namespace tessera::client::gltf {

/// A textureInfo of a material: absent where `info` is null.
struct TextureUse {
  const Json* info = nullptr;
  std::string place;

  explicit operator bool() const { return info != nullptr; }
  /// The set of texture coordinates that it asks for.
  int set() const;
};

class SceneTextures {
 public:
  SceneTextures(Context& context, BufferTable& buffers) : context_(context), buffers_(buffers) {}

  using Channel = v1::ImageTexture::Channel;

  /// The image as a texture message would have it: nothing where something is wrong, which is reported.
  std::optional<v1::ImageTexture> image(const TextureUse& use, bool is_color,
                                        Channel channel = v1::ImageTexture::ALL);
  /// An image whose pixels `change` has changed, 8 bits a channel: RGB, or grey.
  std::optional<v1::ImageTexture> changed_image(const TextureUse& use, const std::string& what, bool grey,
                                                void (*change)(float (&pixel)[4], double parameter),
                                                double parameter);

  std::string add(const v1::ImageTexture& image, const std::string& hint);
  std::string add_product(const v1::SpectrumValue& a, const v1::SpectrumValue& b);
  /// (1 - amount) a + amount b; `amount` is a texture.
  std::string add_mix(const v1::SpectrumValue& a, const v1::SpectrumValue& b, const std::string& amount);
  std::string add_attribute(const std::string& attribute);

 private:
  std::string add(v1::Texture texture, const std::string& hint);
  /// The bytes of an image, and the blob that they are.
  struct Source {
    v1::BlobRef blob;
    std::string_view bytes;
    std::string name;
  };
  const Source* source(std::size_t image);
  std::optional<Source> read_source(std::size_t image);
  std::optional<std::size_t> image_of(const TextureUse& use);

  Context& context_;
  BufferTable& buffers_;
  std::map<std::size_t, std::optional<Source>> sources_;
  std::map<std::string, InputFile> files_;
  std::map<std::string, std::string> name_of_message_;
  UniqueNames names_;
};

}  // namespace tessera::client::gltf
