// A sensor as the kernels read it: where it stands, how its raster sees the scene, and how it responds to
// light.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "render/core/affine_data.h"
#include "render/film/raster_edges.h"
#include "render/sensor/response.h"

namespace tessera::render {

struct HoleTable;        // hole_table.h
struct LensTable;        // lens_table.h
struct ShutterTable;     // shutter_table.h
struct DistortionTable;  // distortion_table.h
struct PanoramaTable;    // panorama_table.h
struct ProbeTable;       // probe_table.h
struct ProbeRecord;

/// Each kind has a model, at the end of whose file it is named; kinds from kCount on are those that
/// add_sensor_model() gives.
enum class SensorKind : std::int32_t {
  kPinhole,
  kThinLens,
  kOrthographic,
  kOrthographicLens,
  kEquirectangular,
  kOctahedral,
  kCylindrical,
  kFisheyeEquidistant,
  kFisheyeEquisolid,
  kFisheyeStereographic,
  kFisheyeOrthographic,
  kLensSystem,
  kHole,
  kTiltedLens,
  kEqualAreaCylindrical,
  kCubeMap,
  kPanorama,
  kPanoramaLens,
  kProbes,
  kConnectingProbes,  // the same, to which points of the scene are connected
  kCount
};

/// The kind of sensors that are `kind` but for a lens.
constexpr SensorKind with_lens(SensorKind kind) {
  switch (kind) {
    case SensorKind::kOrthographic:
      return SensorKind::kOrthographicLens;
    case SensorKind::kPanorama:
      return SensorKind::kPanoramaLens;
    default:
      return SensorKind::kThinLens;
  }
}

/// Meaning of the places of a raster.
enum class RasterShape : std::int32_t {
  kPlane,     // points of the plane z = 1 of sensor space, seen from about its origin
  kParallel,  // points of the plane z = 0, from which rays leave along z
  kSphere,    // points of a map of the sphere
  kOther
};
struct RasterTraits {
  RasterShape shape = RasterShape::kOther;
  double angle_x = 0, angle_y = 0;  // kSphere: radians that a place's unit spans, in the middle
  RasterEdges edges = RasterEdges::kOpen;
};

/// kOther for kinds that were added.
inline RasterTraits raster_of(SensorKind kind) {
  using std::numbers::pi;
  switch (kind) {
    case SensorKind::kPinhole:
    case SensorKind::kThinLens:
    case SensorKind::kTiltedLens:
    case SensorKind::kLensSystem:  // as its principal rays see it, but for distortion
    case SensorKind::kHole:        // as rays through its middle see it
      return {RasterShape::kPlane};
    case SensorKind::kOrthographic:
    case SensorKind::kOrthographicLens:
      return {RasterShape::kParallel};
    case SensorKind::kEquirectangular:
      return {RasterShape::kSphere, 2 * pi, pi, RasterEdges::kOverPole};
    case SensorKind::kOctahedral:  // the square is mapped evenly to 4 pi steradians
      return {RasterShape::kSphere, 2 * std::sqrt(pi), 2 * std::sqrt(pi), RasterEdges::kMirrored};
    case SensorKind::kEqualAreaCylindrical:
      return {RasterShape::kSphere, 2 * pi, 2, RasterEdges::kOverPole};
    case SensorKind::kCubeMap:  // a face spans two units
      return {RasterShape::kSphere, 1, 1, RasterEdges::kMirrored};
    case SensorKind::kPanorama:
    case SensorKind::kPanoramaLens:  // as rays through the middle of the lens see it
    case SensorKind::kCylindrical:
    case SensorKind::kFisheyeEquidistant:
    case SensorKind::kFisheyeEquisolid:
    case SensorKind::kFisheyeStereographic:
    case SensorKind::kFisheyeOrthographic:
      return {RasterShape::kSphere, 1, 1};
    default:
      return {};
  }
}

struct SensorRecord {
  SensorKind kind = SensorKind::kPinhole;
  // Sensor space (x right, y up, z forward) to render space. Without translation: render space is centred on
  // the sensor.
  Affine render_from_sensor;
  // Poses of a sensor that moves, at evenly spaced times (core/motion.h), with the way that it went since
  // the shutter opened.
  std::vector<Affine> steps;
  std::shared_ptr<const ShutterTable> shutter;  // null: all of the raster is exposed evenly from 0 to 1
  // A place of the raster (pixels from its upper left corner) times these plus offsets: the model's own
  // place (RasterShape).
  float scale_x = 1, scale_y = 1, offset_x = 0, offset_y = 0;
  float lens_radius = 0;
  float focal_distance = 1;
  float circle_angle = std::numbers::pi_v<float>;  // fisheyes see no farther from the axis, radians
  std::shared_ptr<const LensTable> lens;           // kLensSystem; thin lenses that are not round, or tilted
  std::shared_ptr<const HoleTable> hole;           // kHole
  std::shared_ptr<const DistortionTable> distortion;  // of the raster's places, if any
  std::shared_ptr<const PanoramaTable> panorama;      // kCubeMap, kPanorama
  std::shared_ptr<const ProbeTable> probes;           // kProbes, kConnectingProbes: no picture
  bool has_barrel = false;                            // of the thin lens: some of its rays are blocked
  // Jobs of wavelengths only: where a ray goes depends on its wavelength.
  bool disperses = false;
  // Depths (along z; distances for sensors that see all around) between which things are seen; far_clip 0: no
  // limit.
  float near_clip = 0, far_clip = 0;
  std::int32_t width = 1, height = 1;  // size of the raster, pixels
  std::int32_t medium = -1;            // medium that the sensor stands in
  Response response;
};

/// Tells what is seen beyond the edge of the raster.
inline RasterEdges edges_of(const SensorRecord& sensor) {
  constexpr float kFullTurn = 6.2831f;
  const bool is_panorama = sensor.kind == SensorKind::kPanorama || sensor.kind == SensorKind::kPanoramaLens;
  if ((sensor.kind == SensorKind::kCylindrical || is_panorama) &&
      sensor.scale_x * static_cast<float>(sensor.width) >= kFullTurn) {
    const bool has_poles =
        is_panorama && -2 * sensor.scale_y * static_cast<float>(sensor.height) >= kFullTurn;
    return has_poles ? RasterEdges::kOverPole : RasterEdges::kRound;
  }
  return raster_of(sensor.kind).edges;
}

}  // namespace tessera::render
