#include <cmath>
#include <string_view>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "plot/canvas.h"

namespace tessera::client {
namespace {

/// Bytes of the character that `text` begins with; 0 where it begins with none that XML may hold (UTF-8,
/// [RFC 3629]).
std::size_t character_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first >= 0x20 || first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  const std::size_t length = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  if (length == 0 || text.size() < length) return 0;
  std::uint32_t code = first & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool overlong = code < (length == 2 ? 0x80u : length == 3 ? 0x800u : 0x10000u);
  const bool surrogate = code >= 0xd800 && code < 0xe000, no_character = code == 0xfffe || code == 0xffff;
  return overlong || surrogate || no_character || code > 0x10ffff ? 0 : length;
}

/// Hundredths of a point are finer than any screen.
std::string coordinate(double value) {
  std::string text = absl::StrFormat("%.2f", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string css_color(const PageColor& color) {
  return absl::StrFormat("#%02x%02x%02x", color[0], color[1], color[2]);
}

/// "fill" or "stroke" as a class of the page's style sheet, or as the colour.
std::string paint_attribute(const char* property, const Paint& paint) {
  if (paint.style == nullptr) return absl::StrCat(" ", property, "=\"", css_color(paint.color), "\"");
  return absl::StrCat(" class=\"", property, "-", paint.style, "\"");
}

class SvgCanvas final : public Canvas {
 public:
  void line(std::span<const PagePoint> points, bool closed, const Stroke& stroke) override {
    if (points.empty()) return;
    absl::StrAppend(&markup_, "<path d=\"");
    const char* command = "M";
    for (const PagePoint& point : points) {
      absl::StrAppend(&markup_, command, coordinate(point.x), " ", coordinate(point.y));
      command = "L";
    }
    absl::StrAppend(&markup_, closed ? "Z" : "", "\" fill=\"none\" stroke-width=\"", coordinate(stroke.width),
                    "\" stroke-linejoin=\"round\"", stroke.dashed ? " stroke-dasharray=\"5 3\"" : "",
                    paint_attribute("stroke", stroke.paint), "/>");
  }

  void rectangle(const PageBox& box, const Paint& fill) override {
    absl::StrAppend(&markup_, "<rect", box_attributes(box), paint_attribute("fill", fill), "/>");
  }

  void disc(const PagePoint& middle, double radius, const Paint& fill) override {
    absl::StrAppend(&markup_, "<circle cx=\"", coordinate(middle.x), "\" cy=\"", coordinate(middle.y),
                    "\" r=\"", coordinate(radius), "\"", paint_attribute("fill", fill), "/>");
  }

  void text(const std::string& text, const PagePoint& at, const TextStyle& style) override {
    const std::string x = coordinate(at.x), y = coordinate(at.y);
    absl::StrAppend(&markup_, "<text x=\"", x, "\" y=\"", y, "\" font-size=\"", coordinate(style.size), "\"");
    if (style.align != TextAlign::kLeft) {
      absl::StrAppend(&markup_, " text-anchor=\"", style.align == TextAlign::kMiddle ? "middle" : "end",
                      "\"");
    }
    if (style.bold) absl::StrAppend(&markup_, " font-weight=\"bold\"");
    if (style.turned != 0) {
      absl::StrAppend(&markup_, " transform=\"rotate(", coordinate(style.turned * 180 / M_PI), " ", x, " ", y,
                      ")\"");
    }
    if (style.halo) {
      // An element has one class: the halo's colour is its own where the letters have a style.
      absl::StrAppend(&markup_, " paint-order=\"stroke\" stroke-linejoin=\"round\" stroke-width=\"",
                      coordinate(0.32 * style.size), "\" stroke=\"", css_color(style.halo->color), "\"");
    }
    absl::StrAppend(&markup_, paint_attribute("fill", style.paint), ">", markup_escaped(text), "</text>");
  }

  void pixels(const PageBox& box, const Pixels& pixels) override {
    if (pixels.width == 0 || pixels.height == 0) return;
    std::string encoded;
    absl::Base64Escape(png_of(pixels), &encoded);
    absl::StrAppend(&markup_, "<image", box_attributes(box),
                    " preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" "
                    "href=\"data:image/png;base64,",
                    encoded, "\"/>");
  }

  const std::string& markup() const { return markup_; }

 private:
  static std::string box_attributes(const PageBox& box) {
    return absl::StrCat(" x=\"", coordinate(box.x), "\" y=\"", coordinate(box.y), "\" width=\"",
                        coordinate(box.width), "\" height=\"", coordinate(box.height), "\"");
  }

  std::string markup_;
};

}  // namespace

std::string markup_escaped(const std::string& text) {
  std::string escaped;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t length = character_length(rest);
    const char first = rest.front();
    if (length == 0) {
      escaped += "\xEF\xBF\xBD";
    } else if (first == '&') {
      escaped += "&amp;";
    } else if (first == '<') {
      escaped += "&lt;";
    } else if (first == '>') {
      escaped += "&gt;";
    } else if (first == '"') {
      escaped += "&quot;";
    } else {
      escaped.append(rest.substr(0, length));
    }
    rest.remove_prefix(length == 0 ? 1 : length);
  }
  return escaped;
}

std::string svg_element(double width, double height, const std::string& label, const DrawOn& draw) {
  SvgCanvas canvas;
  draw(canvas);
  return absl::StrCat("<svg viewBox=\"0 0 ", coordinate(width), " ", coordinate(height), "\" width=\"",
                      coordinate(width), "\" height=\"", coordinate(height), "\" role=\"img\" aria-label=\"",
                      markup_escaped(label), "\">", canvas.markup(), "</svg>");
}

}  // namespace tessera::client
