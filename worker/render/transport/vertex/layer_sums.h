// Light that is gathered from many photons, layer by layer.
#pragma once

#include <bit>
#include <cstdint>

#include "layers/limits.h"
#include "render/color/spectrum.h"
#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

/// Sums of 16 lanes for each layer.
class LayerSums {
 public:
  LayerSums() {}  // what no light was added to is not zeroed

  /// Adds the lanes' light to the layers whose bits are set.
  void add(Spectrum light, Int layers, Mask lanes) {
    std::uint32_t some = 0;
    alignas(64) std::int32_t bits[kWidth];
    layers.store(bits);
    for (std::uint32_t left = lanes.bits(); left != 0; left &= left - 1)
      some |= static_cast<std::uint32_t>(bits[std::countr_zero(left)]);
    for (; some != 0; some &= some - 1) {
      const int layer = std::countr_zero(some);
      add_to(layer, light, lanes & ((layers & Int(std::int32_t(1u << layer))) != 0));
    }
  }
  void add_to(int layer, Spectrum light, Mask lanes) {
    const Spectrum more = select_or_zero(lanes, light);
    sums_[layer] = (touched_ >> layer & 1) != 0 ? sums_[layer] + more : more;
    touched_ |= 1u << layer;
  }
  void scale(Spectrum factor) {
    for (std::uint32_t left = touched_; left != 0; left &= left - 1)
      sums_[std::countr_zero(left)] = sums_[std::countr_zero(left)] * factor;
  }
  /// Calls f(layer, sum) for those that have light.
  template <class F>
  void for_each(F&& f) const {
    for (std::uint32_t left = touched_; left != 0; left &= left - 1)
      f(std::countr_zero(left), sums_[std::countr_zero(left)]);
  }

 private:
  std::uint32_t touched_ = 0;  // bits
  Spectrum sums_[layers::kMaxLayers];
};

}  // namespace tessera::render::TESSERA_ISA
