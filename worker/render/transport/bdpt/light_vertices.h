// Vertices of subpaths from lights, kept for subpaths from the eye.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/transport/bdpt/frontier.h"
#include "render/transport/vertex/partial_weights.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen vertices of subpaths from lights, the same number of events away from these.
struct LightVertex {
  Mask joinable;
  Spectrum beta;  // flux that arrives
  [[no_unique_address]] Wavelengths wavelengths;
  Int dispersed;  // PathFields::dispersed
  PartialWeights weights;
  Vertex vertex;    // vertex whose wo points back to the light
  Int layer_state;  // state before the event that the vertex is; set where there are layers
};

/// Those of a batch, by event and packet. Memory is kept for the next batch.
class LightVertices {
 public:
  void clear() {
    used_vertices_ = 0;
    kept_.clear();
  }
  /// Room for the vertices of a packet, which are there from now on.
  LightVertex& add(int event, int packet) {
    if (used_vertices_ == pool_.size()) pool_.push_back(std::unique_ptr<LightVertex>(new LightVertex));
    const auto place = static_cast<std::size_t>(event * kPackets + packet);
    if (kept_.size() <= place) kept_.resize(static_cast<std::size_t>(event + 1) * kPackets, -1);
    kept_[place] = static_cast<std::int32_t>(used_vertices_);
    return *pool_[used_vertices_++];
  }

  /// Events, counted from 0, that some vertices are there of.
  int events() const { return static_cast<int>(kept_.size()) / kPackets; }
  /// Null where there are none.
  const LightVertex* at(int event, int packet) const {
    const std::int32_t index = kept_[static_cast<std::size_t>(event * kPackets + packet)];
    return index < 0 ? nullptr : pool_[static_cast<std::size_t>(index)].get();
  }

 private:
  std::vector<std::unique_ptr<LightVertex>> pool_;
  std::size_t used_vertices_ = 0;   // the first ones of the pool
  std::vector<std::int32_t> kept_;  // index into the pool, by event and packet; -1: none
};

}  // namespace tessera::render::TESSERA_ISA
