// A float image with named channels, as it comes from the farm and goes to a file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tessera::client {

/// Pixels [x0, x1) x [y0, y1); (0, 0) is the film's upper left pixel.
struct Window {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  std::int32_t width() const { return x1 - x0; }
  std::int32_t height() const { return y1 - y0; }
  bool operator==(const Window&) const = default;
};

/// One plane of the image: rows from the top, `width * height` values.
struct Channel {
  std::string name;  // "R", "G", "B", "A", "variance.R", "albedo.G", "normal.X", "depth.Z", "samples"
  std::vector<float> values;
};

/// Attributes of OpenEXR's other types that describe pictures.
struct Rational {
  std::int32_t numerator = 0;
  std::uint32_t denominator = 1;
  bool operator==(const Rational&) const = default;
};
struct TimeCode {
  std::uint32_t time_and_flags = 0;  // SMPTE 12M: digits of frames, seconds, minutes, hours from the low end
  std::uint32_t user_data = 0;
  bool operator==(const TimeCode&) const = default;
};
/// Acts on row vectors, as OpenEXR's do: translations are in elements 12, 13 and 14.
struct RowMatrix {
  std::array<float, 16> m{};
  bool operator==(const RowMatrix&) const = default;
};

/// x and y of red, green, blue and white.
struct Chromaticities {
  std::array<float, 8> xy{};
  bool operator==(const Chromaticities&) const = default;
};

/// Two numbers, such as a chromaticity or a film's width and height.
struct NumberPair {
  float x = 0, y = 0;
  bool operator==(const NumberPair&) const = default;
};

using MetadataValue =
    std::variant<std::string, std::int32_t, float, Rational, TimeCode, RowMatrix, Chromaticities, NumberPair>;

/// Linear Rec.709 unless a channel's name, or the metadata, say otherwise (color_space.h).
struct Image {
  Window data;     // the pixels that are there; a crop is smaller than the film
  Window display;  // the whole film
  std::vector<Channel> channels;
  std::map<std::string, MetadataValue> metadata;

  std::size_t pixel_count() const { return std::size_t(data.width()) * std::size_t(data.height()); }
  /// Null when there is no such channel. The name must match exactly.
  const Channel* find(std::string_view name) const;
  /// Adds a plane of zeros.
  Channel& add(std::string name);
};

/// The planes to look at as red, green and blue: R G B (in either case), else Y or else the first plane three
/// times. The image has at least one channel.
struct RgbPlanes {
  const float* r;
  const float* g;
  const float* b;
};
RgbPlanes rgb_planes(const Image& image);
/// The same as numbers of channels.
std::array<std::size_t, 3> rgb_channels(const Image& image);

/// Facts that an image file tells of its making, as attributes "tessera.scene_digest", "tessera.spp",
/// "tessera.seed" (in decimal, as a string: it has 64 bits), "tessera.integrator", "tessera.integrator_kind",
/// "tessera.sampler", "tessera.isa", "tessera.arithmetic" (classes, separated by ", "), "tessera.version",
/// "tessera.render_seconds", and "tessera.auto", where the integrator was chosen.
struct RenderInfo {
  std::string scene_digest;
  std::uint32_t spp = 0;
  std::uint64_t seed = 0;
  std::string integrator;
  std::string integrator_kind;  // "unbiased" ... (wire/algorithm.h)
  std::string choice;           // how the integrator was chosen; empty: it was named
  std::string sampler;
  std::string isa;
  std::vector<std::string>
      arithmetic;  // classes of the machines that rendered it; of two, tiles differ in rounding
  std::string version;
  double render_seconds = 0;
};
void set_render_info(const RenderInfo& info, Image& image);

}  // namespace tessera::client
