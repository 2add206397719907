#include "render/color/mip_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"

namespace tessera::render {

namespace {

/// Texels that kernels can address: four numbers each, by 32-bit indices.
constexpr std::int64_t kMostTexels = (std::int64_t{1} << 29) - 1;

/// Where texel i of a level comes from along one axis, in texels of the level before.
struct Part {
  int first = 0, count = 1;
  float weight[3] = {1, 0, 0};
};

/// Texel `i` of `to` even parts of `from` texels.
Part part_of(int i, int from, int to) {
  if (from == to) return {i};
  if (from % 2 == 0) return {2 * i, 2, {0.5f, 0.5f, 0}};
  // 2 to + 1 texels: the one in the middle of three goes to both neighbours, by what each covers of them.
  const auto whole = static_cast<float>(from), parts = static_cast<float>(to);
  return {2 * i, 3, {static_cast<float>(to - i) / whole, parts / whole, static_cast<float>(i + 1) / whole}};
}

std::vector<MipLevel> levels_of(std::int32_t width, std::int32_t height) {
  std::vector<MipLevel> levels;
  std::int64_t first = 0;
  for (;;) {
    const std::int32_t stride = width + 1;
    if (first + std::int64_t{stride} * height > kMostTexels) return {};
    levels.push_back({static_cast<std::int32_t>(first), width, height, stride});
    if (width == 1 && height == 1) return levels;
    first += std::int64_t{stride} * height;
    width = std::max(width / 2, 1), height = std::max(height / 2, 1);
  }
}

using Texel = std::array<float, 4>;

/// The two ways in which texels are stored. Those of 16 bits are averaged as integers where four are taken
/// evenly, and rounded to even, so that errors do not add up over the levels.
struct Texels16 {
  std::uint32_t* data;

  Texel load(std::size_t i) const {
    const std::uint32_t rg = data[2 * i], ba = data[2 * i + 1];
    return {static_cast<float>(rg & 0xffffu), static_cast<float>(rg >> 16), static_cast<float>(ba & 0xffffu),
            static_cast<float>(ba >> 16)};
  }
  void store(std::size_t i, const Texel& texel) const {
    const auto whole = [&](std::size_t c) {
      return static_cast<std::uint32_t>(std::lrint(std::clamp(texel[c], 0.0f, 65535.0f)));
    };
    data[2 * i] = whole(0) | whole(1) << 16;
    data[2 * i + 1] = whole(2) | whole(3) << 16;
  }
  void copy(std::size_t to, std::size_t from) const {
    data[2 * to] = data[2 * from], data[2 * to + 1] = data[2 * from + 1];
  }
  /// The mean of texels a, a + 1, b and b + 1.
  void average(std::size_t to, std::size_t a, std::size_t b) const {
    for (std::size_t half = 0; half < 2; ++half) {
      const auto mean = [&](int shift) {
        std::uint32_t sum = 0;
        for (const std::size_t texel : {a, a + 1, b, b + 1}) sum += data[2 * texel + half] >> shift & 0xffffu;
        return (sum + 1 + (sum >> 2 & 1)) >> 2;
      };
      data[2 * to + half] = mean(0) | mean(16) << 16;
    }
  }
};

struct Texels32 {
  float* data;

  Texel load(std::size_t i) const { return {data[4 * i], data[4 * i + 1], data[4 * i + 2], data[4 * i + 3]}; }
  void store(std::size_t i, const Texel& texel) const { std::copy_n(texel.data(), 4, data + 4 * i); }
  void copy(std::size_t to, std::size_t from) const { store(to, load(from)); }
  void average(std::size_t to, std::size_t a, std::size_t b) const {
    const Texel a0 = load(a), a1 = load(a + 1), b0 = load(b), b1 = load(b + 1);
    Texel mean;
    for (std::size_t c = 0; c < 4; ++c) mean[c] = 0.25f * ((a0[c] + a1[c]) + (b0[c] + b1[c]));
    store(to, mean);
  }
};

std::size_t texel_at(const MipLevel& level, int x, int y) {
  return static_cast<std::size_t>(level.first) + static_cast<std::size_t>(y) * level.stride +
         static_cast<std::size_t>(x);
}

/// The texel after the last of each row is its first: repeated images go on there.
template <class Texels>
void close_rows(const MipLevel& level, const Texels& texels) {
  for (int y = 0; y < level.height; ++y) texels.copy(texel_at(level, level.width, y), texel_at(level, 0, y));
}

template <class Texels>
void average_level(const MipLevel& from, const MipLevel& to, const Texels& texels) {
  const bool even = from.width % 2 == 0 && from.height % 2 == 0;
  for (int y = 0; y < to.height; ++y) {
    if (even) {
      for (int x = 0; x < to.width; ++x)
        texels.average(texel_at(to, x, y), texel_at(from, 2 * x, 2 * y), texel_at(from, 2 * x, 2 * y + 1));
      continue;
    }
    const Part rows = part_of(y, from.height, to.height);
    for (int x = 0; x < to.width; ++x) {
      const Part columns = part_of(x, from.width, to.width);
      Texel sum{};
      for (int j = 0; j < rows.count; ++j) {
        for (int i = 0; i < columns.count; ++i) {
          const Texel texel = texels.load(texel_at(from, columns.first + i, rows.first + j));
          const float weight = rows.weight[j] * columns.weight[i];
          for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * texel[c];
        }
      }
      texels.store(texel_at(to, x, y), sum);
    }
  }
}

template <class Texels>
void average_levels(const std::vector<MipLevel>& levels, const Texels& texels) {
  close_rows(levels[0], texels);
  for (std::size_t l = 1; l < levels.size(); ++l) {
    average_level(levels[l - 1], levels[l], texels);
    close_rows(levels[l], texels);
  }
}

/// Texels of full resolution: linear 8-bit values stay exact.
void fill_bytes(const TextureImage& image, MipPyramid& pyramid) {
  std::uint32_t color[256], alpha[256];
  for (std::uint32_t i = 0; i < 256; ++i) {
    color[i] = static_cast<std::uint32_t>(std::lrint(std::clamp(image.decode[i], 0.0f, 1.0f) * 65535.0f));
    alpha[i] = 257 * i;
  }
  std::size_t from = 0;
  for (int y = 0; y < image.height; ++y) {
    std::uint32_t* to = pyramid.texels16.data() + 2 * texel_at(pyramid.levels[0], 0, y);
    for (int x = 0; x < image.width; ++x, to += 2) {
      const std::uint32_t packed = image.texels8[from++];
      to[0] = color[packed & 255] | color[packed >> 8 & 255] << 16;
      to[1] = color[packed >> 16 & 255] | alpha[packed >> 24] << 16;
    }
  }
}

void fill_floats(const TextureImage& image, MipPyramid& pyramid) {
  const std::size_t row = 4 * static_cast<std::size_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    std::copy_n(image.texels32.data() + static_cast<std::size_t>(y) * row, row,
                pyramid.texels32.data() + 4 * texel_at(pyramid.levels[0], 0, y));
  }
}

}  // namespace

absl::Status check_pyramid(std::int32_t width, std::int32_t height, std::string_view name) {
  if (!levels_of(width, height).empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("image '", std::string(name), "' of ", width, "x", height,
                                                 " pixels is too large to be filtered: take 'bilinear'"));
}

absl::Status make_pyramid(TextureImage& image, std::string_view name) {
  if (auto s = check_pyramid(image.width, image.height, name); !s.ok()) return s;
  MipPyramid pyramid;
  pyramid.levels = levels_of(image.width, image.height);
  const MipLevel& last = pyramid.levels.back();
  const std::size_t texels = texel_at(last, last.stride, 0);
  if (image.format == TexelFormat::kFloat) {
    pyramid.texels32.resize(4 * texels);
    fill_floats(image, pyramid);
    image.texels32 = BigArray<float>();
    average_levels(pyramid.levels, Texels32{pyramid.texels32.data()});
  } else {
    pyramid.texels16.resize(2 * texels);
    fill_bytes(image, pyramid);
    image.texels8 = BigArray<std::uint32_t>();
    average_levels(pyramid.levels, Texels16{pyramid.texels16.data()});
  }
  image.pyramid = std::move(pyramid);
  return absl::OkStatus();
}

}  // namespace tessera::render
