// The light's half of bidirectional path tracing: a batch of subpaths from the lights, whose vertices are
// joined to the camera at once and kept for subpaths from the eye.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/transport/bdpt/frontier.h"
#include "render/transport/bdpt/light_starts.h"
#include "render/transport/bdpt/light_vertices.h"
#include "render/transport/bdpt/strategy.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_start.h"
#include "render/transport/vertex/sample_keys.h"
#include "render/transport/vertex/sensor_joins.h"
#include "render/transport/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

/// Takes vertices of subpaths from lights.
class LightVertexSink {
 public:
  virtual ~LightVertexSink() = default;
  virtual void add(const LightVertex& vertices, int event) = 0;
};

/// Which lobes an event of a subpath from a light is of, apart from those of the path from the eye that has
/// the same numbers.
TESSERA_INLINE LobeChoice light_lobe(const Sampler& numbers, int event, bool to_connection) {
  return {numbers, event, to_connection, dimension::kLightLayerLobes};
}

/// Uses of subpaths from lights.
struct LightUses {
  bool keep = false;                // vertices that a subpath from the eye may be joined to
  Film* film = nullptr;             // takes their light, joined to the camera
  LightVertexSink* sink = nullptr;  // takes all vertices that can be joined
  std::optional<float> time = {};   // time of all, in scenes with motion; none: each has its own
};

class LightSubpaths {
 public:
  LightSubpaths(const IntegratorContext& context, StrategyFilter filter)
      : context_(context),
        scene_(context.scene),
        rays_(context.rays),
        stats_(context.stats),
        filter_(filter),
        paths_a_pass_(static_cast<float>(context.scene.sensor.width) *
                      static_cast<float>(context.scene.sensor.height)),
        starts_(context),
        transit_(context),
        joins_(context) {}

  /// Subpaths traced from now on are weighed against merging, where a vertex meets so many photons for one
  /// that would be joined.
  void merge(float photons_a_join) { merged_ = power(Float(photons_a_join)); }
  /// Returns what merging adds to the sums at a vertex.
  Float merged_at(const Vertex& v) const { return select(v.in_medium, 0.0f, merged_); }

  /// Traces `count` subpaths that have these random numbers.
  void trace(const SampleKeys& keys, int count, const LightUses& uses);

  /// Events, counted from 0, that some vertices are kept of.
  int events() const { return kept_.events(); }
  /// Null where none of a packet's subpaths comes so far.
  const LightVertex* at(int event, int packet) const { return kept_.at(event, packet); }

  /// Paths that one pass joins to the camera: so many samples the whole film has of that strategy.
  float paths_a_pass() const { return paths_a_pass_; }

 private:
  void start(const SampleKeys& keys, int count, std::optional<float> time);
  void shade(const SampleKeys& keys, int event, const LightUses& uses);
  PartialWeights arrive(int event, int packet, const WidePath& path, const Vertex& v, Mask hit) const;
  void join_to_sensor(const LightVertex& here, int event, const Sampler& numbers, UInt key,
                      const FilmRect& rect);
  void go_on(const LightVertex& here, const WidePath& path, const Sampler& numbers, int event, int packet,
             Mask hit);

  const IntegratorContext context_;
  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const StrategyFilter filter_;
  const float paths_a_pass_;
  Float merged_ = Float(0.0f);
  Frontier frontier_;
  WeightState weights_;
  LightStarts starts_;
  Transit transit_;  // volumetric scenes only
  SensorJoins joins_;
  LightVertex unkept_vertex_;
  LightVertices kept_;
};

}  // namespace tessera::render::TESSERA_ISA
