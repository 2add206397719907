#include "measure/report/measured_table.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "measure/report/figure_text.h"
#include "measure/report/measured_html.h"
#include "unit/client/measure_report/samples.h"

namespace tessera::client {
namespace {

using Records = std::vector<std::vector<std::string>>;

/// Reads RFC 4180; fails where a quote stands where none may.
Records read_csv(const std::string& csv) {
  Records records(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    std::string& field = records.back().back();
    if (quoted) {
      if (csv[i] != '"') {
        field += csv[i];
      } else if (i + 1 < csv.size() && csv[i + 1] == '"') {
        field += '"', ++i;
      } else {
        quoted = false;
      }
    } else if (csv[i] == '"') {
      EXPECT_TRUE(field.empty()) << "a quote within a field at " << i;
      quoted = true;
    } else if (csv[i] == ',') {
      records.back().emplace_back();
    } else if (csv.compare(i, 2, "\r\n") == 0) {
      ++i;
      records.push_back({""});
    } else {
      EXPECT_TRUE(csv[i] != '\r' && csv[i] != '\n') << "half a line end at " << i;
      field += csv[i];
    }
  }
  EXPECT_FALSE(quoted);
  EXPECT_EQ(records.back(), std::vector<std::string>{""}) << "the last record has its line end";
  records.pop_back();
  return records;
}

TEST(MeasuredCsv, QuotesWhatWouldPartFields) {
  MeasuredMeter meter = exact_flux();
  meter.name = "the \"big\" lamp,\nby the door";
  meter.readings[0].label = "C 0, gamma 45";
  const Records records = read_csv(measured_csv(room_of({meter})));
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[1][0], meter.name);
  EXPECT_EQ(records[1][3], "C 0, gamma 45");
}

TEST(MeasuredCsv, HasARecordForEachReading) {
  MeasuredMeter floor = floor_of(3, 2);
  floor.readings[4].figure.value = 1.0 / 3;
  const Records records = read_csv(measured_csv(room_of({floor, exact_flux()})));
  EXPECT_THAT(records[0],
              testing::ElementsAre("meter", "quantity", "unit", "label", "x", "y", "z", "nx", "ny", "nz",
                                   "value", "standard_error", "low95", "high95", "samples", "integrator"));
  ASSERT_EQ(records.size(), 1 + 6 + 1u);
  for (const auto& record : records) EXPECT_EQ(record.size(), 16u);
  EXPECT_EQ(std::stod(records[5][10]), 1.0 / 3) << "no digit is lost";
  EXPECT_EQ(std::stod(records[5][4]), floor.readings[4].position.x);
  const ConfidenceInterval interval = confidence_95(floor.readings[4].figure);
  EXPECT_DOUBLE_EQ(std::stod(records[5][12]), interval.low);
  EXPECT_DOUBLE_EQ(std::stod(records[5][13]), interval.high);
  EXPECT_EQ(records[5][14], "4096");
  EXPECT_EQ(records[5][15], "path");
  for (const std::size_t place : {4u, 5u, 6u, 7u, 8u, 9u})
    EXPECT_EQ(records[7][place], "") << "a flux has neither place nor normal";
  EXPECT_EQ(std::stod(records[7][12]), 4 * M_PI) << "the interval of an exact value";
}

TEST(MeasuredJson, ReadsAsTheSameNumbers) {
  MeasuredMeter floor = floor_of(2, 2);
  floor.readings[1].figure = {
      .value = M_PI / 7, .standard_error = 1e-17, .samples = 1ull << 60, .degrees_of_freedom = 2.5};
  floor.readings[3].figure.value = std::numeric_limits<double>::quiet_NaN();
  floor.warnings = {"a cell is inside 'box'"};
  Measured room = room_of({floor, exact_flux()});
  room.seed = ~0ull;
  room.wanted_error = 0.01, room.worst_error = 0.009, room.worst_meter = "floor";
  const nlohmann::json read = nlohmann::json::parse(measured_json(room));
  EXPECT_EQ(read["seed"], ~0ull);
  EXPECT_EQ(read["wanted_error"], 0.01);
  ASSERT_EQ(read["meters"].size(), 2u);
  const nlohmann::json& meter = read["meters"][0];
  EXPECT_EQ(meter["unit"], "lx");
  EXPECT_EQ(meter["warnings"][0], floor.warnings[0]);
  ASSERT_EQ(meter["readings"].size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Figure& figure = floor.readings[i].figure;
    EXPECT_EQ(meter["readings"][i]["value"].get<double>(), figure.value);
    EXPECT_EQ(meter["readings"][i]["standard_error"].get<double>(), figure.standard_error);
    EXPECT_EQ(meter["readings"][i]["degrees_of_freedom"].get<double>(), figure.degrees_of_freedom);
    EXPECT_EQ(meter["readings"][i]["samples"].get<std::uint64_t>(), figure.samples);
    EXPECT_EQ(meter["readings"][i]["position"][1].get<double>(), floor.readings[i].position.y);
  }
  EXPECT_TRUE(meter["readings"][3]["value"].is_null());
  EXPECT_EQ(meter["planes"][0]["columns"], 2);
  EXPECT_EQ(meter["planes"][0]["edge_u"][0], 3.0);
  EXPECT_EQ(meter["planes"][0]["max"], 3.0);
  const nlohmann::json& flux = read["meters"][1]["readings"][0];
  EXPECT_TRUE(flux["position"].is_null());
  EXPECT_TRUE(flux["normal"].is_null());
}

TEST(MeasuredJson, TakesNamesThatAreNoText) {
  MeasuredMeter meter = exact_flux();
  meter.name = "\xff\xfe\x01 \"";
  EXPECT_TRUE(nlohmann::json::accept(measured_json(room_of({meter}))));
}

TEST(MeasuredText, SummarisesPlanes) {
  MeasuredMeter desk = meter_of("desk", "illuminance", "lx", "bdpt");
  desk.readings = {reading_at({1, 2, 0.75}, 512.34, 0.83)};
  desk.warnings = {"it lies in the shade"};
  Measured room = room_of({floor_of(3, 2), desk, exact_flux()});
  room.wanted_error = 0.01, room.worst_error = 0.0323, room.worst_meter = "desk";
  // The mean of six cells with an error of 1/8 each: 3.5 +- 1/8 / sqrt(6) = 0.051, with 6 * 63 degrees of
  // freedom, for which t is 1.966. That of 63 is 1.998.
  EXPECT_EQ(
      measured_text(room),
      "meter  place                                                         value  unit  +- standard error"
      "  95 % interval   samples  integrator\n"
      "floor  mean of 3 x 2 cells: min 1.00, max 6.0, U0 0.286, U1 0.167     3.50  lx              +- 0.05"
      "  3.40 to 3.60      24576  path\n"
      "desk   (1, 2, 0.75)                                                  512.3  lx               +- 0.8"
      "  510.7 to 514.0     4096  bdpt\n"
      "lamp                                                               12.5664  lm                exact"
      "                        0\n"
      "warning: meter 'desk': it lies in the shade\n"
      "worst 95 % interval: +- 3.2 % of meter 'desk', +- 1 % asked for\n");
}

TEST(MeasuredText, TellsAllCellsWhenAskedTo) {
  const Measured room = room_of({floor_of(3, 2)});
  const auto lines = [](const std::string& text) { return std::ranges::count(text, '\n'); };
  EXPECT_EQ(lines(measured_text(room)), 2);
  EXPECT_EQ(lines(measured_text(room, {.all_cells = true})), 2 + 6);
}

/// Two steps of a room, the first by night.
MeasuredSeries a_night_and_a_day() {
  MeasuredSeries series{.name = "hour", .steps = {}};
  for (const double hour : {3.0, 11.5}) {
    const bool night = hour < 6;
    MeasuredMeter desk = meter_of("desk", "illuminance", "lx", "path");
    desk.readings.push_back(reading_at({1, 2, 0.75}, night ? 0 : 512, night ? 0 : 1, night ? 0 : 63));
    if (night) desk.warnings.emplace_back("dark");
    MeasuredMeter floor = floor_of(3, 2);
    series.steps.push_back({.value = hour,
                            .sky = night ? kNightWord : "day",
                            .sun_altitude_degrees = night ? std::nan("") : 60,
                            .measured = room_of({desk, floor})});
  }
  return series;
}

TEST(MeasuredSeriesTable, RecordsBeginWithTheStep) {
  const Records records = read_csv(measured_csv(a_night_and_a_day()));
  ASSERT_EQ(records.size(), 1u + 2 * 7);
  EXPECT_THAT(records[0], testing::Contains("meter"));
  EXPECT_EQ(records[0][0], "hour");
  EXPECT_EQ(records[1][0], "3");
  EXPECT_EQ(records[1][1], "night");
  EXPECT_EQ(records[1][2], "");
  EXPECT_EQ(records[8][0], "11.5");
  EXPECT_EQ(records[8][2], "60");
  EXPECT_EQ(records[8][3], "desk");
  for (const auto& record : records) EXPECT_EQ(record.size(), records[0].size());
}

TEST(MeasuredSeriesTable, JsonHasTheStepsByTheirName) {
  const auto json = nlohmann::json::parse(measured_json(a_night_and_a_day()));
  EXPECT_EQ(json["series"], "hour");
  ASSERT_EQ(json["steps"].size(), 2u);
  EXPECT_EQ(json["steps"][1]["hour"], 11.5);
  EXPECT_EQ(json["steps"][0]["sky"], "night");
  EXPECT_TRUE(json["steps"][0]["sun_altitude_degrees"].is_null());
  EXPECT_EQ(json["steps"][1]["meters"][0]["readings"][0]["value"], 512);
}

TEST(MeasuredSeriesTable, TextHasAColumnOfSteps) {
  const std::string text = measured_text(a_night_and_a_day());
  EXPECT_THAT(text, testing::StartsWith("hour       meter"));
  EXPECT_THAT(text, testing::HasSubstr("\n3 (night)  desk"));
  EXPECT_THAT(text, testing::HasSubstr("\n11.5       desk"));
  EXPECT_THAT(text, testing::HasSubstr("hour 3 (night): warning: meter 'desk': dark"));
}

TEST(MeasuredSeriesTable, APageHasADiagramOfEachMeterAndFoldsTheSteps) {
  const std::string page = measured_html(a_night_and_a_day());
  pugi::xml_document document;
  ASSERT_TRUE(document.load_string(page.c_str(), pugi::parse_default | pugi::parse_doctype));
  EXPECT_EQ(
      document.select_nodes("//div[@class='diagrams']//svg[contains(@aria-label, 'over the series')]").size(),
      2u);
  EXPECT_EQ(document.select_nodes("//main/details").size(), 2u);
  EXPECT_THAT(page, testing::HasSubstr("hour 3 (night): night"));
  EXPECT_THAT(page, testing::HasSubstr("desk, hour 3 (night)"));
}

}  // namespace
}  // namespace tessera::client
