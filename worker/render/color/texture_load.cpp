#include "render/color/texture_load.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace tessera::render {
namespace {

absl::Status invalid(const std::string& name, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("image ", name, ": ", what));
}

/// OpenImageIO's name of the format, empty when it is none that we read.
std::string detect_format(std::string_view bytes, const std::string& name) {
  const auto starts = [&](std::string_view mark) { return bytes.starts_with(mark); };
  if (starts("\x89PNG\r\n\x1a\n")) return "png";
  if (starts("\xff\xd8\xff")) return "jpeg";
  if (starts("\x76\x2f\x31\x01")) return "openexr";
  if (starts("#?RADIANCE") || starts("#?RGBE")) return "hdr";
  if (starts(std::string_view("II*\0", 4)) || starts(std::string_view("MM\0*", 4))) return "tiff";
  if (starts("BM")) return "bmp";
  if (starts("PF") || starts("Pf")) return "pnm";
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return "pnm";
  if (absl::EndsWithIgnoreCase(name, ".tga")) return "targa";
  return {};
}

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

/// Which of the file's channels is which; -1: none.
struct ChannelMap {
  int color[3];
  int alpha;
  int count;  // channels to read, from the first on
};

ChannelMap map_channels(const OIIO::ImageSpec& spec) {
  if (spec.nchannels >= 3) return {{0, 1, 2}, spec.nchannels >= 4 ? 3 : -1, std::min(spec.nchannels, 4)};
  if (spec.nchannels == 2) return {{0, 0, 0}, spec.alpha_channel == 1 ? 1 : -1, 2};
  return {{0, 0, 0}, -1, 1};
}

absl::Status check_size(const OIIO::ImageSpec& spec, const std::string& name, std::uint64_t max_texels) {
  if (spec.deep) return invalid(name, "deep images are not supported");
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0) return invalid(name, "it has no pixels");
  if (spec.depth > 1) return invalid(name, "volumes are not supported");
  const std::uint64_t texels = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height);
  if (texels > max_texels)
    return absl::ResourceExhaustedError(absl::StrCat("image ", name, ": ", spec.width, " x ", spec.height,
                                                     " texels are more than the limit of ", max_texels));
  return absl::OkStatus();
}

/// Reads the channels of `map` as T, interleaved.
template <class T>
absl::StatusOr<std::vector<T>> read_channels(OIIO::ImageInput& input, const OIIO::ImageSpec& spec,
                                             const ChannelMap& map, const std::string& name) {
  std::vector<T> values(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                        static_cast<std::size_t>(map.count));
  const auto type = sizeof(T) == 1 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
  if (!input.read_image(0, 0, 0, map.count, type, values.data())) {
    const std::string reason = input.geterror();
    return invalid(name, reason.empty() ? "it cannot be read to its end" : reason);
  }
  return values;
}

void fill_decode_table(TextureImage& image, TexelEncoding encoding, float gamma) {
  for (int i = 0; i < 256; ++i) {
    const double v = i / 255.0;
    const double linear = encoding == TexelEncoding::kLinear  ? v
                          : encoding == TexelEncoding::kGamma ? std::pow(v, gamma)
                                                              : linear_from_srgb(v);
    image.decode[i] = static_cast<float>(linear);
  }
}

void store_bytes(const std::vector<std::uint8_t>& values, const ChannelMap& map, TextureImage& image) {
  const std::size_t texels = values.size() / static_cast<std::size_t>(map.count);
  image.texels8.resize(texels);
  const std::uint8_t* source = values.data();
  for (std::size_t i = 0; i < texels; ++i, source += map.count) {
    const std::uint32_t alpha = map.alpha < 0 ? 255u : source[map.alpha];
    image.texels8[i] = std::uint32_t{source[map.color[0]]} | std::uint32_t{source[map.color[1]]} << 8 |
                       std::uint32_t{source[map.color[2]]} << 16 | alpha << 24;
  }
}

/// As of the numbers of a scene (wire/scene_numbers.h).
constexpr double kLargestTexel = 1e18;

void store_floats(const std::vector<float>& values, const ChannelMap& map, TexelEncoding encoding, float gamma,
                  TextureImage& image) {
  const auto linear = [&](float v) {
    if (encoding == TexelEncoding::kSrgb) return linear_from_srgb(v);
    if (encoding == TexelEncoding::kGamma) return std::pow(std::max(double{v}, 0.0), double{gamma});
    return double{v};
  };
  const auto decode = [&](float v) {
    return std::isfinite(v) ? static_cast<float>(std::clamp(linear(v), -kLargestTexel, kLargestTexel)) : 0.0f;
  };
  const std::size_t texels = values.size() / static_cast<std::size_t>(map.count);
  image.texels32.resize(texels * 4);
  const float* source = values.data();
  for (std::size_t i = 0; i < texels; ++i, source += map.count) {
    float* texel = &image.texels32[i * 4];
    for (int c = 0; c < 3; ++c) texel[c] = decode(source[map.color[c]]);
    const float alpha = map.alpha < 0 ? 1.0f : source[map.alpha];
    texel[3] = std::isfinite(alpha) ? alpha : 0.0f;
  }
}

absl::StatusOr<TextureImage> decode_image(std::string_view bytes, const std::string& name,
                                          const TextureLoadOptions& options) {
  const std::string format = detect_format(bytes, name);
  if (format.empty()) return invalid(name, "it is none of PNG, JPEG, TGA, BMP, EXR, HDR, PFM, PNM and TIFF");

  OIIO::Filesystem::IOMemReader memory(bytes.data(), bytes.size());
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
  if (!input) return invalid(name, absl::StrCat("this build of OpenImageIO does not read ", format));
  if (!input->supports("ioproxy") || !input->set_ioproxy(&memory))
    return invalid(name, absl::StrCat("this build of OpenImageIO does not read ", format, " from memory"));

  OIIO::ImageSpec config, spec;
  config.attribute("oiio:UnassociatedAlpha", 1);
  if (!input->open(name + "." + format, spec, config)) {
    const std::string reason = input->geterror();
    return invalid(name, reason.empty() ? "its header is broken" : reason);
  }
  if (absl::Status status = check_size(spec, name, options.max_texels); !status.ok()) return status;

  TextureImage image;
  image.width = spec.width;
  image.height = spec.height;
  const ChannelMap map = map_channels(spec);
  TexelEncoding encoding = options.encoding;
  if (spec.format == OIIO::TypeDesc::UINT8) {
    auto values = read_channels<std::uint8_t>(*input, spec, map, name);
    if (!values.ok()) return values.status();
    if (encoding == TexelEncoding::kAuto) encoding = TexelEncoding::kSrgb;
    image.format = encoding == TexelEncoding::kLinear ? TexelFormat::kLinear8 : TexelFormat::kSrgb8;
    fill_decode_table(image, encoding, options.gamma);
    store_bytes(*values, map, image);
  } else {
    auto values = read_channels<float>(*input, spec, map, name);
    if (!values.ok()) return values.status();
    if (spec.format.is_floating_point()) encoding = TexelEncoding::kLinear;
    image.format = TexelFormat::kFloat;
    store_floats(*values, map, encoding, options.gamma, image);
  }
  return image;
}

}  // namespace

absl::StatusOr<TextureImage> load_texture_image(std::string_view bytes, std::string_view name,
                                                const TextureLoadOptions& options) {
  // OpenImageIO reports most faults by return value, but lets exceptions of the format libraries through.
  try {
    return decode_image(bytes, std::string(name), options);
  } catch (const std::exception& e) {
    return invalid(std::string(name), e.what());
  }
}

}  // namespace tessera::render
