// Report of what a benchmark found, for people, for machines, and as a picture.
#pragma once

#include <string>
#include <vector>

#include "bench/machine.h"
#include "bench/measure.h"
#include "plot/log_log_plot.h"

namespace tessera::client {

/// Tables with their units, several lines: the runs of every variant, and how the variants compare.
std::string to_text(const BenchSceneResult& scene);

/// All figures; the fields are in docs/command-line.md. Numbers that are not known are null.
std::string to_json(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan,
                    const Machine& machine);

/// relMSE over CPU time, one line a scene and variant, and the square of its bias where that is seen.
LogLogPlot to_plot(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan);

/// The variance of an image and the square of its bias over CPU time, two lines a scene and variant.
LogLogPlot to_bias_plot(const std::vector<BenchSceneResult>& scenes, const BenchPlan& plan);

}  // namespace tessera::client
