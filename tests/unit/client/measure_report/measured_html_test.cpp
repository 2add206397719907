#include "measure/report/measured_html.h"

#include <gmock/gmock.h>

#include <pugixml.hpp>
#include <set>

#include "unit/client/measure_report/samples.h"

namespace tessera::client {
namespace {

/// Parses the page as XML, which HTML of this form is, too.
pugi::xml_document parsed(const std::string& html) {
  pugi::xml_document page;
  const pugi::xml_parse_result result = page.load_buffer(html.data(), html.size(), pugi::parse_default);
  EXPECT_TRUE(result) << result.description() << " at "
                      << html.substr(static_cast<std::size_t>(result.offset), 80);
  return page;
}

std::vector<pugi::xml_node> all(const pugi::xml_document& page, const char* path) {
  std::vector<pugi::xml_node> nodes;
  for (const pugi::xpath_node& found : page.select_nodes(path)) nodes.push_back(found.node());
  return nodes;
}

Measured example() {
  MeasuredMeter wall = floor_of(4, 3);
  wall.name = "wall";
  wall.planes[0].edge_v = {0, 0, 2};
  wall.warnings = {"two cells are inside <column>"};
  MeasuredMeter desk = meter_of("desk", "illuminance", "lx", "bdpt");
  desk.readings = {reading_at({1, 2, 0.75}, 512.34, 0.83)};
  MeasuredMeter gonio = meter_of("gonio", "luminous intensity", "cd", "light");
  for (int i = 0; i < 40; ++i) {
    gonio.readings.push_back(exact_flux().readings[0]);
    gonio.readings.back().label = "C 0 gamma " + std::to_string(i);
  }
  Measured room = room_of({floor_of(6, 4), wall, desk, exact_flux(), gonio});
  room.wanted_error = 0.01, room.worst_error = 0.009, room.worst_meter = "desk", room.cpu_seconds = 12.5;
  return room;
}

TEST(MeasuredHtml, IsWellFormed) {
  const pugi::xml_document page = parsed(measured_html(example()));
  EXPECT_STREQ(page.document_element().name(), "html");
  EXPECT_STREQ(page.document_element().attribute("lang").value(), "en");
  EXPECT_EQ(all(page, "//h1").size(), 1u);
  EXPECT_EQ(all(page, "/html/head/title").size(), 1u);
  EXPECT_EQ(all(page, "/html/head/style").size(), 1u);
  for (const pugi::xml_node& row : all(page, "//tr")) {
    int cells = 0;
    for (const pugi::xml_node& cell : row.children()) cells += cell.name()[0] == 't';
    EXPECT_EQ(cells, 8);
  }
  // Elements within each other as HTML allows them.
  for (const char* path : {"//p//p", "//p//div", "//table[not(tbody)]", "//dl/*[not(self::div)]",
                           "//ul/*[not(self::li)]", "//figure//table", "//text()[parent::svg]"})
    EXPECT_TRUE(all(page, path).empty()) << path;
}

TEST(MeasuredHtml, NeedsNothingElse) {
  const std::string html = measured_html(example());
  const pugi::xml_document page = parsed(html);
  EXPECT_EQ(html.find("http:"), std::string::npos);
  EXPECT_EQ(html.find("https:"), std::string::npos);
  EXPECT_EQ(html.find("url("), std::string::npos);
  EXPECT_EQ(html.find("@import"), std::string::npos);
  for (const char* path :
       {"//script", "//link", "//iframe", "//object", "//img", "//a", "//@onclick", "//@onload"})
    EXPECT_TRUE(page.select_nodes(path).empty()) << path;
  std::size_t pictures = 0;
  for (const pugi::xpath_node& found : page.select_nodes("//@src | //@href")) {
    EXPECT_TRUE(std::string(found.attribute().value()).starts_with("data:image/png;base64,iVBOR"));
    ++pictures;
  }
  EXPECT_EQ(pictures, 2 * 2u) << "a map and its legend for each plane";
  std::set<std::string> ids;
  for (const pugi::xpath_node& id : page.select_nodes("//@id"))
    EXPECT_TRUE(ids.insert(id.attribute().value()).second)
        << "two elements are called " << id.attribute().value();
}

TEST(MeasuredHtml, TellsThoseWhoCannotSeeIt) {
  const pugi::xml_document page = parsed(measured_html(example()));
  const std::vector<pugi::xml_node> drawings = all(page, "//svg");
  EXPECT_EQ(drawings.size(), 1 + 2 * 4u) << "the plan; a map, a histogram and two sections for each plane";
  for (const pugi::xml_node& svg : drawings) {
    EXPECT_STREQ(svg.attribute("role").value(), "img");
    EXPECT_STRNE(svg.attribute("aria-label").value(), "");
  }
  EXPECT_THAT(std::string(drawings[1].attribute("aria-label").value()),
              testing::HasSubstr("illuminance, floor: 1.00 to 24 lx"));
}

TEST(MeasuredHtml, HasEveryMeterWithItsFigures) {
  const pugi::xml_document page = parsed(measured_html(example()));
  const auto row_of = [&](const std::string& meter) {
    std::string text;
    for (const pugi::xml_node& row : all(page, "//tr[td]")) {
      if (row.child("td").next_sibling().text().get() != meter) continue;
      for (const pugi::xml_node& cell : row.children()) text += std::string(cell.text().get()) + "|";
      break;
    }
    return text;
  };
  EXPECT_EQ(row_of("desk"), "3|desk|(1, 2, 0.75)|512.3 \u00b1 0.8|lx|510.7 to 514.0|4096|bdpt|");
  EXPECT_EQ(row_of("lamp"), "4|lamp||12.5664|lm|exact|0|closed form|");
  EXPECT_THAT(row_of("floor"),
              testing::StartsWith("1|floor|mean of 6 \u00d7 4 cells|12.500 \u00b1 0.026|lx|"));
  EXPECT_EQ(all(page, "//details//tr[td]").size(), 40u) << "many figures of one meter are folded";
  EXPECT_THAT(
      std::string(page.select_node("//*[@class='warnings']//li").node().child("b").next_sibling().value()),
      testing::HasSubstr("inside <column>"));
}

TEST(MeasuredHtml, NamesAreTextAndNoMarkup) {
  const std::string hostile = "<script>alert(1)</script> & \"x\" 'y' ]]> --> \xff\x01 \u00e9";
  Measured room = example();
  room.scene = hostile;
  for (MeasuredMeter& meter : room.meters) {
    meter.name = meter.quantity = meter.unit = meter.algorithm = hostile;
    meter.warnings = {hostile};
    for (Reading& reading : meter.readings) reading.label = hostile;
  }
  MeasuredReportOptions options;
  options.title = hostile;
  const pugi::xml_document page = parsed(measured_html(room, options));
  EXPECT_TRUE(all(page, "//script").empty());
  const std::string shown = "<script>alert(1)</script> & \"x\" 'y' ]]> --> \uFFFD\uFFFD \u00e9";
  EXPECT_EQ(std::string(page.select_node("//h1").node().text().get()), shown);
  EXPECT_EQ(
      std::string(page.select_node("//svg[2]/@aria-label | //section[@class='plane'][1]//svg[1]/@aria-label")
                      .attribute()
                      .value())
          .find("<script>alert"),
      std::string("False-colour map of ").size());
}

TEST(MeasuredHtml, TakesRunsWithoutMetersOrPlaces) {
  parsed(measured_html(Measured{}));
  const pugi::xml_document page = parsed(measured_html(room_of({exact_flux()})));
  EXPECT_TRUE(all(page, "//svg").empty()) << "there is nothing to draw";
  MeasuredMeter floor = floor_of(2, 2);
  floor.planes[0].columns = 3;
  EXPECT_EQ(all(parsed(measured_html(room_of({floor}))), "//section[@class='plane']").size(), 0u)
      << "a plane without its readings";
}

TEST(MeasuredHtml, IsTheSameEachTime) { EXPECT_EQ(measured_html(example()), measured_html(example())); }

}  // namespace
}  // namespace tessera::client
