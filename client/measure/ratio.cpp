#include "measure/ratio.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "image/metrics.h"
#include "measure/fault.h"
#include "measure/planner.h"

namespace tessera::client {

Figure ratio_of(const Figure& of, const Figure& over, v1::RatioMeter::Kind kind) {
  const double a = of.value, b = over.value;
  Figure ratio;
  ratio.samples = of.samples + over.samples;
  const bool is_michelson = kind == v1::RatioMeter::MICHELSON;
  const double below = is_michelson ? a + b : b;
  if (below == 0) {
    ratio.value = std::numeric_limits<double>::quiet_NaN();
    return ratio;
  }
  ratio.value = (kind == v1::RatioMeter::QUOTIENT ? a : a - b) / below;
  const double by_a = is_michelson ? 2 * b / (below * below) : 1 / below;
  const double by_b = -(is_michelson ? 2 : 1) * a / (below * below);
  double variance = 0, by_freedom = 0;
  const auto add = [&](const Figure& figure, double slope) {
    const double part = std::pow(slope * figure.standard_error, 2);
    variance += part;
    if (figure.degrees_of_freedom > 0) by_freedom += part * part / figure.degrees_of_freedom;
  };
  add(of, by_a), add(over, by_b);
  ratio.standard_error = std::sqrt(variance);
  // Degrees of freedom of a sum of variances [Satterthwaite 1946].
  if (by_freedom > 0) ratio.degrees_of_freedom = variance * variance / by_freedom;
  return ratio;
}

double relative_error_of_ratio(const Figure& ratio, v1::RatioMeter::Kind kind) {
  if (!(ratio.standard_error > 0)) return 0;
  const double whole = kind == v1::RatioMeter::QUOTIENT ? std::abs(ratio.value)
                       : kind == v1::RatioMeter::WEBER  ? std::abs(ratio.value + 1) + 1
                                                        : 1;
  return student_t_quantile(0.05, std::max(1.0, ratio.degrees_of_freedom)) * ratio.standard_error / whole;
}

namespace {

absl::StatusOr<std::size_t> meter_named(const v1::MeterList& list, const std::string& name) {
  std::size_t found = 0, times = 0;
  for (int i = 0; i < list.meters_size(); ++i) {
    if (list.meters(i).name() != name) continue;
    found = static_cast<std::size_t>(i);
    ++times;
  }
  if (name.empty()) return fault("a ratio is of one meter over another one, by their names");
  if (times == 0) return fault(absl::StrCat("there is no meter '", name, "'"));
  if (times > 1) return fault(absl::StrCat(times, " meters have the name '", name, "'"));
  const v1::Meter& meter = list.meters(static_cast<int>(found));
  if (meter.has_ratio() || meter.has_glare() || meter.has_annual_daylight())
    return fault(absl::StrCat("'", name, "' is a glare, a year or a ratio: no ratios are of these"));
  return found;
}

const char* quantity_of(v1::RatioMeter::Kind kind) {
  if (kind == v1::RatioMeter::WEBER) return "Weber contrast";
  return kind == v1::RatioMeter::MICHELSON ? "Michelson contrast" : "ratio";
}

}  // namespace

absl::Status Planner::add_ratio(const v1::RatioMeter& meter) {
  const auto of = meter_named(list_, meter.of()), over = meter_named(list_, meter.over());
  if (!of.ok()) return of.status();
  if (!over.ok()) return over.status();
  if (*of == *over)
    return fault("a ratio is of two meters: the errors of one and itself are not independent");
  PlannedMeter& planned = plan_.meters.back();
  planned.quantity = quantity_of(meter.kind()), planned.unit = "1";
  planned.ratio = PlannedRatio{meter.kind(), *of, *over};
  return absl::OkStatus();
}

absl::Status Planner::check_ratio(int number) const {
  const auto& ratio = plan_.meters[static_cast<std::size_t>(number)].ratio;
  if (!ratio) return absl::OkStatus();
  const PlannedMeter &of = plan_.meters[ratio->of], &over = plan_.meters[ratio->over];
  if (of.unit != over.unit)
    return fault(absl::StrCat("'", of.name, "' is in ", of.unit, ", '", over.name, "' in ", over.unit));
  // Meters that are read of pictures have one figure here.
  const auto figures = [](const PlannedMeter& meter) { return meter.apart ? 1 : meter.readings.size(); };
  if (figures(over) != 1 && figures(over) != figures(of))
    return fault(absl::StrCat("'", of.name, "' has ", figures(of), " figures, '", over.name, "' ",
                              figures(over), ": it needs one, or as many"));
  return absl::OkStatus();
}

}  // namespace tessera::client
