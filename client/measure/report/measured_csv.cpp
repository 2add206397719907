#include <cmath>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "measure/report/intervals.h"
#include "measure/report/measured_table.h"

namespace tessera::client {
namespace {

constexpr const char* kLineEnd = "\r\n";

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char letter : text) quoted += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return quoted + "\"";
}

void append_record(const std::vector<std::string>& fields, std::string& csv) {
  for (std::size_t i = 0; i < fields.size(); ++i)
    absl::StrAppend(&csv, i > 0 ? "," : "", csv_field(fields[i]));
  csv += kLineEnd;
}

void append_vector(const Imath::V3d& vector, bool there, std::vector<std::string>& fields) {
  for (const double part : {vector.x, vector.y, vector.z})
    fields.push_back(there ? shortest_text(part) : std::string());
}

const std::vector<std::string> kCsvColumns = {
    "meter", "quantity", "unit",  "label",          "x",     "y",      "z",       "nx",
    "ny",    "nz",       "value", "standard_error", "low95", "high95", "samples", "integrator"};

/// A record for each reading, each of which begins with the same fields.
void append_readings(const std::vector<std::string>& step, const Measured& measured, Intervals& intervals,
                     std::string& csv) {
  for (const MeasuredMeter& meter : measured.meters) {
    for (const Reading& reading : meter.readings) {
      std::vector<std::string> fields = step;
      fields.insert(fields.end(), {meter.name, meter.quantity, meter.unit, reading.label});
      append_vector(reading.position, std::isfinite(reading.position.x), fields);
      append_vector(reading.normal, reading.normal.length2() > 0, fields);
      const ConfidenceInterval interval = intervals.of(reading.figure);
      for (const double number :
           {reading.figure.value, reading.figure.standard_error, interval.low, interval.high})
        fields.push_back(shortest_text(number));
      fields.push_back(absl::StrCat(reading.figure.samples));
      fields.push_back(meter.algorithm);
      append_record(fields, csv);
    }
  }
}

}  // namespace

std::string measured_csv(const Measured& measured) {
  std::string csv;
  append_record(kCsvColumns, csv);
  Intervals intervals;
  append_readings({}, measured, intervals, csv);
  return csv;
}

std::string measured_csv(const MeasuredSeries& series) {
  std::string csv;
  std::vector<std::string> columns{series.name, "sky", "sun_altitude"};
  columns.insert(columns.end(), kCsvColumns.begin(), kCsvColumns.end());
  append_record(columns, csv);
  Intervals intervals;
  for (const MeasuredStep& step : series.steps) {
    const double altitude = step.sun_altitude_degrees;
    append_readings(
        {shortest_text(step.value), step.sky, std::isfinite(altitude) ? shortest_text(altitude) : ""},
        step.measured, intervals, csv);
  }
  return csv;
}

}  // namespace tessera::client
