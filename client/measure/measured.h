// Figures with units and standard errors, by meter and place.
#pragma once

#include <ImathVec.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tessera::client {

/// A number with its standard error, both in the unit of the meter.
struct Figure {
  double value = 0;
  double standard_error = 0;
  std::uint64_t samples = 0;
  double degrees_of_freedom = 0;  // of the standard error; 0: the value is exact
};

/// A figure at a place.
struct Reading {
  std::string label;      // tells the figures of one meter apart: "x", "C 0 gamma 45", "2 3" (column, row)
  Imath::V3d position{};  // world space; NaN where there is none
  Imath::V3d normal{};    // unit length; 0 where there is none
  Figure figure;
};

/// A part of a plane whose cells have a reading each, in rows from `corner` along edge_u.
struct MeasuredPlane {
  Imath::V3d corner, edge_u, edge_v;  // world space
  std::uint32_t columns = 1, rows = 1;
  std::size_t first_reading = 0;  // in the meter's readings
};

/// A surface whose triangles have a reading each, in their order. Those without area have no value.
struct MeasuredMesh {
  std::string shape;
  std::vector<Imath::V3d> vertices;  // world space
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool turned = false;            // light is received against cross(b - a, c - a)
  std::size_t first_reading = 0;  // in the meter's readings
};

struct MeasuredMeter {
  std::string name;
  std::string quantity;   // "illuminance"
  std::string unit;       // "lx"
  std::string algorithm;  // the integrator; empty: a closed form
  std::vector<Reading> readings;
  std::vector<MeasuredPlane> planes;
  std::vector<MeasuredMesh> meshes;
  std::vector<std::string> warnings;
};

/// A whole run of `tessera measure`.
struct Measured {
  std::string scene, meters_file;
  double metres_per_unit = 0;  // of the scene; 0: not said
  double wanted_error = 0;     // relative, of 95 % intervals; 0: none was asked for
  double worst_error = 0;      // that was reached
  std::string worst_meter;
  double cpu_seconds = 0;
  std::uint64_t seed = 0;
  std::vector<MeasuredMeter> meters;
};

/// The word of steps whose sun is below the horizon: their sky is black.
inline constexpr const char kNightWord[] = "night";

/// All figures under one of the skies of a series.
struct MeasuredStep {
  double value = 0;                 // an hour, or a CIE type
  std::string sky;                  // a word: "day", "night", the name of a CIE sky
  double sun_altitude_degrees = 0;  // NaN where nobody says where the sun is
  Measured measured;                // of all steps the same meters and readings
};

struct MeasuredSeries {
  std::string name;  // what the steps are told apart by: "hour" or "cie_type"
  std::vector<MeasuredStep> steps;
};

}  // namespace tessera::client
