// `tessera measure` as users have it: the same figures here and on a farm, exit codes, and messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kLamplit = "scenes/first-light/scene.textproto";
constexpr const char* kTwoMeters = R"(
    meters { name: "table" irradiance { receivers { plane {
      corner { x: -1 y: 0.3 z: -1 } edge_u { z: 2 } edge_v { x: 2 } columns: 3 rows: 2 } } } }
    meters { name: "eye" unit: "cd/m2" radiance { ray { from { y: 0.5 z: -4 } toward { y: 0.5 } field_degrees: 1 } } }
    up: Y)";

class Measure : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) const {
    const fs::path file = folder_.path() / name;
    std::ofstream{file} << text;
    return file.string();
  }
  std::string path(const char* name) const { return (folder_.path() / name).string(); }
  std::string read(const char* name) const {
    std::ifstream file(path(name));
    return {std::istreambuf_iterator<char>(file), {}};
  }
  support::Finished measure(const std::string& meters, const Arguments& more = {}) const {
    return tessera(Arguments{"measure", kLamplit, write("meters.textproto", meters), "--quiet"} + more);
  }

  const support::TempDir folder_;
};

TEST_F(Measure, AFarmFindsTheSameFiguresAlsoWhenAWorkerDies) {
  const Arguments how{"--error", "0.05", "--seed", "3"};
  const support::Finished here =
      measure(kTwoMeters, how + Arguments{"--threads", "3", "-o", path("here.csv")});
  ASSERT_EQ(here.status.code, 0) << here.err;
  FarmUnderTest farm;
  farm.add_worker(1);
  farm.add_worker(1);
  Arguments arguments = farm.on_farm(
      Arguments{"measure", kLamplit, path("meters.textproto"), "--farm", "--quiet", "-o", path("farm.csv")} +
      how);
  arguments.insert(arguments.begin(), tessera_program());
  support::Process client{arguments};
  farm.kill_worker(0);
  ASSERT_EQ(client.wait(kPatience).value().code, 0) << client.err();
  EXPECT_THAT(read("here.csv"), HasSubstr("table,illuminance,lx,1 1,"));
  EXPECT_EQ(read("farm.csv"), read("here.csv"));
}

TEST_F(Measure, TellsWhatIsWrongWithMetersAndWhere) {
  const auto refused = [&](const std::string& meters, const std::string& message,
                           const Arguments& more = {}) {
    const support::Finished done = measure(meters, more);
    EXPECT_EQ(done.status.code, 2) << done.out;
    EXPECT_THAT(done.err, HasSubstr(message));
  };
  refused("meters { irradiance { } }\nmeters {\n  name: \"b\" flux { receivers { point {} } } }",
          "meters.textproto:1: meter 1: it has no receivers");
  refused("\nmeters { name: \"b\" flux { receivers { point {} } } }",
          "meters.textproto:2: meter 1 (b): flux is of planes and surfaces");
  refused("meters { iradiance {} }", "meters.textproto:1:20: ");
  refused("meters { unit: \"luxx\" irradiance { receivers { point {} } } }", "lux");
  refused("meters { irradiance { receivers { surface { shape: \"sofa\" } } } }", "there is no shape 'sofa'");
  refused("meters { irradiance { receivers { surface { shape: \"table\" by_triangle: true } } } }",
          "meter 1: shape 'table': it has no triangles");
  refused("meters { ratio { of: \"a\" over: \"b\" } }", "meter 1: there is no meter 'a'");
  refused(kTwoMeters, "is biased: the error", {"--integrator", "whitted"});
  refused(kTwoMeters, "is consistent: the error", {"--integrator", "vcm"});
  refused(
      "meters { irradiance { receivers { plane { edge_u { x: 1 } edge_v { y: 1 } columns: 4000000000 rows: "
      "100000 } } } }",
      "GB");
}

TEST_F(Measure, EndsWithWhatItHasWhenTheTimeIsUp) {
  const support::Finished done =
      measure(kTwoMeters, {"--error", "0.00001", "--time", "0", "-o", path("figures.csv")});
  EXPECT_EQ(done.status.code, 6);
  EXPECT_THAT(done.err, HasSubstr("the time is up"));
  EXPECT_THAT(read("figures.csv"), HasSubstr("table,illuminance,lx"));
}

TEST_F(Measure, MapsSurfacesAndDividesMeters) {
  const std::string scene = write("box.textproto", R"(
      camera { perspective { fov_degrees: 40 } } film { width: 4 height: 4 }
      materials { name: "white" diffuse { reflectance { constant { constant: 0.5 } } } }
      shapes { name: "box" material: "white" box { low: [-1, -1, -1] high: [1, 1, 1] } }
      lights { point { position { x: 3 y: 2 z: 4 } intensity { rgb { r: 9 g: 9 b: 9 } } } })");
  const std::string meters = write("box-meters.textproto", R"(
      meters { name: "sides" irradiance { receivers { surface { shape: "box" by_triangle: true } } } }
      meters { name: "middle" irradiance { receivers { point { position { z: 1.5 } } } } }
      meters { name: "against the middle" ratio { of: "sides" over: "middle" } }
      meters { name: "sky" radiance { area { x1: 0.5 y1: 1 } } })");
  const support::Finished done =
      tessera({"measure", scene, meters, "--samples", "64", "-o", path("figures.csv"), "--html",
               path("figures.html"), "--maps", path("maps"), "--seed", "2"});
  ASSERT_EQ(done.status.code, 0) << done.err;
  EXPECT_THAT(read("figures.csv"), HasSubstr("sides,illuminance,lx,11,"));
  EXPECT_THAT(read("figures.csv"), HasSubstr("against the middle,ratio,1,11,"));
  EXPECT_THAT(read("figures.html"), HasSubstr("12 triangles of box"));
  EXPECT_THAT(read("maps/1-mesh-1.ply"), HasSubstr("element face 12"));
  EXPECT_TRUE(fs::exists(path("maps/3-mesh-1.png")));
  EXPECT_THAT(done.err, HasSubstr(" samples: "));
}

TEST_F(Measure, WritesPagesMapsAndTables) {
  const support::Finished done = measure(kTwoMeters, {"--samples", "64", "-o", path("figures.json"), "--html",
                                                      path("figures.html"), "--maps", path("maps")});
  ASSERT_EQ(done.status.code, 0) << done.err;
  EXPECT_THAT(read("figures.json"), HasSubstr("\"standard_error\""));
  EXPECT_THAT(read("figures.html"), HasSubstr("</html>"));
  EXPECT_TRUE(fs::exists(path("maps/1-1.png")));
  EXPECT_TRUE(fs::exists(path("maps/1-1.exr")));
}

TEST_F(Measure, GoesThroughTheSkiesOfADay) {
  const auto scene_at = [&](const char* name, const std::string& hour) {
    return write(name, R"(
      camera { perspective { fov_degrees: 40 } } film { width: 4 height: 4 }
      materials { name: "white" diffuse { reflectance { constant { constant: 0.5 } } } }
      shapes { material: "white" box { low: [-1, -1, -1] high: [1, 1, 1] } }
      lights { sky { cie_type: 12 when { latitude_degrees: 48 longitude_degrees: 11 utc_offset_hours: 1
        year: 2024 month: 6 day: 21 hour: )" +
                           hour + " } } }");
  };
  constexpr const char* kTop = R"(
      meters { name: "top" irradiance { receivers { point { position { z: 1.5 } } } } }
      meters { name: "eye" glare { eye { y: -4 } toward {} resolution: 16 } }
      meters { name: "half" daylight_factor { receivers { point { position { z: 1.5 } } } } })";
  const std::string meters = write("top.textproto", kTop);
  const std::string series =
      write("day.textproto", std::string(kTop) + "\nseries { hours { first: 2 last: 12 step: 5 } }");
  const Arguments how{"--samples", "64", "--quiet", "--seed", "5"};
  const support::Finished day =
      tessera(Arguments{"measure", scene_at("scene.textproto", "9"), series, "-o", path("day.csv"), "--html",
                        path("day.html"), "--maps", path("maps")} +
              how);
  ASSERT_EQ(day.status.code, 0) << day.err;
  EXPECT_THAT(read("day.csv"), HasSubstr("\n2,night,-"));
  EXPECT_THAT(read("day.csv"), HasSubstr(",top,illuminance,lx,1,0,0,1.5,0,0,1,0,0,0,0,64,path"));
  EXPECT_THAT(read("day.html"), HasSubstr("top over the series"));
  // A step has the figures of its scene alone.
  const support::Finished noon =
      tessera(Arguments{"measure", scene_at("noon.textproto", "12"), meters, "-o", path("noon.csv")} + how);
  ASSERT_EQ(noon.status.code, 0) << noon.err;
  const std::string alone = read("noon.csv");
  const std::string top =
      alone.substr(alone.find("top,illuminance"), alone.find("\r\neye") - alone.find("top,"));
  EXPECT_THAT(read("day.csv"), HasSubstr(top));
  const support::Finished dark =
      measure("meters { irradiance { receivers { point {} } } }\nseries { hours {} }");
  EXPECT_EQ(dark.status.code, 2);
  EXPECT_THAT(dark.err, HasSubstr("meters.textproto:2: series: the scene has no `sky` light"));
}

}  // namespace
}  // namespace tessera::integration
