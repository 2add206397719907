// The light's half of bidirectional path tracing: a batch of subpaths from the lights, whose vertices are
// joined to the camera at once and kept for subpaths from the eye.
#pragma once

#include <memory>
#include <vector>

#include "render/integrator/bdpt/frontier.h"
#include "render/integrator/bdpt/strategy.h"
#include "render/integrator/integrator.h"
#include "render/integrator/vertex/camera_joins.h"
#include "render/integrator/vertex/light_start.h"
#include "render/integrator/vertex/sample_keys.h"
#include "render/integrator/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen vertices of subpaths from lights, the same number of events away from these.
struct LightVertex {
  Mask joinable;
  Spectrum beta;  // flux that arrives
  PartialWeights weights;
  Vertex vertex;  // its wo points back to the light
};

/// Takes vertices of subpaths from lights.
class LightVertexSink {
 public:
  virtual ~LightVertexSink() = default;
  virtual void add(const LightVertex& vertices, int event) = 0;
};

/// What becomes of subpaths from lights.
struct LightUses {
  bool keep = false;                // vertices that a subpath from the eye may be joined to
  Film* film = nullptr;             // takes their light, joined to the camera
  LightVertexSink* sink = nullptr;  // takes all vertices that can be joined
};

class LightSubpaths {
 public:
  LightSubpaths(const IntegratorContext& context, StrategyFilter filter)
      : context_(context),
        scene_(context.scene),
        rays_(context.rays),
        stats_(context.stats),
        filter_(filter),
        paths_a_pass_(static_cast<float>(context.scene.camera.width) *
                      static_cast<float>(context.scene.camera.height)),
        transit_(context),
        joins_(context) {}

  /// Subpaths traced from now on are weighed against merging, where a vertex meets so many photons for one
  /// that would be joined.
  void merge(float photons_a_join) { merged_ = power(Float(photons_a_join)); }
  /// What that adds to the sums at a vertex.
  Float merged_at(const Vertex& v) const { return select(v.in_medium, 0.0f, merged_); }

  /// Traces `count` subpaths that have these random numbers.
  void trace(const SampleKeys& keys, int count, const LightUses& uses);

  /// Events, counted from 0, that some vertices are kept of.
  int events() const { return static_cast<int>(kept_.size()) / kPackets; }
  /// Null where none of a packet's subpaths comes so far.
  const LightVertex* at(int event, int packet) const {
    const std::int32_t index = kept_[static_cast<std::size_t>(event * kPackets + packet)];
    return index < 0 ? nullptr : pool_[static_cast<std::size_t>(index)].get();
  }

  /// Paths that one pass joins to the camera: so many samples the whole film has of that strategy.
  float paths_a_pass() const { return paths_a_pass_; }

 private:
  void start(const SampleKeys& keys, int count);
  void enter_media();
  void shade(const SampleKeys& keys, int event, const LightUses& uses);
  PartialWeights arrive(int event, int packet, const WidePath& path, const Vertex& v, Mask hit) const;
  void join_to_camera(const LightVertex& here, int event, Vec2 u_lens, UInt key, const FilmRect& rect);
  void go_on(const LightVertex& here, const WidePath& path, const Sampler& numbers, int event, int packet,
             Mask hit);
  LightVertex& new_vertex(int event, int packet);

  const IntegratorContext context_;
  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const StrategyFilter filter_;
  const float paths_a_pass_;
  Float merged_ = Float(0.0f);
  Frontier frontier_;
  WeightState weights_;
  // By slot, of the subpath's start
  alignas(64) Lanes<std::int32_t> light_;
  Vec3Lanes point_, normal_;
  Transit transit_;       // volumetric scenes only, like the next two
  ConnectionQueue ways_;  // to the media of the lights
  alignas(64) Lanes<std::int32_t> media_;
  CameraJoins joins_;
  LightVertex passing_;  // that is not kept
  std::vector<std::unique_ptr<LightVertex>> pool_;
  std::size_t used_ = 0;            // of the pool
  std::vector<std::int32_t> kept_;  // index into the pool, by event and packet; -1: none
};

}  // namespace tessera::render::TESSERA_ISA
