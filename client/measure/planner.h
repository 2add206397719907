// Makes the probes and readings of meters. For the sources of plan.h only.
#pragma once

#include <ImathVec.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "measure/fault.h"
#include "measure/light_unit.h"
#include "measure/plan.h"
#include "measure/receivers.h"

namespace tessera::client {

class Planner {
 public:
  Planner(const MeterFile& file, const MeasuredScene& scene)
      : list_(file.list),
        scene_(scene),
        up_(list_.up() == v1::MeterList::Y ? Imath::V3d(0, 1, 0) : Imath::V3d(0, 0, 1)) {}

  /// Adds the meter of this number in the file. InvalidArgument says what is wrong with it.
  absl::Status add(int number);
  /// Checks a ratio once all meters are added without fault. InvalidArgument where its meters do not go
  /// together.
  absl::Status check_ratio(int number) const;
  MeasurePlan take() { return std::move(plan_); }
  std::size_t cells() const { return plan_.cells; }

 private:
  absl::Status add_radiance(const v1::RadianceMeter& meter);
  absl::Status add_irradiance(const v1::IrradianceMeter& meter);
  absl::Status add_light_vector(const v1::LightVectorMeter& meter);
  absl::Status add_exitance(const v1::ExitanceMeter& meter);
  absl::Status add_intensity(const v1::IntensityMeter& meter);
  absl::Status add_flux(const v1::FluxMeter& meter);
  absl::Status add_flux_of_light(const v1::FluxMeter& meter);
  /// The luminance flux of a light without a surface, over the square of the scene's unit.
  absl::StatusOr<double> flux_of_lamp(const v1::Light& light, double square_metres) const;
  absl::Status add_daylight_factor(const v1::DaylightFactorMeter& meter);
  absl::Status add_energy_balance();
  absl::Status add_ratio(const v1::RatioMeter& meter);
  absl::Status set_apart();

  /// Names what the meter measures in the unit that it asks for, and keeps the factor from radiance.
  absl::Status begin(const v1::Meter& meter, LightQuantity quantity);
  /// Adds a probe; returns the number of its first cell.
  std::size_t add_probe(const ReceiverPlace& place, v1::Probe::Kind kind, ReadLight light = ReadLight::kAll);
  /// Adds a reading for each cell of a place.
  void add_cells(const ReceiverPlace& place, std::size_t first_cell, double factor,
                 std::optional<std::size_t> over = std::nullopt);
  PlannedReading& add_reading(std::string label);
  template <class Receivers, class F>
  absl::Status for_each_place(const Receivers& receivers, F&& f);
  /// Adds to a reading the flux that arrives at a surface, or leaves it.
  void add_flux_of(const ReceiverPlace& place, v1::Probe::Kind kind, double sign, PlannedReading& reading,
                   ReadLight light = ReadLight::kAll);
  /// Square metres of the scene's unit squared; a warning where its length is not said.
  double square_metres();
  absl::StatusOr<ReceiverPlace> hull(bool inward);

  const v1::MeterList& list_;
  const MeasuredScene& scene_;
  const Imath::V3d up_;
  MeasurePlan plan_;
  int number_ = 0;  // of the meter that is added
  // From what cells read to the meter's unit.
  double factor_ = 1;
  ReadingChannel channel_ = ReadingChannel::kLuminance;
};

template <class Receivers, class F>
absl::Status Planner::for_each_place(const Receivers& receivers, F&& f) {
  if (receivers.empty()) return fault("it has no receivers");
  for (const v1::Receiver& receiver : receivers) {
    auto place = place_of(receiver, scene_.imported, up_);
    if (!place.ok()) return place.status();
    if (absl::Status s = f(*place); !s.ok()) return s;
  }
  return absl::OkStatus();
}

}  // namespace tessera::client
