#include <cmath>
#include <nlohmann/json.hpp>

#include "measure/report/intervals.h"
#include "measure/report/measured_table.h"
#include "measure/report/plane_summary.h"

namespace tessera::client {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinities.
Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json json_vector(const Imath::V3d& vector, bool there) {
  if (!there) return Json();
  return {json_number(vector.x), json_number(vector.y), json_number(vector.z)};
}

void add_figure(const Figure& figure, Intervals& intervals, Json& object) {
  const ConfidenceInterval interval = intervals.of(figure);
  object["value"] = json_number(figure.value);
  object["standard_error"] = json_number(figure.standard_error);
  object["low95"] = json_number(interval.low);
  object["high95"] = json_number(interval.high);
  object["samples"] = figure.samples;
  object["degrees_of_freedom"] = json_number(figure.degrees_of_freedom);
}

void add_summary(const PlaneSummary& summary, Intervals& intervals, Json& object) {
  Json mean;
  add_figure(summary.mean, intervals, mean);
  object["mean"] = std::move(mean);
  object["min"] = json_number(summary.least), object["max"] = json_number(summary.most);
  object["u0"] = json_number(summary.uniformity_mean), object["u1"] = json_number(summary.uniformity_most);
}

Json json_of(const MeasuredMeter& meter, const MeasuredPlane& plane, Intervals& intervals) {
  Json object{{"corner", json_vector(plane.corner, true)},
              {"edge_u", json_vector(plane.edge_u, true)},
              {"edge_v", json_vector(plane.edge_v, true)},
              {"columns", plane.columns},
              {"rows", plane.rows},
              {"first_reading", plane.first_reading}};
  add_summary(summary_of(meter, plane), intervals, object);
  return object;
}

Json json_of(const MeasuredMeter& meter, const MeasuredMesh& mesh, Intervals& intervals) {
  Json vertices = Json::array();
  for (const Imath::V3d& vertex : mesh.vertices) vertices.push_back(json_vector(vertex, true));
  Json object{{"shape", mesh.shape},
              {"vertices", std::move(vertices)},
              {"triangles", mesh.triangles},
              {"first_reading", mesh.first_reading}};
  add_summary(summary_of(meter, mesh), intervals, object);
  return object;
}

Json json_of(const MeasuredMeter& meter, Intervals& intervals) {
  Json readings = Json::array(), planes = Json::array(), meshes = Json::array();
  for (const Reading& reading : meter.readings) {
    Json row{{"label", reading.label},
             {"position", json_vector(reading.position, std::isfinite(reading.position.x))},
             {"normal", json_vector(reading.normal, reading.normal.length2() > 0)}};
    add_figure(reading.figure, intervals, row);
    readings.push_back(std::move(row));
  }
  for (const MeasuredPlane& plane : meter.planes) planes.push_back(json_of(meter, plane, intervals));
  for (const MeasuredMesh& mesh : meter.meshes) meshes.push_back(json_of(meter, mesh, intervals));
  return {{"name", meter.name},          {"quantity", meter.quantity},
          {"unit", meter.unit},          {"integrator", meter.algorithm},
          {"warnings", meter.warnings},  {"planes", std::move(planes)},
          {"meshes", std::move(meshes)}, {"readings", std::move(readings)}};
}

Json json_of(const Measured& measured, Intervals& intervals) {
  Json meters = Json::array();
  for (const MeasuredMeter& meter : measured.meters) meters.push_back(json_of(meter, intervals));
  return {{"scene", measured.scene},
          {"meters_file", measured.meters_file},
          {"metres_per_unit", json_number(measured.metres_per_unit)},
          {"wanted_error", json_number(measured.wanted_error)},
          {"worst_error", json_number(measured.worst_error)},
          {"worst_meter", measured.worst_meter},
          {"cpu_seconds", json_number(measured.cpu_seconds)},
          {"seed", measured.seed},
          {"meters", std::move(meters)}};
}

/// Names come from files of others: what is no UTF-8 is replaced, not thrown at the caller.
std::string json_text(const Json& whole) {
  return whole.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string measured_json(const Measured& measured) {
  Intervals intervals;
  return json_text(json_of(measured, intervals));
}

std::string measured_json(const MeasuredSeries& series) {
  Intervals intervals;
  Json steps = Json::array();
  for (const MeasuredStep& step : series.steps) {
    Json object{{series.name, json_number(step.value)},
                {"sky", step.sky},
                {"sun_altitude_degrees", json_number(step.sun_altitude_degrees)}};
    object.update(json_of(step.measured, intervals));
    steps.push_back(std::move(object));
  }
  return json_text({{"series", series.name}, {"steps", std::move(steps)}});
}

}  // namespace tessera::client
