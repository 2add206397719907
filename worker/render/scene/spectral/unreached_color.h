// Colours of a scene that no spectrum has.
#pragma once

#include <string>

#include "render/color/texture_table.h"
#include "spectra/color/rgb.h"

namespace tessera::render {

/// In linear Rec.709, with the difference to the nearest colour that there is a spectrum of, in CIEDE2000.
struct UnreachedColor {
  spectra::Rgb color;
  double error = 0;

  /// Becomes the one that differs more.
  void add(const UnreachedColor& other) {
    if (other.error > error) *this = other;
  }
  /// Whether it differs by more than colours that spectra are said to have.
  bool is_told() const;
  /// "no spectrum has the colour (-0.2, 0.9, 0.1): ...".
  std::string to_string() const;
};

/// The texel or constant of a texture's tree that is furthest below 0, whose negative components become 0.
UnreachedColor worst_texel(const TextureTable& textures, std::int32_t node);

}  // namespace tessera::render
