// Colours in tables, images and films.
#pragma once

namespace tessera::render {

/// Red, green and blue of linear Rec.709. A Spectrum (spectrum.h) has lanes of its own.
inline constexpr int kBands = 3;

}  // namespace tessera::render
