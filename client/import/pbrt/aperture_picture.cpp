#include "import/pbrt/aperture_picture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include "images/image_blob.h"
#include "import/input/concat.h"
#include "import/input/input_file.h"

namespace tessera::client::pbrt {
namespace {

using std::numbers::pi;

struct Corner {
  double x, y;
};

/// Whether a place is within a polygon: rays from it towards +x cross its edges an odd number of times.
bool is_within(const std::vector<Corner>& polygon, double x, double y) {
  bool within = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner a = polygon[i], b = polygon[(i + 1) % polygon.size()];
    if ((a.y > y) != (b.y > y) && x < a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y)) within = !within;
  }
  return within;
}

/// The corners of a regular polygon; every other one is nearer to the middle if `inner` is below `outer`.
std::vector<Corner> polygon_of(int corners, double first_degrees, double outer, double inner) {
  std::vector<Corner> polygon;
  for (int i = 0; i < corners; ++i) {
    const double turn = first_degrees * pi / 180 + 2 * pi * i / corners, radius = i % 2 == 0 ? outer : inner;
    polygon.push_back({radius * std::cos(turn), radius * std::sin(turn)});
  }
  return polygon;
}

/// Part of the light, 0 to 1, that passes a place of the square [-1, 1]^2, y up.
using Opening = std::function<double(double x, double y)>;

/// pbrt-v4's, by their names.
const std::array<std::pair<const char*, Opening>, 4>& named_openings() {
  static const std::vector<Corner> pentagon = polygon_of(5, -90, 0.8, 0.8),
                                   star = polygon_of(10, 36, 1, std::cos(72 * pi / 180) / std::cos(pi / 5));
  static const std::array<std::pair<const char*, Opening>, 4> all{{
      {"gaussian",
       [](double x, double y) { return std::max(std::exp(-x * x - y * y) - std::exp(-1.0), 0.0); }},
      {"square", [](double x, double y) { return std::max(std::abs(x), std::abs(y)) < 0.5 ? 1.0 : 0.0; }},
      {"pentagon", [](double x, double y) { return is_within(pentagon, x, y) ? 1.0 : 0.0; }},
      {"star", [](double x, double y) { return is_within(star, x, y) ? 1.0 : 0.0; }},
  }};
  return all;
}

/// A portable float map of one channel, whose rows go from the lowest one upwards; scaled to let as much
/// light through as a circle does.
std::string portable_float_map(int width, int height, std::vector<float> values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  if (sum > 0) {
    const double scale = pi / 4 * static_cast<double>(values.size()) / sum;
    for (float& value : values) value = static_cast<float>(value * scale);
  }
  std::string bytes = concat("Pf\n", width, " ", height, "\n-1.0\n");
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(bits >> shift & 0xff));
  }
  return bytes;
}

std::string picture_of(const Opening& opening) {
  constexpr int kSide = 256;
  std::vector<float> values;
  const auto middle = [](int i) { return 2 * (i + 0.5) / kSide - 1; };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) values.push_back(static_cast<float>(opening(middle(x), middle(y))));
  }
  return portable_float_map(kSide, kSide, std::move(values));
}

/// IEC 61966-2-1.
double linear_of_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

/// The mean of red, green and blue of the pixels.
std::string grey_picture(const images::ImagePixels& image) {
  const auto width = static_cast<std::size_t>(image.size.width),
             height = static_cast<std::size_t>(image.size.height);
  std::vector<float> values;
  for (std::size_t i = 0; i < width * height; ++i) {
    const std::size_t pixel = (height - 1 - i / width) * width + i % width;
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += image.bytes.empty() ? double{image.floats[4 * pixel + c]}
                                 : linear_of_srgb((image.bytes[pixel] >> (8 * c) & 0xff) / 255.0);
    }
    values.push_back(static_cast<float>(sum / 3));
  }
  return portable_float_map(image.size.width, image.size.height, std::move(values));
}

}  // namespace

v1::BlobRef aperture_picture(Context& context, const std::string& name, SourceLocation where) {
  v1::BlobRef blob;
  for (const auto& [known, opening] : named_openings()) {
    if (name != known) continue;
    blob = context.blobs.add_bytes(picture_of(opening));
    blob.set_path(concat(name, ".pfm"));
    return blob;
  }
  const std::filesystem::path path = context.resolve(name);
  const absl::StatusOr<InputFile> file = InputFile::open(path);
  if (!file.ok()) {
    context.diagnostics.error(where,
                              concat("aperture: ", std::string(file.status().message()),
                                     "; nor is it \"gaussian\", \"square\", \"pentagon\" or \"star\""));
    return blob;
  }
  constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 24;
  const auto image = images::decode_image(file->bytes(), path.string(), kMostPixels);
  if (!image.ok()) {
    context.diagnostics.error(where, concat("aperture: ", std::string(image.status().message())));
    return blob;
  }
  blob = context.blobs.add_bytes(grey_picture(*image));
  blob.set_path(concat(path.stem().string(), ".pfm"));
  return blob;
}

}  // namespace tessera::client::pbrt
