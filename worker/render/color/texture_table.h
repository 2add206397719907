// Textures as the kernels read them: a tree of nodes over decoded images, filled by build/, the same for every ISA.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace tessera::render {

enum class TextureKind : std::int32_t { kConstant, kImage, kCheckerboard, kScale, kMix, kMeshAttribute };

enum class WrapMode : std::int32_t { kRepeat, kClamp, kBlack, kMirror };

/// How the texels of an image are stored; always four channels (R, G, B, A).
enum class TexelFormat : std::int32_t {
  kSrgb8,    // 8 bits a channel; R, G, B through `decode`
  kLinear8,  // 8 bits a channel, value / 255, also through `decode`
  kFloat     // four floats
};

/// Decoded pixels, rows from the top. Shared by all textures that use the file the same way.
struct TextureImage {
  std::int32_t width = 0, height = 0;
  TexelFormat format = TexelFormat::kFloat;
  std::vector<std::uint32_t> texels8;  // R | G << 8 | B << 16 | A << 24
  std::vector<float> texels32;         // four floats a texel
  float decode[256] = {};              // 8-bit value -> linear
};

struct TextureNode {
  TextureKind kind = TextureKind::kConstant;
  float value[3] = {0, 0, 0};             // kConstant
  std::shared_ptr<const TextureImage> image;  // kImage
  WrapMode wrap = WrapMode::kRepeat;
  bool nearest = false;
  bool invert = false;                    // 1 - value, after scale
  float scale = 1;
  std::int32_t channel = -1;              // -1: RGB; 0..3: that channel, in all components
  float scale_u = 1, scale_v = 1, offset_u = 0, offset_v = 0;  // kImage, kCheckerboard
  std::int32_t attribute = -1;            // kMeshAttribute: a name, TextureTable::attribute_of_shape
  // Other nodes: kCheckerboard even, odd; kScale value, factor; kMix a, b, amount
  std::int32_t inputs[3] = {-1, -1, -1};
};

/// Values over a mesh: one a triangle, or one a corner of every triangle (three together).
struct MeshAttribute {
  std::int32_t channels = 1;  // 1 or 3, together
  bool per_face = false;
  std::vector<float> values;
};

struct TextureTable {
  std::vector<TextureNode> nodes;  // inputs come before the nodes that use them
  std::int32_t attribute_names = 0;
  std::vector<MeshAttribute> attributes;
  std::vector<std::int32_t> attribute_of_shape;  // [shape * attribute_names + name], -1: none; empty: no shape has any
};

}  // namespace tessera::render
