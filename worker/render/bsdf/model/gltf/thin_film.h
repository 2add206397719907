// A thin film on a boundary [Belcour & Barla 2017].
#pragma once

#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {

struct ThinFilm {
  const float* table;  // bsdf/tables/film_table.h
  Float eta;           // index of the film, at least 1; that of the outside is 1
  Float thickness_nm;
  [[no_unique_address]] Wavelengths wavelengths;

  /// Reflectance for unpolarised light from outside under `cosine` >= 0 with the normal, where what is below
  /// the film reflects `f0` of the light along the normal without it. 0 to 1.
  ///
  /// Both boundaries have Fresnel's reflectance; the base has the real index that f0 is of [KHR_materials_
  /// iridescence]. The series in the number of round trips, which is exact, ends where light that makes more
  /// of them does not count: after one or two, but along the surface.
  Spectrum reflectance(Float cosine, Spectrum f0, Mask active) const;
};

}  // namespace tessera::render::TESSERA_ISA
