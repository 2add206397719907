// Paths of bidirectional path tracing one by one: each in one way (s, t), given by its numbers, weighed
// against all others.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/integrator/integrator.h"
#include "render/transport/bdpt/frontier.h"
#include "render/transport/bdpt/light_starts.h"
#include "render/transport/bdpt/light_vertices.h"
#include "render/transport/bdpt/ways.h"
#include "render/transport/mlt/primary_space.h"
#include "render/transport/vertex/light_start.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/transit.h"

namespace tessera::render::TESSERA_ISA {

class PathMaker final : public PathSpace {
 public:
  explicit PathMaker(const IntegratorContext& context);

  void make(PathBatch& batch) override;
  Wavelengths wavelengths(const PathBatch& batch, int packet) const override {
    return wavelengths_of(PrimaryNumbers(batch, packet));
  }
  const Response& response() const override { return scene_.sensor.response; }
  int ways(int events) const override { return events + (connects_ ? 2 : 1); }
  int max_events() const override { return scene_.max_depth; }
  bool asks_for(int place_of_event) const override;

 private:
  struct Event;

  /// Both subpaths have them.
  Wavelengths wavelengths_of(const PrimaryNumbers& numbers) const {
    return sample_wavelengths(scene_.sensor.response.sensitivity,
                              [&] { return numbers.get_2d(dimension::kTime).y; });
  }

  // The light's half: subpaths of from_light - 1 events.
  void trace_light(PathBatch& batch);
  void start_at_lights(const PathBatch& batch);
  void shade_light(PathBatch& batch, int event);
  PartialWeights arrive_from_light(int event, int packet, const WidePath& path, const Vertex& v,
                                   Mask hit) const;
  void join_to_sensor(PathBatch& batch, const LightVertex& here, int event, int packet, Mask wanted);
  void go_on_from_light(const LightVertex& here, const WidePath& path, const PrimaryNumbers& numbers,
                        int event, int packet, Mask hit);

  // The eye's half: subpaths of from_eye - 1 events, the last of which is where they are joined.
  void trace_eye(PathBatch& batch);
  void start_at_eye(PathBatch& batch);
  void shade_eye(PathBatch& batch, int depth);
  void add_emission_of_media(PathBatch& batch, int depth);
  void add_environment(PathBatch& batch, const Event& e, Mask missed);
  void add_emission(PathBatch& batch, const Event& e, Mask hit);
  void sample_one_light(PathBatch& batch, const Event& e, Mask wanted);
  void join(PathBatch& batch, const Event& e, const LightVertex& y, int event, Mask wanted);
  void scatter_from_eye(const Event& e, Mask hit);

  void queue(const PathBatch& batch, const Event& e, WayLight way, std::uint32_t salt);
  void queue(const PathBatch& batch, WideConnection ray, Int slot, std::uint32_t salt, Mask shines);
  void trace_joins(PathBatch& batch);
  void intersect(bool from_sensor);
  TransitNumbers numbers_on_the_way(const PathBatch& batch, int event, bool from_light) const;
  /// batch.light += more
  static void add(PathBatch& batch, Spectrum more, int packet, Mask lanes);
  /// The factor of light of paths of so many events, in that of the number of ways; of what comes from the
  /// eye, also the film's area and the exposure.
  Float scale_of(const PathBatch& batch, int packet, bool from_eye) const;

  const IntegratorContext context_;
  const SceneTables& scene_;
  const RayQuery& rays_;
  RenderStats& stats_;
  const bool connects_;
  // The part of the film's plane that some pixel sees
  float left_, top_, width_, height_;
  float film_area_;

  Frontier frontier_;
  WeightState weights_;
  LightStarts starts_;
  LightVertex unkept_vertex_;
  LightVertices kept_;  // ends of subpaths from lights

  ConnectionQueue joins_;
  // Volumetric scenes only
  Transit transit_;
  HitState join_hits_;
  std::optional<SampleBatch> emission_;
};

}  // namespace tessera::render::TESSERA_ISA
