#include "render/integrator/mlt/path_space/grower.h"

#include <algorithm>
#include <cmath>

#include "render/camera/camera.h"
#include "render/integrator/mlt/path_space/delta_lobe.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {

void Grower::grow(std::span<Growth> all, std::uint32_t key) {
  all_ = all;
  key_ = key;
  trace_eye();
  trace_light();
  sample_lights();
  measure();
  look_between();
  for (Growth& growth : all) {
    if (!growth.alive) growth.path->brightness = 0;
  }
}

Grower::Group Grower::group_of(std::span<Growth> all, const std::int32_t* indices, int count) {
  Group group;
  group.active = Mask::first(count);
  group.index = ints_of([&](int i) { return indices[std::min(i, count - 1)]; });
  for (int i = 0; i < kWidth; ++i)
    group.growths[i] = &all[static_cast<std::size_t>(indices[std::min(i, count - 1)])];
  return group;
}

Sampler Grower::numbers_of(const Group& group) const {
  const Int numbers = ints_of([&](int i) { return static_cast<std::int32_t>(group.growths[i]->number); });
  return {SamplerKind::kIndependent, UInt(key_), bit_cast<std::uint32_t>(numbers)};
}

void Grower::kill(const Group& group, Mask lanes) const {
  for (std::uint32_t bits = (lanes & group.active).bits(); bits != 0; bits &= bits - 1)
    group.growths[__builtin_ctz(bits)]->alive = false;
}

void Grower::queue(const Group& group, Vec3 origin, Vec3 direction, Mask lanes) {
  Rays& rays = *rays_;
  append_lanes(origin, lanes, rays.origin, rays.size);
  append_lanes(direction, lanes, rays.direction, rays.size);
  append_lanes(floats_of([&](int i) { return group.growths[i]->path->time; }), lanes, rays.time, rays.size);
  append_lanes(group.index, lanes, rays.index, rays.size);
  rays.size += count(lanes);
}

void Grower::intersect() {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  Rays& rays = *rays_;
  stats_.bounce_rays += static_cast<std::uint64_t>(rays.size);
  query_.nearest(arrays_of(rays.origin, rays.direction, scene_.any_motion ? rays.time : nullptr), rays.size,
                 false, rays.hits.arrays());
}

void Grower::trace_eye() {
  for (int step = 0;; ++step) {
    rays_->size = 0;
    {
      const StageTimer timer(stats_.times, Stage::kShading);
      const auto goes_on = [&](const Growth& growth) { return growth.from_eye > step; };
      if (step == 0) {
        for_groups([&](const Growth& g) { return goes_on(g) && g.kept.eye == 0; },
                   [&](const Group& group) { leave_camera(group); });
      }
      for_groups([&](const Growth& g) { return goes_on(g) && g.leaves_from_eye(step) > 0; },
                 [&](const Group& group) {
                   const Sampler numbers = numbers_of(group);
                   const int pair = dimension::kFirstEvent + step * dimension::kPairsPerEvent;
                   leave(group, places_of(group, [&](const Growth& g) { return g.leaves_from_eye(step); }),
                         true, numbers.get_2d(pair + dimension::kChoice).y,
                         numbers.get_2d(pair + dimension::kBsdfDirection));
                 });
    }
    if (rays_->size == 0) return;
    intersect();
    arrive(step, true);
  }
}

Vertex Grower::vertices_of(const Group& group, const Places& at, bool from_eye) const {
  const auto path = [&](int i) -> const ExplicitPath& { return *group.growths[i]->path; };
  const WidePoint here =
      load_points([&](int i) -> const PathPoint& { return path(i).points[at[static_cast<std::size_t>(i)]]; });
  Vertex v;
  v.surface = surface_of(here);
  v.time = floats_of([&](int i) { return path(i).time; });
  const auto before = [&](int i) -> const PathPoint& {
    return path(i).points[at[static_cast<std::size_t>(i)] + (from_eye ? -1 : 1)];
  };
  const Vec3 there{floats_of([&](int i) { return before(i).p.x; }),
                   floats_of([&](int i) { return before(i).p.y; }),
                   floats_of([&](int i) { return before(i).p.z; })};
  v.wo = there - here.p;
  if (from_eye) {
    const Mask first = ints_of([&](int i) { return at[static_cast<std::size_t>(i)]; }) == 1;
    if (any(first)) {
      const Vec2 lens{floats_of([&](int i) { return path(i).lens_x; }),
                      floats_of([&](int i) { return path(i).lens_y; })};
      v.wo = select(first, connect_to_camera(scene_.camera, here.p, lens, v.time, first).lens - here.p, v.wo);
    }
    v.wo = normalize(v.wo);
  } else {
    const Mask at_infinity = ints_of([&](int i) { return before(i).place; }) == kAtInfinity;
    v.wo = select(at_infinity, there, normalize(v.wo));
  }
  interact(scene_, v.surface, v.wo, here.mix, group.active, v.at);
  return v;
}

void Grower::leave_camera(const Group& group) {
  const auto of = [&](auto&& f) { return floats_of([&](int i) { return f(*group.growths[i]); }); };
  const CameraRay ray = sample_camera_ray(
      scene_.camera,
      {of([](const Growth& g) { return g.film_x; }), of([](const Growth& g) { return g.film_y; })},
      {of([](const Growth& g) { return g.path->lens_x; }),
       of([](const Growth& g) { return g.path->lens_y; })},
      of([](const Growth& g) { return g.path->time; }));
  queue(group, ray.origin, ray.direction, group.active);
}

Vec3 Grower::perturbed(Vec3 direction, Vec2 u) {
  const Float angle = exp(u.x * std::log(kLeastAngle / kLargestAngle)) * kLargestAngle;
  const Float turn = u.y * (2 * kPi), radius = sin(angle);
  return Frame::from_normal(direction).to_world({radius * cos(turn), radius * sin(turn), cos(angle)});
}

/// The direction of the path that is followed, or near it, as a sample.
BsdfSample Grower::follow(const Group& group, const Places& at, const Vertex& v, bool from_eye,
                          Vec2 u) const {
  const auto old = [&](int i) -> const ExplicitPath& { return *group.growths[i]->followed; };
  const auto here = [&](int i) { return at[static_cast<std::size_t>(i)]; };
  const auto is = [&](auto&& f) { return ints_of([&](int i) { return f(i) ? 1 : 0; }) != 0; };
  const auto p = [&](int to) {
    const auto point = [&](int i) -> const PathPoint& { return old(i).points[here(i) + to]; };
    return Vec3{floats_of([&](int i) { return point(i).p.x; }),
                floats_of([&](int i) { return point(i).p.y; }),
                floats_of([&](int i) { return point(i).p.z; })};
  };
  const int ahead = from_eye ? 1 : -1;
  const Mask to_infinity =
      is([&](int i) { return from_eye && here(i) == old(i).events && old(i).end().place == kAtInfinity; });
  const Vec3 next = p(ahead);
  BsdfSample sample;
  sample.wi = perturbed(select(to_infinity, next, normalize(next - p(0))), u);
  sample.specular = group.active & is([&](int i) { return old(i).is_specular(here(i)); });
  sample.valid = and_not(group.active, sample.specular);
  if (any(sample.specular)) {
    const DeltaLobe lobe =
        find_delta_lobe(v.at, v.wo, from_eye ? Transport::kRadiance : Transport::kImportance, sample.specular,
                        goes_through(is([&](int i) { return old(i).transmits[here(i)]; })));
    sample.wi = select(sample.specular, lobe.wi, sample.wi);
    sample.valid |= lobe.found;
  }
  return sample;
}

void Grower::leave(const Group& group, const Places& at, bool from_eye, Float u_lobe, Vec2 u) {
  const Vertex v = vertices_of(group, at, from_eye);
  // A batch follows paths, or it does not.
  const BsdfSample sample = group.growths[0]->followed != nullptr
                                ? follow(group, at, v, from_eye, u)
                                : sample_bsdf(v.at, v.wo, u_lobe, u, group.active,
                                              from_eye ? Transport::kRadiance : Transport::kImportance);
  const Mask alive = group.active & sample.valid;
  kill(group, ~alive);
  for (std::uint32_t bits = alive.bits(); bits != 0; bits &= bits - 1) {
    const int i = __builtin_ctz(bits);
    group.growths[i]->path->points[at[static_cast<std::size_t>(i)]].specular =
        static_cast<std::int32_t>(sample.specular.bits() >> i & 1);
  }
  queue(group, offset_origin(v.surface, sample.wi), sample.wi, alive);
}

void Grower::arrive(int step, bool from_eye) {
  const StageTimer timer(stats_.times, Stage::kShading);
  Rays& rays = *rays_;
  for (int first = 0; first < rays.size; first += kWidth) {
    const Group group = group_of(all_, rays.index + first, std::min(kWidth, rays.size - first));
    Vec3 origin, direction;
    load_lanes(rays.origin, first, origin);
    load_lanes(rays.direction, first, direction);
    Hit hit = load_hit(rays.hits, first);
    hit.time = Float::load(rays.time + first);
    const auto arrives_at = [&](const Growth& growth) {
      return from_eye ? growth.leaves_from_eye(step) + 1 : growth.leaves_from_light(step) - 1;
    };
    Mask hits = group.active & (hit.shape >= 0);
    const Surface surface = surface_at(scene_.shapes, hit, origin, direction, hits, scene_.any_tangents);
    const Mask dark = hits & (surface.light < 0), missed = and_not(group.active, hits);
    if (from_eye) end_at_lights(group, step + 1, and_not(group.active, dark));
    const Mask at_end = ints_of([&](int i) {
                          const Growth& growth = *group.growths[i];
                          return arrives_at(growth) > growth.path->events ? 1 : 0;
                        }) != 0;
    if (any(missed & at_end)) arrive_at_environment(group, direction, missed & at_end);
    kill(group, and_not(missed, at_end) | (dark & at_end));
    hits = and_not(hits, dark & at_end);
    if (none(hits)) continue;
    const Sampler numbers = numbers_of(group);
    const Float mix =
        from_eye
            ? numbers.get_2d(dimension::kFirstEvent + step * dimension::kPairsPerEvent + dimension::kRoulette)
                  .y
            : numbers
                  .get_2d(dimension::kFirstLightEvent + step * dimension::kPairsPerLightEvent +
                          dimension::kLightRoulette)
                  .y;
    store_points(point_on(surface, mix), hits, [&](int i) -> PathPoint& {
      return group.growths[i]->path->points[arrives_at(*group.growths[i])];
    });
    for (std::uint32_t bits = hits.bits(); bits != 0; bits &= bits - 1) {
      const Growth& growth = *group.growths[__builtin_ctz(bits)];
      const int vertex = arrives_at(growth);
      if (growth.followed != nullptr) growth.path->points[vertex].mix = growth.followed->points[vertex].mix;
    }
  }
}

/// Paths that go on until they meet a light have met one, at this vertex.
void Grower::end_at_lights(const Group& group, int vertex, Mask lit) {
  if (vertex == 1) return;  // without an event: no path of chains
  for (std::uint32_t bits = lit.bits(); bits != 0; bits &= bits - 1) {
    Growth& growth = *group.growths[__builtin_ctz(bits)];
    if (!growth.until_light) continue;
    growth.path->events = vertex - 1;
    growth.from_eye = vertex;
  }
}

/// Ends the paths that leave the scene, at the light that is all around it.
void Grower::arrive_at_environment(const Group& group, Vec3 direction, Mask missed) const {
  if (scene_.lights.infinite_lights.empty()) {
    kill(group, missed);
    return;
  }
  WidePoint end{};
  end.p = direction;
  end.light = Int(scene_.lights.infinite_lights[0]);
  end.place = Int(kAtInfinity);
  store_points(end, missed, [&](int i) -> PathPoint& {
    ExplicitPath& path = *group.growths[i]->path;
    return path.points[path.events + 1];
  });
}

void Grower::measure() {
  const StageTimer timer(stats_.times, Stage::kShading);
  for_groups([](const Growth&) { return true; },
             [&](const Group& group) {
               ExplicitPath* paths[kWidth];
               for (int i = 0; i < kWidth; ++i) paths[i] = group.growths[i]->path;
               for (int i = 0; i < kWidth; ++i) {
                 const Growth& growth = *group.growths[i];
                 if (growth.ends_by_chance()) continue;
                 // The edge that is put between two vertices is no delta lobe's.
                 growth.path->points[growth.last_from_eye()].specular = 0;
                 growth.path->points[growth.last_from_eye() + 1].specular = 0;
               }
               measure_.measure(paths, group.active);
             });
}

/// Paths whose two parts do not see each other carry no light.
void Grower::look_between() {
  const StageTimer timer(stats_.times, Stage::kShadow);
  Rays& rays = *rays_;
  rays.size = 0;
  for_groups(
      [](const Growth& growth) {
        if (growth.path->brightness == 0 || growth.ends_by_chance()) return false;
        // A ray has looked for the light itself.
        return growth.kept.light > 0 || growth.from_light > 1 || growth.path->end().place != kOnSurface;
      },
      [&](const Group& group) { queue_edge(group); });
  query_.occluded(arrays_of(rays.origin, rays.direction, scene_.any_motion ? rays.time : nullptr), rays.size,
                  rays.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(rays.size);
  for (int i = 0; i < rays.size; ++i) {
    if (rays.distance[i] < 0) all_[static_cast<std::size_t>(rays.index[i])].alive = false;
  }
}

void Grower::queue_edge(const Group& group) {
  const auto path = [&](int i) -> const ExplicitPath& { return *group.growths[i]->path; };
  const auto last = [&](int i) { return group.growths[i]->last_from_eye(); };
  // From the vertex on the eye's side; where that is the lens, from the other.
  const Mask to_lens = ints_of([&](int i) { return last(i); }) == 0;
  const Surface here = surface_of(
      load_points([&](int i) -> const PathPoint& { return path(i).points[std::max(last(i), 1)]; }));
  const WidePoint there = load_points([&](int i) -> const PathPoint& { return path(i).points[last(i) + 1]; });
  const Float time = floats_of([&](int i) { return path(i).time; });
  Vec3 target = there.p;
  Float part(1.0f);
  if (any(to_lens)) {
    const CameraConnection eye = connect_to_camera(
        scene_.camera, here.p,
        {floats_of([&](int i) { return path(i).lens_x; }), floats_of([&](int i) { return path(i).lens_y; })},
        time, to_lens);
    target = select(to_lens, eye.lens, target);
    // Things before the near plane are not seen, and block nothing.
    const float near_clip = scene_.camera.near_clip;
    if (near_clip > 0) part = select(to_lens, 1.0f - near_clip / max(eye.depth, 1e-30f), part);
  }
  const Mask at_infinity = and_not(there.place == kAtInfinity, to_lens),
             on_surface = and_not(there.place == kOnSurface, to_lens);
  const Vec3 w = select(at_infinity, there.p, normalize(target - here.p));
  target = select(on_surface, offset_origin(surface_of(there), -w), target);
  const Vec3 origin = offset_origin(here, w), rest = target - origin;
  const Float distance = length(rest) * part;
  const Vec3 direction = select(at_infinity, w, rest * (1.0f / max(length(rest), 1e-30f)));
  append_lanes(select(at_infinity, Float(kInfiniteDistance), distance), group.active, rays_->distance,
               rays_->size);
  queue(group, origin, direction, group.active);
}

}  // namespace tessera::render::TESSERA_ISA
