// What paths get from lights: their light subpaths, and lights that shine on their last vertices.
#include <algorithm>

#include "render/integrator/mlt/path_space/grower.h"
#include "render/integrator/stage_timer.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/light_choice.h"
#include "render/integrator/vertex/light_start.h"
#include "render/light/light_access.h"

namespace tessera::render::TESSERA_ISA {

Int Grower::place_of(Int light, Mask lanes) const {
  Int place(kOnSurface);
  for_each_distinct(kind_of(scene_.lights, light, lanes), lanes, [&](std::int32_t kind, Mask same) {
    const LightTraits& traits = light_model(static_cast<LightKind>(kind)).traits;
    if (traits.at_infinity) {
      place = select(same, Int(kAtInfinity), place);
    } else if (traits.delta) {
      place = select(same, Int(kAtPoint), place);
    }
  });
  return place;
}

/// The light that is picked where this one is met: two triangles may be one.
std::int32_t Grower::picked_as(std::int32_t light) const {
  const std::int32_t other = scene_.lights.lights[static_cast<std::size_t>(light)].same_as;
  return other >= 0 ? other : light;
}

void Grower::trace_light() {
  for (int step = 0;; ++step) {
    rays_->size = 0;
    {
      const StageTimer timer(stats_.times, Stage::kShading);
      if (step == 0) {
        for_groups([](const Growth& g) { return g.kept.light == 0 && g.from_light > 1; },
                   [&](const Group& group) { start_at_lights(group); });
        for_groups([](const Growth& g) { return g.kept.light == 1 && g.from_light > 0; },
                   [&](const Group& group) { start_at_kept_ends(group); });
      }
      for_groups(
          [&](const Growth& g) {
            return g.light_steps() > step && g.leaves_from_light(step) <= g.path->events;
          },
          [&](const Group& group) {
            const Sampler numbers = numbers_of(group);
            const int pair = dimension::kFirstLightEvent + step * dimension::kPairsPerLightEvent;
            leave(group, places_of(group, [&](const Growth& g) { return g.leaves_from_light(step); }), false,
                  numbers.get_2d(pair + dimension::kLobe).x,
                  numbers.get_2d(pair + dimension::kLightBsdfDirection));
          });
    }
    if (rays_->size == 0) return;
    intersect();
    arrive(step, false);
  }
}

void Grower::start_at_lights(const Group& group) {
  const LightStart start = start_at_light(scene_, numbers_of(group), 1.0f, group.index, group.active);
  kill(group, ~start.alive);
  WidePoint end{};
  end.place = place_of(start.light, start.alive);
  end.p = select(end.place == kAtInfinity, -start.ray.direction, start.ray.origin);
  end.ng = start.ray.normal;
  end.error = length(start.ray.offset);
  end.light = start.light;
  store_points(end, start.alive, [&](int i) -> PathPoint& {
    ExplicitPath& path = *group.growths[i]->path;
    return path.points[path.events + 1];
  });
  queue(group, start.path.origin, start.ray.direction, start.alive);
}

/// Paths whose ends on lights stay leave these in directions near those of the paths that they follow; from
/// infinity in the same direction, close by.
void Grower::start_at_kept_ends(const Group& group) {
  const auto points = [&](int back) {
    return load_points([&](int i) -> const PathPoint& {
      const ExplicitPath& path = *group.growths[i]->followed;
      return path.points[path.events + 1 - back];
    });
  };
  const WidePoint end = points(0), first = points(1);
  const Vec2 u = numbers_of(group).get_2d(dimension::kEmissionDirection);
  const Mask at_infinity = end.place == kAtInfinity;
  const Vec3 old = select(at_infinity, -end.p, normalize(first.p - end.p));
  const Vec3 near = perturbed(old, u);
  Vec3 origin = select(end.place == kOnSurface, offset_origin(surface_of(end), near), end.p);
  // The shift has the direction's distribution, on the tangent plane at a distance of the scene's radius.
  const float radius = scene_.lights.scene_radius;
  const Vec3 shift = (near - old * dot(near, old)) * radius;
  origin = select(at_infinity, first.p + shift + end.p * (2 * radius), origin);
  queue(group, origin, select(at_infinity, old, near), group.active);
}

void Grower::sample_lights() {
  rays_->size = 0;
  {
    const StageTimer timer(stats_.times, Stage::kShading);
    for_groups([](const Growth& g) { return g.kept.light == 0 && g.from_light == 1; },
               [&](const Group& group) { sample_lights(group); });
  }
  if (rays_->size == 0) return;
  intersect();
  arrive_at_lights();
}

void Grower::sample_lights(const Group& group) {
  const Vertex v =
      vertices_of(group, places_of(group, [](const Growth& g) { return g.last_from_eye(); }), true);
  const Sampler numbers = numbers_of(group);
  // That of the last event: no path goes on there.
  const int pair = dimension::kFirstLightEvent;
  const LightChoice choice =
      choose_light(scene_.lights, receiver_at(scene_, v), numbers.get_2d(dimension::kEmissionPlace),
                   numbers.get_2d(pair + dimension::kLobe).x, group.active);
  const Mask valid = group.active & choice.pick.picked & choice.sample.valid;
  kill(group, ~valid);
  WidePoint end{};
  end.light = choice.pick.light;
  end.place = place_of(end.light, valid);
  end.p = choice.sample.wi;
  if (const Mask at_point = valid & (end.place == kAtPoint); any(at_point)) {
    const Vec2 middle{Float(0.5f), Float(0.5f)};
    end.p =
        select(at_point, sample_emission(scene_.lights, end.light, middle, middle, at_point).origin, end.p);
  }
  store_points(end, valid, [&](int i) -> PathPoint& {
    ExplicitPath& path = *group.growths[i]->path;
    return path.points[path.events + 1];
  });
  queue(group, offset_origin(v.surface, choice.sample.wi), choice.sample.wi,
        valid & (end.place == kOnSurface));
}

/// Rays to lights with a surface find the points that were sampled, unless something is in the way.
void Grower::arrive_at_lights() {
  const StageTimer timer(stats_.times, Stage::kShading);
  Rays& rays = *rays_;
  for (int first = 0; first < rays.size; first += kWidth) {
    const Group group = group_of(all_, rays.index + first, std::min(kWidth, rays.size - first));
    Vec3 origin, direction;
    load_lanes(rays.origin, first, origin);
    load_lanes(rays.direction, first, direction);
    Hit hit = load_hit(rays.hits, first);
    hit.time = Float::load(rays.time + first);
    const Mask hits = group.active & (hit.shape >= 0);
    kill(group, ~hits);
    if (none(hits)) continue;
    const Surface surface = surface_at(scene_.shapes, hit, origin, direction, hits, scene_.any_tangents);
    const auto end = [&](int i) -> PathPoint& {
      ExplicitPath& path = *group.growths[i]->path;
      return path.points[path.events + 1];
    };
    std::uint32_t found = 0;
    for (std::uint32_t bits = (hits & (surface.light >= 0)).bits(); bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      if (picked_as(surface.light.lane(i)) == picked_as(end(i).light)) found |= 1u << i;
    }
    kill(group, and_not(hits, Mask::from_bits(found)));
    store_points(point_on(surface, Float(0.0f)), Mask::from_bits(found), end);
  }
}

}  // namespace tessera::render::TESSERA_ISA
