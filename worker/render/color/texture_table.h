// Textures as the kernels read them: a tree of nodes over decoded images, filled by scene/, the same for
// every ISA.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/color/bands.h"
#include "render/core/affine_data.h"
#include "render/core/big_array.h"

namespace tessera::render {

enum class TextureKind : std::int32_t {
  kConstant,
  kImage,
  kCheckerboard,
  kScale,
  kMix,
  kMeshAttribute,
  kDots,
  kNoise,
  kDirectionMix
};

enum class NoiseKind : std::int32_t { kFbm, kWrinkled, kWindy, kMarble };

/// Where u and v come from: the surface's own, or the point in texture space.
enum class UvSource : std::int32_t { kSurface, kSpherical, kCylindrical, kPlanar };

enum class WrapMode : std::int32_t { kRepeat, kClamp, kBlack, kMirror };
/// Along u and along v.
struct WrapModes {
  WrapMode u = WrapMode::kRepeat, v = WrapMode::kRepeat;
};

/// How the texels of an image are stored; always four channels (R, G, B, A).
enum class TexelFormat : std::int32_t {
  kSrgb8,    // 8 bits a channel; R, G, B through `decode`
  kLinear8,  // 8 bits a channel, value / 255, also through `decode`
  kFloat     // four floats
};

enum class TexelFilter : std::int32_t { kBilinear, kNearest, kTrilinear, kEwa };

/// Whether images are looked up in their pyramids.
constexpr bool is_filtered(TexelFilter filter) {
  return filter == TexelFilter::kTrilinear || filter == TexelFilter::kEwa;
}

/// One level of a pyramid; kernels read all four numbers at once.
struct MipLevel {
  std::int32_t first = 0;  // texel in the arrays
  std::int32_t width = 1, height = 1;
  std::int32_t stride = 2;  // texels from row to row: the first of each row follows its last, too
};
static_assert(sizeof(MipLevel) == 16);

/// An image and its averages [Williams 1983], linear values, rows from the top: each level has half the width
/// and half the height of the one before, rounded down. Neighbours in a row are read at once, so that a
/// bilinear look-up is two reads a lane.
struct MipPyramid {
  std::vector<MipLevel> levels;      // full resolution first, one texel last; empty: there is no pyramid
  BigArray<std::uint32_t> texels16;  // 8-bit images, two a texel: R | G << 16, B | A << 16, in 65535ths
  BigArray<float> texels32;          // others: four a texel
};

/// Decoded pixels, rows from the top. Shared by all textures that use the file the same way.
struct TextureImage {
  std::int32_t width = 0, height = 0;
  TexelFormat format = TexelFormat::kFloat;
  BigArray<std::uint32_t> texels8;  // R | G << 8 | B << 16 | A << 24
  BigArray<float> texels32;         // four floats a texel
  float decode[256] = {};           // 8-bit value -> linear
  MipPyramid pyramid;               // instead of the texels, for textures that are filtered
};

struct TextureNode {
  TextureKind kind = TextureKind::kConstant;
  float value[kBands] = {0, 0, 0};            // kConstant
  std::shared_ptr<const TextureImage> image;  // kImage
  WrapModes wrap;
  TexelFilter filter = TexelFilter::kBilinear;
  float max_anisotropy = 8;  // kEwa
  bool invert = false;       // 1 - value, after scale
  float scale = 1;
  std::int32_t channel = -1;  // -1: RGB; 0..3: that channel, in all components
  // kImage, kCheckerboard, kDots: (u', v') = (scale_u u + u_from_v v + offset_u, v_from_u u + scale_v v +
  // offset_v)
  float scale_u = 1, scale_v = 1, offset_u = 0, offset_v = 0, u_from_v = 0, v_from_u = 0;
  bool plain_uv = true;  // the surface's own u and v, not mixed
  bool solid = false;    // kCheckerboard over space
  UvSource source = UvSource::kSurface;
  Affine texture_from_render;         // used by all that look at the point
  NoiseKind noise = NoiseKind::kFbm;  // kNoise, with `scale`
  std::int32_t octaves = 8;
  float roughness = 0.5f, variation = 0.2f;
  float direction[3] = {0, 1, 0};  // kDirectionMix: render space
  std::int32_t attribute = -1;     // kMeshAttribute: a name, TextureTable::attribute_of_shape
  // Other nodes: kCheckerboard even, odd; kDots inside, outside; kScale value, factor; kMix a, b, amount;
  // kDirectionMix a, b
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
  std::vector<std::int32_t> attribute_of_shape;  // [attribute_slot()], -1: none; empty: no shape has any

  /// Returns where attribute_of_shape tells of a shape and a name; with many of both, that is beyond 32 bits.
  std::size_t attribute_slot(std::int32_t shape, std::int32_t name) const {
    return static_cast<std::size_t>(shape) * static_cast<std::size_t>(attribute_names) +
           static_cast<std::size_t>(name);
  }
};

}  // namespace tessera::render
