// Reading the texels of an image, 16 places at a time.
#pragma once

#include "render/color/spectrum.h"
#include "render/color/texture_table.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// One image with the way it is read. Coordinates are finite; (0, 0) is the lower left corner of the image,
/// (1, 1) the upper right one, and texel centres lie at half-integers of the resolution, as in pbrt-v4.
class ImageLookup {
 public:
  /// `channel` is as in TextureNode.
  TESSERA_INLINE ImageLookup(const TextureImage& image, WrapModes wrap, std::int32_t channel)
      : image_(image), wrap_(wrap), channel_(channel) {}

  TESSERA_INLINE Color nearest(Vec2 st, Mask active) const {
    const Float x = in_texels(st.x, wrap_.u, image_.width),
                y = in_texels(1.0f - st.y, wrap_.v, image_.height);
    return texel(wrapped(to_int(floor(x)), wrap_.u, image_.width),
                 wrapped(to_int(floor(y)), wrap_.v, image_.height), active);
  }

  Color bilinear(Vec2 st, Mask active) const {
    const Float x = in_texels(st.x, wrap_.u, image_.width) - 0.5f,
                y = in_texels(1.0f - st.y, wrap_.v, image_.height) - 0.5f;
    const Float x_floor = floor(x), y_floor = floor(y);
    const Float tx = x - x_floor, ty = y - y_floor;
    const Wrapped x0 = wrapped(to_int(x_floor), wrap_.u, image_.width),
                  x1 = wrapped(to_int(x_floor) + 1, wrap_.u, image_.width);
    const Wrapped y0 = wrapped(to_int(y_floor), wrap_.v, image_.height),
                  y1 = wrapped(to_int(y_floor) + 1, wrap_.v, image_.height);
    return lerp(ty, lerp(tx, texel(x0, y0, active), texel(x1, y0, active)),
                lerp(tx, texel(x0, y1, active), texel(x1, y1, active)));
  }

 private:
  /// A texel index along one axis.
  struct Wrapped {
    Int index;
    Mask exists;
  };

  /// A coordinate in texels, brought so near the image that only the neighbouring copies need be told apart.
  static TESSERA_INLINE Float in_texels(Float s, WrapMode wrap, std::int32_t resolution) {
    switch (wrap) {
      case WrapMode::kRepeat:
        s = s - floor(s);
        break;
      case WrapMode::kMirror:
        s = s - 2.0f * floor(s * 0.5f);
        break;
      case WrapMode::kClamp:
      case WrapMode::kBlack:
        s = clamp(s, -1.0f, 2.0f);
        break;
    }
    return s * static_cast<float>(resolution);
  }

  static TESSERA_INLINE Wrapped wrapped(Int i, WrapMode wrap, std::int32_t resolution) {
    const Int last = resolution - 1;
    switch (wrap) {
      case WrapMode::kRepeat:
        i = select(i < 0, i + resolution, i);
        return {select(i > last, i - resolution, i), Mask::all()};
      case WrapMode::kMirror:
        i = select(i < 0, -1 - i, i);
        i = select(i > last, 2 * resolution - 1 - i, i);
        return {max(i, 0), Mask::all()};
      case WrapMode::kBlack:
        return {i, (i >= 0) & (i <= last)};
      case WrapMode::kClamp:
        break;
    }
    return {min(max(i, 0), last), Mask::all()};
  }

  /// The linear value of one texel; black where it does not exist.
  TESSERA_INLINE Color texel(Wrapped x, Wrapped y, Mask active) const {
    const Mask lanes = active & x.exists & y.exists;
    const Int index = y.index * image_.width + x.index;
    if (image_.format == TexelFormat::kFloat) return float_texel(index, lanes);
    return byte_texel(index, lanes);
  }

  TESSERA_INLINE Color float_texel(Int index, Mask lanes) const {
    const float* texels = image_.texels32.data();
    const Int first = index * 4;
    if (channel_ >= 0) return Color(gather(texels + channel_, first, lanes));
    return color_of([&](int band) { return gather(texels + band, first, lanes); });
  }

  TESSERA_INLINE Color byte_texel(Int index, Mask lanes) const {
    const UInt packed = gather(image_.texels8.data(), index, lanes);
    if (channel_ == 3) return Color(to_float(bit_cast<std::int32_t>(shift_right<24>(packed))) * (1.0f / 255));
    if (channel_ >= 0) return Color(decoded(channel_byte(packed, channel_), lanes));
    return color_of([&](int band) { return decoded(channel_byte(packed, band), lanes); });
  }

  static TESSERA_INLINE Int channel_byte(UInt packed, std::int32_t channel) {
    const UInt shifted = channel == 0   ? packed
                         : channel == 1 ? shift_right<8>(packed)
                                        : shift_right<16>(packed);
    return bit_cast<std::int32_t>(shifted & 255u);
  }
  TESSERA_INLINE Float decoded(Int byte, Mask lanes) const { return gather(image_.decode, byte, lanes); }

  const TextureImage& image_;
  const WrapModes wrap_;
  const std::int32_t channel_;
};

}  // namespace tessera::render::TESSERA_ISA
