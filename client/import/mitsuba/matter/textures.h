// Mitsuba textures -> Texture messages, and the values of materials that may be textures.
#pragma once

#include <map>
#include <set>
#include <string>

#include "import/mitsuba/matter/colors.h"

namespace tessera::client::mitsuba {

/// How a texture is asked: a checkerboard's two values trade places when Mitsuba asks for a single number.
enum class TextureRole { kColor, kScalar, kNormals };

class SceneTextures {
 public:
  explicit SceneTextures(Context& context) : context_(context) {}

  /// Parameter `name` of the reader's object; `fallback` where it is absent.
  v1::SpectrumValue color(PropertyReader& reader, std::string_view name, double fallback, ColorUse use);
  v1::FloatValue scalar(PropertyReader& reader, std::string_view name, double fallback);

  /// The name in the scene of a texture; empty after an error. Converted once for each role.
  std::string use(Object& texture, TextureRole role);

  /// A new texture that multiplies; its name.
  std::string add_product(const v1::SpectrumValue& value, const v1::SpectrumValue& factor);

  /// The texture that is a property of `owner`, as the normal map of a material.
  void set_normal_map(PropertyReader& owner, const Property& property, v1::Material& material);

 private:
  void write(PropertyReader& reader, TextureRole role, v1::Texture& message);
  void write_image(PropertyReader& reader, v1::ImageTexture& image);
  void write_checkerboard(PropertyReader& reader, TextureRole role, v1::CheckerboardTexture& board);
  v1::SpectrumValue value_of_role(PropertyReader& reader, std::string_view name, double fallback,
                                  TextureRole role);

  Context& context_;
  std::map<std::pair<const Object*, TextureRole>, std::string> names_;
  std::set<std::string> taken_;
};

}  // namespace tessera::client::mitsuba
