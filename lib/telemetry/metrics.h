// Metrics that Tessera's programs have in common.
#pragma once

#include <prometheus/metric_family.h>

#include <map>
#include <string>
#include <vector>

namespace tessera::telemetry {

/// Upper ends of the buckets of histograms over what units took, seconds.
inline const std::vector<double> kUnitSecondsBuckets{0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000};

/// A family whose values are read anew whenever somebody looks: `family[value]` is that of the series
/// {label="value"}. Without a label, there is one series, family[""].
class ReadFamily {
 public:
  ReadFamily(prometheus::MetricType type, const char* name, const char* help, const char* label = "");
  double& operator[](const std::string& value) { return values_[value]; }
  prometheus::MetricFamily family() &&;

 private:
  const char* label_;
  prometheus::MetricFamily family_;
  std::map<std::string, double> values_;
};

}  // namespace tessera::telemetry
