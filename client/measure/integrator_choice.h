// Which integrator samples each meter best. For the sources of sampling.h only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "measure/plan.h"
#include "measure/sampling.h"
#include "tessera/v1/probe.pb.h"

namespace tessera::client {

/// A meter is tried with all integrators where so many times the pixels of a trial follow.
inline constexpr std::uint64_t kTrialsThatPay = 16;

/// Cells of each meter that read all light, those of ratios being none; straight light is read the same by
/// all integrators.
std::vector<std::vector<std::size_t>> cells_of_meters(const MeasurePlan& plan);

/// Readings of cells by an integrator, kFirstPixels pixels each.
struct Trial {
  SampledCells sampled;  // without pixels where it does not read the cell
  double rays_per_pixel = 1;
};

/// Whether an integrator can read the probe at all.
bool can_read(const std::string& integrator, const v1::Probe& probe);

/// Meters that a choice pays for, after kFirstPixels pixels of all cells by the first integrator: those whose
/// figures need so many more pixels for the error that is wanted, or all where samples are told.
std::vector<bool> meters_to_try(const MeasurePlan& plan, double error, const SampledCells& sampled);

/// The number of the trial whose integrator needs the least rays for a meter's figures to be sure: the
/// product of variance and rays, where that of the first is more than half as large again. Trials of whose
/// figures more than a quarter rest on single pixels, or that find less light than another by more than their
/// errors tell, are out.
std::size_t best_trial(const PlannedMeter& meter, const std::vector<Trial>& trials);

}  // namespace tessera::client
