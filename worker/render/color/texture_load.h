// Image files to texels.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "images/image_blob.h"
#include "render/color/texture_table.h"

namespace tessera::render {

/// How integer texels encode linear values. Files of floats (EXR, HDR, PFM, float TIFF) are linear whatever
/// is asked.
enum class TexelEncoding {
  kAuto,    // sRGB for 8-bit files, linear for deeper ones
  kLinear,  // value
  kSrgb,    // IEC 61966-2-1
  kGamma    // value ^ gamma
};

struct TextureLoadOptions {
  TexelEncoding encoding = TexelEncoding::kAuto;
  float gamma = 1;                        // used with kGamma
  std::uint64_t max_texels = 1ull << 28;  // largest decoded image; more is refused
};

/// The size of such a file, by its header alone; the errors of load_texture_image() that it tells.
absl::StatusOr<images::ImageSize> check_texture_image(std::string_view bytes, std::string_view name,
                                                      const TextureLoadOptions& options = {});

/// Decodes a file that images::decode_image() reads, with its errors. 8-bit files stay 8-bit, all others
/// become float. Texels that are not finite become 0, those beyond 1e18 become 1e18.
absl::StatusOr<TextureImage> load_texture_image(std::string_view bytes, std::string_view name,
                                                const TextureLoadOptions& options = {});

}  // namespace tessera::render
