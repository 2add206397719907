#include "scheduler/spot.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

// Pixels beyond each edge that are rendered, too, where samples go into several pixels: those of usual
// filters.
constexpr double kBorder = 4;

std::uint32_t first_cell(std::uint32_t begin) { return begin / kSpotSide; }
std::uint32_t cells(std::uint32_t begin, std::uint32_t end) {
  return end > begin ? (end - 1) / kSpotSide - first_cell(begin) + 1 : 0;
}

}  // namespace

std::uint32_t spots_in(const v1::PixelRect& pixels) {
  return cells(pixels.x0(), pixels.x1()) * cells(pixels.y0(), pixels.y1());
}

v1::PixelRect spot_pixels(const v1::PixelRect& pixels, std::uint32_t spot) {
  const std::uint32_t columns = cells(pixels.x0(), pixels.x1());
  const std::uint32_t x = (first_cell(pixels.x0()) + (spot - 1) % columns) * kSpotSide;
  const std::uint32_t y = (first_cell(pixels.y0()) + (spot - 1) / columns) * kSpotSide;
  v1::PixelRect rect;
  rect.set_x0(std::max(x, pixels.x0()));
  rect.set_y0(std::max(y, pixels.y0()));
  rect.set_x1(std::min(x + kSpotSide, pixels.x1()));
  rect.set_y1(std::min(y + kSpotSide, pixels.y1()));
  return rect;
}

std::uint32_t choose_spot(const std::string& key, const v1::LeaseToken& token, const v1::PixelRect& pixels) {
  const std::uint32_t count = spots_in(pixels);
  if (count < 2) return 0;
  const std::string digest =
      wire::sha256_hex(absl::StrCat(key, " spot ", token.job_id(), " ", token.unit_index(), " ",
                                    token.ranges(), " ", token.attempt(), " ", token.epoch()));
  return 1 + static_cast<std::uint32_t>(std::stoull(digest.substr(0, 15), nullptr, 16) % count);
}

double spot_share(const v1::PixelRect& pixels, bool scatters) {
  const double border = scatters ? kBorder : 0;
  const auto area = [border](double width, double height) {
    return (width + 2 * border) * (height + 2 * border);
  };
  const double whole = area(pixels.x1() - pixels.x0(), pixels.y1() - pixels.y0());
  return std::min(1.0, area(kSpotSide, kSpotSide) / whole);
}

}  // namespace tessera::server
