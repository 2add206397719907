// The table of layer energies, as the model reads it.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/tables/film_table.h"
#include "render/bsdf/tables/gltf_layer_table.h"

namespace tessera::render::TESSERA_ISA {

/// Energies of layers of one roughness [layer_table.h].
struct LayerEnergy {
  Float normal, grazing, sheen;

  TESSERA_INLINE Float mirror() const { return normal + grazing; }
  TESSERA_INLINE Spectrum of(Spectrum f0, Float f90) const { return f0 * normal + Spectrum(f90 * grazing); }
  TESSERA_INLINE Float of(Float f0, Float f90) const { return f0 * normal + f90 * grazing; }
};

/// Two cosines that stand for those of all facets that reflect [film_table.h].
struct FacetCosines {
  Float smaller, larger, share;  // share: what counts as the smaller one
};

/// The rows of the layer table for one roughness of each lane.
class LayerRows {
 public:
  TESSERA_INLINE LayerRows(const BsdfParams& params, Float roughness, Mask lanes)
      : table_(params.coat_tables), offset_(params.coat_table), lanes_(lanes) {
    const Float position = clamp(roughness, 0.0f, 1.0f) * (kLayerRows - 1.0f);
    const Float low = min(floor(position), kLayerRows - 2.0f);
    row_ = to_int(low);
    t_ = position - low;
  }

  /// Energies of light at a cosine to the normal.
  TESSERA_INLINE LayerEnergy at(Float cosine) const {
    const Column column(cosine);
    const Int entry = row_ * kLayerColumns + column.index + kLayerRows;
    return mixed(t_, mixed(column.t, load(entry), load(entry + 1)),
                 mixed(column.t, load(entry + kLayerColumns), load(entry + (kLayerColumns + 1))));
  }
  /// Energies of diffuse light.
  TESSERA_INLINE LayerEnergy mean() const { return mixed(t_, load(row_), load(row_ + 1)); }

  TESSERA_INLINE FacetCosines facets_at(Float cosine, const float* film_table) const {
    const Column column(cosine);
    const Int entry = row_ * kLayerColumns + column.index;
    const auto one = [&](std::int32_t further) {
      return gather4(film_table + kFacetCosines, (entry + further) * kFilmEntry, lanes_);
    };
    const Float4 a = one(0), b = one(1), c = one(kLayerColumns), d = one(kLayerColumns + 1);
    const auto value = [&](int i) {
      return lerp(t_, lerp(column.t, a.c[i], b.c[i]), lerp(column.t, c.c[i], d.c[i]));
    };
    return {value(0), value(1), value(2)};
  }

 private:
  struct Column {
    Int index;
    Float t;

    TESSERA_INLINE explicit Column(Float cosine) {
      const Float position = clamp(sqrt(max(cosine, 0.0f)), 0.0f, 1.0f) * (kLayerColumns - 1.0f);
      const Float low = min(floor(position), kLayerColumns - 2.0f);
      index = to_int(low), t = position - low;
    }
  };

  TESSERA_INLINE LayerEnergy load(Int entry) const {
    const Float4 values = gather4(table_, offset_ + entry * kLayerEntry, lanes_);
    return {values.c[0], values.c[1], values.c[2]};
  }
  static TESSERA_INLINE LayerEnergy mixed(Float t, const LayerEnergy& a, const LayerEnergy& b) {
    return {lerp(t, a.normal, b.normal), lerp(t, a.grazing, b.grazing), lerp(t, a.sheen, b.sheen)};
  }

  const float* table_;
  Int offset_;
  Mask lanes_;
  Int row_;
  Float t_;
};

/// Schlick's reflectance, over diffuse light.
template <class Value>
TESSERA_INLINE Value schlick_mean(Value f0, Value f90) {
  return f0 + (f90 - f0) * (1.0f / 21);
}

/// The light that is scattered between the facets, as a part of what single scattering loses: the geometric
/// series of the mean reflectance and of what diffuse light loses [Kulla & Conty 2017].
/// `kept` is what a mirror would reflect.
TESSERA_INLINE Float between_facets(Float mean, Float kept) {
  return sqr(mean) * kept / max(1.0f - mean * (1.0f - kept), 1e-6f);
}

}  // namespace tessera::render::TESSERA_ISA
