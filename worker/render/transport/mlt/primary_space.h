// Primary sample space: the random numbers that paths are made of, as coordinates that can be changed little
// by little [Kelemen et al. 2002], for a batch of paths.
//
// A path of n scattering events is made in one of some n + 2 ways, (s, t) of bidirectional path tracing.
// Which one is a coordinate, too: the multiplexed space of [Hachisuka, Kaplanyan & Dachsbacher 2014].
#pragma once

#include <cstdint>
#include <vector>

#include "render/sampling/sampler.h"
#include "render/sensor/respond.h"
#include "render/transport/bdpt/frontier.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/lanes.h"
#include "render/transport/vertex/sample_keys.h"

namespace tessera::render::TESSERA_ISA {

// Places of pairs of coordinates. Those of the eye's and of the light's subpath are apart, so that a way that
// has a vertex less on one side keeps all the others.
inline constexpr int kFirstEmission = dimension::kFirstEvent;
inline constexpr int kFirstPlaceOfEvents = kFirstEmission + 3;
// Places of an event: four of the eye's, its flight and its opacity, four of the light's, its flight.
inline constexpr int kFlightPlace = 4, kOpacityPlace = 5, kFirstLightPlace = 6, kLightFlightPlace = 10;
inline constexpr int kPlacesPerEvent = 11;

/// Events from this number on have numbers that large steps alone change: memory is bounded, however deep
/// paths are.
inline constexpr int kMutatedEvents = 32;

/// Points of a subpath that have coordinates: those where it is scattered, and one where it ends.
inline constexpr int points_of(int events) { return events < kMutatedEvents ? events + 1 : kMutatedEvents; }
/// Places that paths of so many events have.
inline constexpr int places_of(int events) {
  return kFirstPlaceOfEvents + kPlacesPerEvent * points_of(events);
}

/// The place of a pair of dimensions; -1 where it is none of the coordinates.
inline constexpr int place_of(int pair) {
  using namespace dimension;
  const auto of_event = [](int event, int within) {
    return event < kMutatedEvents ? kFirstPlaceOfEvents + event * kPlacesPerEvent + within : -1;
  };
  if (pair < kFirstEvent) return pair;
  if (pair < kFlight) {
    const int number = pair - kFirstEvent;
    return of_event(number / kPairsPerEvent, number % kPairsPerEvent);
  }
  if (pair < kOpacity) return of_event(pair - kFlight, kFlightPlace);
  if (pair < kLightPath) return of_event(pair - kOpacity, kOpacityPlace);
  if (pair < kFirstLightEvent) return kFirstEmission + pair - kEmitter;
  if (pair < kLightFlight) {
    const int number = pair - kFirstLightEvent;
    return of_event(number / kPairsPerLightEvent, kFirstLightPlace + number % kPairsPerLightEvent);
  }
  return of_event(pair - kLightFlight, kLightFlightPlace);
}

/// Paths that are to be made, and what became of them.
struct PathBatch {
  struct alignas(64) Pair {
    float x[kSubpaths], y[kSubpaths];
  };

  int count = 0;
  // Indexed by slot: scattering events, and vertices from the light and from the eye, events + 2 together.
  alignas(64) std::int32_t events[kSubpaths], from_light[kSubpaths], from_eye[kSubpaths];
  std::vector<Pair> coordinates_by_place;
  SampleKeys keys;  // keys of all other random numbers
  // Where the light lands on the film, in pixels; its value there, times the number of ways that paths of so
  // many events can be made in, weighed against them; as a splat of the whole film's only path would have it.
  alignas(64) float film_x[kSubpaths], film_y[kSubpaths];
  SpectrumLanes light;

  Int ways_from_light(int packet) const { return Int::load(from_light + packet * kWidth); }
  Int ways_from_eye(int packet) const { return Int::load(from_eye + packet * kWidth); }
};

/// Numbers of 16 paths of a batch by their dimensions, as Sampler gives them.
class PrimaryNumbers {
 public:
  PrimaryNumbers(const PathBatch& batch, int packet)
      : batch_(batch),
        first_(packet * kWidth),
        others_(SamplerKind::kIndependent, UInt::load(batch.keys.pixel_hash + first_),
                UInt::load(batch.keys.reversed_sample + first_)) {}

  TESSERA_INLINE Vec2 get_2d(int pair) const {
    const int place = place_of(pair);
    if (place < 0) return others_.get_2d(pair);
    const PathBatch::Pair& numbers = batch_.coordinates_by_place[static_cast<std::size_t>(place)];
    return {Float::load(numbers.x + first_), Float::load(numbers.y + first_)};
  }

 private:
  const PathBatch& batch_;
  const int first_;
  const Sampler others_;
};

/// Makes light of numbers: the function that chains are distributed as.
class PathSpace {
 public:
  virtual ~PathSpace() = default;
  /// Fills film_x, film_y and light of the batch's paths.
  virtual void make(PathBatch& batch) = 0;
  /// The wavelengths of 16 of the batch's paths.
  virtual Wavelengths wavelengths(const PathBatch& batch, int packet) const = 0;
  /// How the film sees them.
  virtual const Response& response() const = 0;
  /// Ways to make paths of so many events: as many vertices from the light, from 0 on.
  virtual int ways(int events) const = 0;
  /// Most events.
  virtual int max_events() const = 0;
  /// Whether any path asks for this place of an event, from 0 to kPlacesPerEvent - 1.
  virtual bool asks_for(int place_of_event) const = 0;
};

}  // namespace tessera::render::TESSERA_ISA
