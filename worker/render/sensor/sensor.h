// The interface of the sensors: rays that begin at a place of the raster, and connections of points to it.
// One model a file; all models are stateless.
//
// A sensor's raster is a grid of pixels, but its model decides what they see: those of a meter may be points
// of a wall. Nothing outside of this folder knows a lens or how wide a pixel is.
#pragma once

#include "render/core/model_table.h"
#include "render/core/vec.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render::TESSERA_ISA {

/// Where lenses of jobs without wavelengths have their indices: the Fraunhofer line D.
inline constexpr float kMiddleNm = 589.3f;

/// The numbers that a sample starts with.
struct SensorSample {
  Vec2 raster;  // pixels from the upper left corner
  Vec2 u_lens;  // uniform in the unit square; models without a lens do not look at it
  Float time;   // time from 0 (the shutter opens) to 1; sensors that stand still do not look at it
  Float wavelength = Float(kMiddleNm);  // nanometres; with SensorRecord::disperses only
};
/// The sample in the middle of the lens at this place, when the shutter opens.
TESSERA_INLINE SensorSample middle_sample(Vec2 raster) {
  return {raster, {Float(0.5f), Float(0.5f)}, Float(0.0f)};
}
/// The middle of the raster.
TESSERA_INLINE Vec2 middle_of_raster(const SensorRecord& sensor) {
  return {Float(0.5f * static_cast<float>(sensor.width)), Float(0.5f * static_cast<float>(sensor.height))};
}

struct SensorRay {
  Vec3 origin;     // render space
  Vec3 direction;  // unit length
  Float weight;    // weight of the radiance that arrives along the ray; 0 where it is not valid
  Mask valid;      // the ray leaves the sensor
  // Where lights send their own rays into a lens: density by solid angle that weighs light which the ray
  // meets against samples of lights at its origin. 0: nothing else finds that light.
  Float pdf;
  Vec3 tint;    // factors of red, green and blue besides the weight; not of light of wavelengths
  Vec3 normal;  // of probes: the axis where they read, unit length; else zero
};

/// How a point of the scene is seen through one point of the lens.
struct SensorConnection {
  Vec3 lens;    // point of the lens (of parallel rays: where the one to the point begins), render space
  Vec2 raster;  // pixels from the upper left corner
  // Radiance that leaves the point towards the lens, times this and the cosine there, is the point's part of
  // the integral over surfaces that gives a pixel's value, for a box filter of one pixel.
  Float importance;
  // The density of one sample of the pixel, by area across the ray at the point, given the point of the lens.
  // Importance is this times the weight of the ray.
  Float density;
  Float open_part;  // part of the way from the point to the lens: things beyond are too near to be seen
  Mask valid;       // the point is within what the sensor sees
};

/// A ray of sensor space; the direction has any length.
struct LocalRay {
  Vec3 origin, direction;
  Float weight = Float(1.0f);
  Mask valid = Mask::all();
  Float pdf = Float(0.0f);
  Vec3 tint{Float(1.0f), Float(1.0f), Float(1.0f)};
  Vec3 normal{Float(0.0f), Float(0.0f), Float(0.0f)};
};

/// SensorConnection in sensor space.
struct LocalConnection {
  Vec2 place;
  Vec3 lens;
  Float importance, density;
  Mask valid = Mask::all();
};

class SensorModel {
 public:
  struct Traits {
    bool has_lens = false;  // start() and connect() look at `u_lens`
    bool connects = true;   // points of the scene can be connected to the sensor
    bool has_axis = true;   // clipping distances are counted along z, else along rays
    bool may_fail = false;  // some rays of start() are not valid
    bool weighs = false;    // rays of start() have weights other than 1
    // connect() and start() do not mean the same point of the lens by the same `u_lens`.
    bool turns_lens = false;
  };

  explicit constexpr SensorModel(const Traits& model_traits) : traits(model_traits) {}
  virtual ~SensorModel() = default;

  /// The ray of a place, which is one of the raster times the record's scales plus its offsets.
  virtual LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const = 0;
  /// The same for light of this wavelength, in nanometres; with SensorRecord::disperses only.
  virtual LocalRay start_dispersed(const SensorRecord& sensor, Vec2 place, Vec2 u_lens,
                                   Float wavelength) const;
  /// How a point of sensor space is seen, which with Traits::has_axis has a depth above 0; only with
  /// Traits::connects. Importance and density are by areas of sensor space.
  virtual LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const;
  /// The same for light of this wavelength, in nanometres; with SensorRecord::disperses only.
  virtual LocalConnection connect_dispersed(const SensorRecord& sensor, Vec3 point, Vec2 u_lens,
                                            Float wavelength) const;
  /// LocalConnection::density of the ray that started with `u_lens` and passes through `point` in this
  /// direction, of unit length; only with Traits::turns_lens.
  virtual Float density_along(const SensorRecord& sensor, Vec3 point, Vec3 direction, Vec2 u_lens) const;
  /// The width of what one pixel in the middle of the raster sees, `distance` along its ray, in render space.
  virtual Float pixel_width(const SensorRecord& sensor, Float distance) const = 0;

  const Traits traits;
};

/// The model of a kind.
const SensorModel& sensor_model(SensorKind kind);
/// ModelOf calls this.
void set_model(SensorKind kind, const SensorModel& model);
/// Adds a model that has no kind of its own; records of the kind returned have it. Before anything is
/// rendered: not thread-safe.
SensorKind add_sensor_model(const SensorModel& model);

SensorRay start_ray(const SensorRecord& sensor, const SensorSample& sample);

/// For sensors that connect to points. `wavelength`: as in SensorSample.
SensorConnection connect_to_sensor(const SensorRecord& sensor, Vec3 point, Vec2 u_lens, Float time,
                                   Mask active, Float wavelength = Float(kMiddleNm));

/// SensorConnection::density of rays that started with `u_lens` and meet `point` in this direction, of unit
/// length.
Float density_of_rays(const SensorRecord& sensor, Vec3 point, Vec3 direction, Vec2 u_lens, Float time,
                      Mask active, Float wavelength = Float(kMiddleNm));

/// Whether rays that leave the sensor have weights other than 1.
inline bool weighs_rays(const SensorRecord& sensor) { return sensor_model(sensor.kind).traits.weighs; }
inline bool has_lens(const SensorRecord& sensor) { return sensor_model(sensor.kind).traits.has_lens; }
/// Whether points of the scene can be connected to the sensor.
inline bool connects_to_points(const SensorRecord& sensor) {
  return sensor_model(sensor.kind).traits.connects;
}
/// Whether rays of neighbouring pixels are neighbours in space, too.
inline bool starts_coherent_rays(const SensorRecord& sensor) {
  return !has_lens(sensor) && sensor.steps.empty();
}

/// A normal of render space in sensor space, at `time`: unit length, as seen in the picture.
Vec3 normal_in_sensor(const SensorRecord& sensor, Vec3 normal, Float time);

/// SensorModel::pixel_width.
inline Float pixel_width(const SensorRecord& sensor, Float distance) {
  return sensor_model(sensor.kind).pixel_width(sensor, distance);
}

/// Whether there may be hits that the sensor does not see though its rays meet them.
inline bool misses_some_hits(const SensorRecord& sensor) {
  return sensor.far_clip > 0 || sensor.has_barrel || sensor_model(sensor.kind).traits.may_fail;
}
/// Whether the sensor sees what its rays of unit `direction` meet at distance `t` from their origins.
Mask is_within_reach(const SensorRecord& sensor, Vec3 direction, Float t, Float time);

}  // namespace tessera::render::TESSERA_ISA
