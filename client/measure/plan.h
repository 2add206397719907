// From meters to what is sampled: probes, and figures that are sums of what their cells read.
#pragma once

#include <ImathVec.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "measure/cell_triangle.h"
#include "measure/measured.h"
#include "measure/meter_file.h"
#include "measure/reading_channels.h"
#include "tessera/v1/probe.pb.h"

namespace tessera::client {

/// Light that a probe reads: all of it, or what comes straight from lights and is scattered nowhere.
enum class ReadLight : std::uint8_t { kAll, kStraight };

/// A probe, and the numbers of its cells among those of all probes.
struct PlannedProbe {
  v1::Probe probe;  // but for its pixels
  ReadLight light = ReadLight::kAll;
  std::size_t first_cell = 0, cells = 1;
  std::vector<SceneBlob> blobs{};         // meshes that the scene does not have
  std::vector<CellTriangle> triangles{};  // of each cell, where each is a probe of its own
};

/// The reading of a cell in a channel, times a factor.
struct CellTerm {
  std::size_t cell = 0;
  double factor = 1;
  ReadingChannel channel = ReadingChannel::kLuminance;
};

/// A figure: constant + sum of terms, over what another cell reads where `over` names one.
struct PlannedReading {
  std::string label;
  Imath::V3d position{}, normal{};  // as in Reading
  std::vector<CellTerm> terms;
  double constant = 0;
  std::optional<std::size_t> over;
};

/// The figures of a meter over those of another, by their numbers in the plan.
struct PlannedRatio {
  v1::RatioMeter::Kind kind = v1::RatioMeter::QUOTIENT;
  std::size_t of = 0, over = 0;
};

struct PlannedMeter {
  std::string name, quantity, unit;
  std::vector<PlannedReading> readings;
  std::vector<MeasuredPlane> planes;
  std::vector<MeasuredMesh> meshes;
  std::vector<std::string> warnings;
  std::optional<PlannedRatio> ratio;  // there are no readings here then
  // Number of the meter in its file, of those that are read of pictures or of many skies, and have no
  // readings here.
  std::optional<int> apart;
  double factor = 1;  // of those: from a radiance whose luminance is 1 to the meter's unit
};

struct MeasurePlan {
  std::vector<PlannedProbe> probes;
  std::vector<PlannedMeter> meters;
  std::size_t cells = 0;  // of all probes
};

struct Ball {
  Imath::V3d middle{};  // world space
  double radius = 1;
};

/// Facts about the scene that the plan depends on.
struct MeasuredScene {
  const ImportedScene& imported;
  double metres = 0;                                // length of the scene's unit; 0: not said
  double cd_per_m2 = 683;                           // luminance of a radiance of 1
  bool is_spectral = false;                         // light is of wavelengths: there are all channels
  v1::Scene picture;                                // the scene's own camera and film
  bool is_night = false;                            // nobody wonders where there is no light
  std::function<absl::StatusOr<Ball>()> ball = {};  // around all that the scene holds
  // The luminance flux of the lights of a part of the scene, in its radiance and unit of length squared.
  std::function<absl::StatusOr<double>(const v1::Scene& lights)> emitted_flux = {};
};

/// The scene's own unit of length and luminance, or else those of the list. InvalidArgument where the list's
/// unit is none, or is another than the scene's.
absl::StatusOr<MeasuredScene> measured_scene(const ImportedScene& imported, const MeterFile& file,
                                             bool is_spectral, std::function<absl::StatusOr<Ball>()> ball);

/// InvalidArgument with all meters that make no sense, and why; ResourceExhausted where there are more cells
/// than can be kept.
absl::StatusOr<MeasurePlan> plan_of(const MeterFile& file, const MeasuredScene& scene);

}  // namespace tessera::client
