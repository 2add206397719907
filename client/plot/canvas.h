// A page that diagrams are drawn on: cairo's for files, or the markup of an SVG within a web page.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace tessera::client {

/// sRGB codes.
using PageColor = std::array<std::uint8_t, 3>;

/// Points of the page from its upper left corner; y grows downwards.
struct PagePoint {
  double x = 0, y = 0;
};
struct PageBox {
  double x = 0, y = 0, width = 0, height = 0;
};

/// A colour, and the name of the style that takes its place in a web page, which has styles for light and
/// dark; null: the colour itself.
struct Paint {
  PageColor color{};
  const char* style = nullptr;
};

inline constexpr Paint kPageInk{{33, 38, 46}, "ink"}, kPageFaint{{92, 101, 112}, "soft"},
    kPageGrid{{220, 223, 227}, "grid"}, kPageData{{0, 114, 178}, "data"},  // blue of [Okabe2008]
    kPageGround{{255, 255, 255}, "ground"};

struct Stroke {
  Paint paint = kPageInk;
  double width = 1;
  bool dashed = false;
};

enum class TextAlign { kLeft, kMiddle, kRight };

struct TextStyle {
  double size = 12;
  TextAlign align = TextAlign::kLeft;
  double turned = 0;  // radians, clockwise about its place
  bool bold = false;
  Paint paint = kPageInk;
  std::optional<Paint> halo{};  // an outline that parts the letters from what is behind them
};

/// Rows from the top.
struct Pixels {
  std::uint32_t width = 0, height = 0;
  std::vector<PageColor> colors;
};

class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual void line(std::span<const PagePoint> points, bool closed, const Stroke& stroke) = 0;
  virtual void rectangle(const PageBox& box, const Paint& fill) = 0;
  virtual void disc(const PagePoint& middle, double radius, const Paint& fill) = 0;
  /// `at` is on the base line of the letters.
  virtual void text(const std::string& text, const PagePoint& at, const TextStyle& style) = 0;
  /// Pixels become rectangles of one colour each.
  virtual void pixels(const PageBox& box, const Pixels& pixels) = 0;
};

using DrawOn = std::function<void(Canvas& canvas)>;

/// Draws so many points as .png (with twice as many pixels each way) or .svg, on white. InvalidArgument for
/// another kind of file. The file is replaced as a whole (image/atomic_file.h).
absl::Status write_drawing(const std::string& path, double width, double height, const DrawOn& draw);

/// Returns an <svg> element without namespace, scripts or links, for a page of HTML whose styles are
/// described at Paint. `label` tells those who cannot see it what it shows.
std::string svg_element(double width, double height, const std::string& label, const DrawOn& draw);

/// The bytes of a PNG file.
std::string png_of(const Pixels& pixels);

/// Text as it stands between the tags of XML or HTML, and in quoted attributes: markup is escaped, and bytes
/// that are no text become U+FFFD.
std::string markup_escaped(const std::string& text);

}  // namespace tessera::client
