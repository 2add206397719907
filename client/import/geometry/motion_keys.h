// Transformations that change while the shutter is open.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "import/geometry/transform.h"

namespace tessera::client {

/// Between two placings turns go the short way at constant speed, and stretches and translations are linear,
/// as the renderer moves things between two keys. The first is given for `t` of 0, the second for 1. Both are
/// decomposable.
Imath::M44d placing_between(const Imath::M44d& from, const Imath::M44d& to, double t);
/// Whether a placing is finite and not singular.
bool is_decomposable(const Imath::M44d& placing);

struct TimedPlacing {
  double time = 0;  // 0 (the shutter opens) to 1
  Imath::M44d place;
};

/// The placings at `times`, which ascend from 0 to 1, and as many in between as it takes to be within 1e-4 of
/// `at`, relative to the size of what is placed and the way that it goes; at most 33 in all, or twice as many
/// as `times`. One alone where nothing moves.
std::vector<TimedPlacing> followed(const std::function<Imath::M44d(double)>& at, std::vector<double> times);

/// The part of a motion with keys at any times that falls between two times, which become 0 and 1. Before the
/// first key and after the last, things stand still. One placing alone where nothing moves.
std::vector<TimedPlacing> during_shutter(const std::vector<TimedPlacing>& keys, double open, double close);

/// The placings of what goes from one place to another.
std::vector<TimedPlacing> placings_of(const MovingTransform& moving);

/// The motion of a shape, an instance or a camera; the first of the placings is for time 0, and written
/// elsewhere. Without any others nothing is written.
template <class Element>
void write_motion(const std::vector<TimedPlacing>& placings, Element& element) {
  for (std::size_t i = 1; i < placings.size(); ++i) {
    v1::MotionKey& key = *element.add_motion();
    key.set_time(placings[i].time);
    write_all_elements(placings[i].place, *key.mutable_place());
  }
}

/// The same, but that what goes straight from time 0 to time 1 has an `end`, such as world_from_object_end.
template <class Element>
void write_motion(const std::vector<TimedPlacing>& placings, v1::Matrix* (Element::*end)(),
                  Element& element) {
  if (placings.size() == 2 && placings[1].time == 1) {
    write_all_elements(placings[1].place, *(element.*end)());
  } else {
    write_motion(placings, element);
  }
}

/// The motion of a light that has points or a direction, those of the first of the placings; what is
/// stretched is not. False, with nothing written, where one of the placings has no axes.
bool write_light_motion(const std::vector<TimedPlacing>& placings, v1::Light& light);

}  // namespace tessera::client
