#include "optics/read/pbrt_lens_file.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "optics/read/number_line.h"

namespace tessera::optics {

Prescription read_pbrt_lens(std::string_view bytes, std::vector<Fault>& faults) {
  const std::string plain = plain_text(bytes);
  const std::string_view text = plain;
  Prescription lens;
  // The first comment mostly is its name.
  if (text.starts_with('#')) {
    const std::string_view line = text.substr(1, text.find_first_of("\r\n") - 1);
    const std::size_t first = line.find_first_not_of(" \t#");
    if (first != std::string_view::npos) lens.name = line.substr(first);
  }
  bool any_stop = false;
  for (const TextLine& line : lines_of(text, '#')) {
    if (line.words.size() != 4) {
      faults.push_back({line.number, line.words.back().column,
                        absl::StrCat("a surface has four numbers: radius of curvature, thickness, index of "
                                     "refraction and diameter of the aperture; here are ",
                                     line.words.size())});
      continue;
    }
    double numbers[4] = {};
    bool sound = true;
    for (std::size_t i = 0; i < 4; ++i) {
      const Word& word = line.words[i];
      if (const auto value = number_of(word.text)) {
        numbers[i] = *value;
        continue;
      }
      sound = false;
      faults.push_back(
          {line.number, word.column, absl::StrCat("'", std::string(word.text), "' is no number")});
    }
    if (!sound) continue;
    Surface surface;
    surface.radius = numbers[0], surface.thickness = numbers[1], surface.diameter = numbers[3];
    surface.line = line.number;
    if (numbers[2] != 0) surface.behind.index = numbers[2];
    if (surface.radius == 0 && !any_stop) surface.stop = any_stop = true;
    lens.surfaces.push_back(std::move(surface));
  }
  return lens;
}

}  // namespace tessera::optics
