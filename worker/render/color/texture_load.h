// Image files to texels.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/color/texture_table.h"

namespace tessera::render {

/// How integer texels encode linear values. Files of floats (EXR, HDR, PFM, float TIFF) are linear whatever is asked.
enum class TexelEncoding {
  kAuto,    // sRGB for 8-bit files, linear for deeper ones
  kLinear,  // value
  kSrgb,    // IEC 61966-2-1
  kGamma    // value ^ gamma
};

struct TextureLoadOptions {
  TexelEncoding encoding = TexelEncoding::kAuto;
  float gamma = 1;                        // with kGamma
  std::uint64_t max_texels = 1ull << 28;  // of the decoded image; more is refused
};

/// Decodes a PNG, JPEG, TGA, BMP, EXR, HDR, PFM/PNM or TIFF file held in memory. The format is told by the bytes, for
/// TGA (which has no mark) by the extension of `name`, which otherwise serves only for messages. 8-bit files stay
/// 8-bit, all others become float; grey is spread over R, G and B; alpha is 1 where the file has none, and colours are
/// never multiplied by it. Texels that are not finite become 0, those beyond 1e18 become 1e18. InvalidArgument names
/// the file and what is wrong with it; ResourceExhausted when it is too large.
absl::StatusOr<TextureImage> load_texture_image(std::string_view bytes, std::string_view name,
                                                const TextureLoadOptions& options = {});

}  // namespace tessera::render
