#include "display/growing_image.h"

#include "absl/status/statusor.h"
#include "wire/colour_channels.h"

namespace tessera::client {

GrowingImage::GrowingImage(const Window& crop, std::int32_t columns, std::int32_t rows)
    : crop_(crop), columns_(columns), rows_(rows) {
  clear();
}

void GrowingImage::clear() {
  sums_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), {0, 0, 0, 0});
}

std::int32_t GrowingImage::column_of(std::int32_t x) const {
  return static_cast<std::int32_t>(std::int64_t{x - crop_.x0} * columns_ / crop_.width());
}
std::int32_t GrowingImage::row_of(std::int32_t y) const {
  return static_cast<std::int32_t>(std::int64_t{y - crop_.y0} * rows_ / crop_.height());
}

absl::StatusOr<Window> GrowingImage::add(const wire::TileResult& result) {
  const Window area{static_cast<std::int32_t>(result.x0), static_cast<std::int32_t>(result.y0),
                    static_cast<std::int32_t>(result.x1), static_cast<std::int32_t>(result.y1)};
  if (result.channels.size() < 3 || result.channels[0].name != wire::kColourChannels[0] ||
      area.x0 < crop_.x0 || area.y0 < crop_.y0 || area.x1 > crop_.x1 || area.y1 > crop_.y1) {
    return absl::InvalidArgumentError("a result is not of this picture");
  }
  const std::size_t pixels = result.pixel_count();
  std::size_t at = 0;
  for (std::int32_t y = area.y0; y < area.y1; ++y) {
    const std::size_t row = static_cast<std::size_t>(row_of(y)) * static_cast<std::size_t>(columns_);
    for (std::int32_t x = area.x0; x < area.x1; ++x, ++at) {
      std::array<float, 4>& sum = sums_[row + static_cast<std::size_t>(column_of(x))];
      for (std::size_t band = 0; band < 3; ++band) sum[band] += result.values[band * pixels + at];
      sum[3] += static_cast<float>(result.counts[at]);
    }
  }
  return Window{column_of(area.x0), row_of(area.y0), column_of(area.x1 - 1) + 1, row_of(area.y1 - 1) + 1};
}

std::optional<std::array<float, 3>> GrowingImage::color(std::int32_t column, std::int32_t row) const {
  const std::array<float, 4>& sum = sums_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                          static_cast<std::size_t>(column)];
  if (sum[3] == 0) return std::nullopt;
  return std::array<float, 3>{sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]};
}

}  // namespace tessera::client
