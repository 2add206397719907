#include "display/half_blocks.h"

#include <algorithm>
#include <optional>

#include "absl/strings/str_cat.h"
#include "image/png.h"

namespace tessera::client {
namespace {

using Color = std::optional<std::array<float, 3>>;

std::string paint(const char* what, const Color& color) {
  if (!color) return "";
  return absl::StrCat("\x1b[", what, ";2;", srgb_byte((*color)[0]), ";", srgb_byte((*color)[1]), ";",
                      srgb_byte((*color)[2]), "m");
}

}  // namespace

std::pair<std::int32_t, std::int32_t> half_block_cells(const Window& crop, int columns, int lines) {
  const double wide = std::max(1, columns), high = std::max(1, lines) * 2.0;
  const double scale = std::min({wide / crop.width(), high / crop.height(), 1.0});
  const auto cells = [scale](std::int32_t pixels) {
    return std::max(1, static_cast<std::int32_t>(pixels * scale));
  };
  return {cells(crop.width()), cells(crop.height())};
}

std::string half_blocks(const GrowingImage& image) {
  std::string text;
  for (std::int32_t row = 0; row < image.rows(); row += 2) {
    for (std::int32_t column = 0; column < image.columns(); ++column) {
      const Color above = image.color(column, row);
      const Color below = row + 1 < image.rows() ? image.color(column, row + 1) : std::nullopt;
      if (!above && !below) {
        text += "\x1b[0m ";
      } else if (!above) {
        absl::StrAppend(&text, "\x1b[0m", paint("38", below), "\u2584");
      } else {
        absl::StrAppend(&text, "\x1b[0m", paint("38", above), paint("48", below), "\u2580");
      }
    }
    text += "\x1b[0m\n";
  }
  return text;
}

}  // namespace tessera::client
