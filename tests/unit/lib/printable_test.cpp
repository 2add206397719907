#include "base/printable.h"

#include <gtest/gtest.h>

#include "tessera/v1/farm.pb.h"
#include "wire/printable_message.h"

namespace tessera::base {
namespace {

TEST(Printable, SpellsOutWhatMovesTheCursor) {
  EXPECT_EQ(printable("a\x1b[2Jb\rc\nd\te\x7f"), "a\\x1b[2Jb\\x0dc\\nd\\x09e\\x7f");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable_lines("one\ntwo\r\x1b"), "one\ntwo\\x0d\\x1b");
  // The C1 set in UTF-8 (U+009B begins sequences like ESC [), a mark that turns the text around, a line
  // separator.
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J"),
            "\\xc2\\x9b2J");
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "fdp.exe"),
            "\\xe2\\x80\\xaefdp.exe");
  EXPECT_EQ(printable("\xe2\x80\xa8"), "\\xe2\\x80\\xa8");
}

TEST(Printable, LeavesNamesInAnyLanguage) {
  for (const char* text :
       {"", "cornell-box \"final\" (v2) \\ 100 %", "Bücher", "渲染 農場", "Ωμέγα", "🎬 scene", "\xc2\xa0"}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, SpellsOutBytesThatAreNotUtf8) {
  EXPECT_EQ(printable("\x9b"
                      "2J"),
            "\\x9b2J");                                              // Latin-1
  EXPECT_EQ(printable("\xc0\x9b"), "\\xc0\\x9b");                    // overlong
  EXPECT_EQ(printable("\xe0\x82\x9b"), "\\xe0\\x82\\x9b");           // likewise
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // half of a surrogate pair
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond Unicode
  EXPECT_EQ(printable("ab\xe2\x80"), "ab\\xe2\\x80");                // cut
}

TEST(Printable, BeginningsEndBetweenCharacters) {
  EXPECT_EQ(beginning_of("one", 3), "one");
  EXPECT_EQ(beginning_of("one", 2), "on");
  EXPECT_EQ(beginning_of("", 0), "");
  const std::string text = "a\u00fc\u6e32\U0001f3ac";  // characters of 1, 2, 3 and 4 bytes
  const std::size_t ends[] = {0, 1, 1, 3, 3, 3, 6, 6, 6, 6, 10};
  for (std::size_t bytes = 0; bytes < std::size(ends); ++bytes)
    EXPECT_EQ(beginning_of(text, bytes).size(), ends[bytes]) << bytes;
  EXPECT_EQ(beginning_of("\x80\x80\x80\x80\x80\x80", 5).size(), 5u) << "not UTF-8, and cut anywhere";
}

TEST(Printable, GoesThroughWholeMessages) {
  v1::GetJobResponse response;
  response.mutable_status()->set_name("a\x1b[31m");
  response.mutable_status()->add_notes("b\r");
  response.mutable_status()->add_notes("c");
  response.mutable_status()->add_set_aside()->add_failures()->set_message("d\ne");
  (*response.mutable_status()->mutable_stats()->mutable_material_ns())["f\x1b"] = 3;
  wire::make_printable(response);
  EXPECT_EQ(response.status().name(), "a\\x1b[31m");
  EXPECT_EQ(response.status().notes(0), "b\\x0d");
  EXPECT_EQ(response.status().notes(1), "c");
  EXPECT_EQ(response.status().set_aside(0).failures(0).message(), "d\\ne");
  ASSERT_EQ(response.status().stats().material_ns().size(), 1u);
  EXPECT_EQ(response.status().stats().material_ns().begin()->first, "f\\x1b");

  v1::WatchJobResponse watched;
  watched.add_results()->set_payload("\x1b\r\n");
  wire::make_printable(watched);
  EXPECT_EQ(watched.results(0).payload(), "\x1b\r\n") << "bytes are no text";
}

}  // namespace
}  // namespace tessera::base
