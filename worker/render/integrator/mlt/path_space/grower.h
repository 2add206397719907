// Puts new vertices between what is kept of paths, sixteen paths at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "render/integrator/bdpt/frontier.h"
#include "render/integrator/integrator.h"
#include "render/integrator/mlt/path_space/measure.h"
#include "render/integrator/mlt/path_space/transitions.h"
#include "render/integrator/vertex/vertex.h"
#include "render/sampling/sampler.h"

namespace tessera::render::TESSERA_ISA {

/// Perturbations change directions by an angle between these two, in radians, each of its octaves as likely
/// [Veach 1997, section 11.4.4]: as likely there as back.
inline constexpr float kLeastAngle = 1e-4f, kLargestAngle = 0.1f;

/// Plan of what a path is to become.
struct Growth {
  ExplicitPath* path = nullptr;  // with its events, time, place on the lens, and the vertices that it keeps
  KeptEnds kept{};
  int from_eye = 0, from_light = 0;  // vertices that are added
  float film_x = 0, film_y = 0;      // where a path from the camera begins
  /// The path with as many vertices that is followed: through the same kinds of delta lobes, and elsewhere in
  /// directions near its own. Null: directions are sampled.
  const ExplicitPath* followed = nullptr;
  std::uint32_t number = 0;  // of its random numbers
  /// The path from the camera ends at the first light that it meets after an event, at the latest where the
  /// path's events say.
  bool until_light = false;
  bool alive = true;  // the path may be made yet

  /// No edge is put between two vertices: the path from the camera meets a light.
  bool ends_by_chance() const { return kept.light == 0 && from_light == 0; }
  /// The vertex on the eye's side of the edge that joins both parts.
  int last_from_eye() const { return kept.eye + from_eye; }

  // The vertices that rays leave in a step, of those that are traced from either side. A path from a new end
  // on a light has its first ray with the end.
  int leaves_from_eye(int step) const { return kept.eye + step; }
  int leaves_from_light(int step) const { return path->events + 1 - std::max(kept.light - 1, 0) - step; }
  int light_steps() const { return from_light - (kept.light == 0 && from_light > 0 ? 1 : 0); }
};

class Grower {
 public:
  explicit Grower(const IntegratorContext& context)
      : scene_(context.scene),
        query_(context.rays),
        stats_(context.stats),
        measure_(context.scene),
        rays_(new Rays) {}

  /// Makes all of these paths, kSubpaths at most, and measures them; what cannot be made has no brightness.
  /// `key` is that of their random numbers.
  void grow(std::span<Growth> all, std::uint32_t key);

 private:
  /// Sixteen growths, some repeated in lanes that are not active.
  struct Group {
    Growth* growths[kWidth];
    Int index;  // into all_
    Mask active;
  };
  using Places = std::array<int, kWidth>;
  struct Rays {
    Vec3Lanes origin, direction;
    alignas(64) Lanes<float> time, distance;
    alignas(64) Lanes<std::int32_t> index;  // of the growth
    HitState hits;
    int size = 0;
  };

  /// Calls f(group) for those that are alive and wanted.
  template <class Wanted, class F>
  void for_groups(Wanted&& wanted, F&& f);
  template <class F>
  static Places places_of(const Group& group, F&& at) {
    Places places;
    for (std::size_t i = 0; i < kWidth; ++i) places[i] = at(*group.growths[i]);
    return places;
  }
  static Group group_of(std::span<Growth> all, const std::int32_t* indices, int count);
  Sampler numbers_of(const Group& group) const;
  /// The vertices `at`, as paths that arrive there from the eye or from the light see them.
  Vertex vertices_of(const Group& group, const Places& at, bool from_eye) const;
  void leave(const Group& group, const Places& at, bool from_eye, Float u_lobe, Vec2 u);
  BsdfSample follow(const Group& group, const Places& at, const Vertex& v, bool from_eye, Vec2 u) const;
  static Vec3 perturbed(Vec3 direction, Vec2 u);

  void trace_eye();
  void leave_camera(const Group& group);
  void trace_light();
  void start_at_lights(const Group& group);
  void start_at_kept_ends(const Group& group);
  void sample_lights();
  void sample_lights(const Group& group);

  void queue(const Group& group, Vec3 origin, Vec3 direction, Mask lanes);
  void kill(const Group& group, Mask lanes) const;
  void intersect();
  void arrive(int step, bool from_eye);
  static void end_at_lights(const Group& group, int vertex, Mask lit);
  void arrive_at_environment(const Group& group, Vec3 direction, Mask missed) const;
  void arrive_at_lights();
  void measure();
  void look_between();
  void queue_edge(const Group& group);
  Int place_of(Int light, Mask lanes) const;
  std::int32_t picked_as(std::int32_t light) const;

  const SceneTables& scene_;
  const RayQuery& query_;
  RenderStats& stats_;
  const PathMeasure measure_;
  std::uint32_t key_ = 0;
  std::span<Growth> all_;
  std::unique_ptr<Rays> rays_;
};

template <class Wanted, class F>
void Grower::for_groups(Wanted&& wanted, F&& f) {
  std::int32_t indices[kWidth];
  int count = 0;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (all_[i].alive && wanted(all_[i])) indices[count++] = static_cast<std::int32_t>(i);
    if (count == kWidth || (count > 0 && i + 1 == all_.size())) {
      f(group_of(all_, indices, count));
      count = 0;
    }
  }
}

}  // namespace tessera::render::TESSERA_ISA
