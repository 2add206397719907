#include "telemetry/metrics.h"

#include <utility>

namespace tessera::telemetry {

ReadFamily::ReadFamily(prometheus::MetricType type, const char* name, const char* help, const char* label)
    : label_(label) {
  family_.name = name;
  family_.help = help;
  family_.type = type;
}

prometheus::MetricFamily ReadFamily::family() && {
  for (const auto& [name, value] : values_) {
    prometheus::ClientMetric& metric = family_.metric.emplace_back();
    if (!name.empty()) metric.label = {{label_, name}};
    (family_.type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  }
  return std::move(family_);
}

}  // namespace tessera::telemetry
