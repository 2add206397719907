// Lenses in files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "optics/lens_system.h"
#include "optics/read/pbrt_lens_file.h"
#include "optics/read/zemax_file.h"

namespace tessera::optics {
namespace {

using testing::HasSubstr;

TEST(PbrtLensFile, HasALineForEachSurface) {
  std::vector<Fault> faults;
  const Prescription lens =
      read_pbrt_lens("# A singlet\n# more\n0 1 0 10\n\n60 7 1.52 10 # front\n-90 80 0 10\r\n", faults);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(lens.name, "A singlet");
  ASSERT_EQ(lens.surfaces.size(), 3u);
  EXPECT_TRUE(lens.surfaces[0].stop);
  EXPECT_EQ(lens.surfaces[1].radius, 60);
  EXPECT_EQ(lens.surfaces[1].behind.index, 1.52);
  EXPECT_EQ(lens.surfaces[2].behind.index, 1);
  EXPECT_EQ(lens.surfaces[2].line, 6);
}

TEST(PbrtLensFile, MayBeginWithAMark) {
  std::vector<Fault> faults;
  const Prescription lens = read_pbrt_lens("\xef\xbb\xbf# A singlet\r\n0 1 0 10\r\n60 7 1.52 10\r\n", faults);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(lens.name, "A singlet");
  EXPECT_EQ(lens.surfaces.size(), 2u);
}

TEST(PbrtLensFile, FaultsHaveLineAndColumn) {
  std::vector<Fault> faults;
  read_pbrt_lens("60 7 1.52\n60 seven 1.52 x\n", faults);
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[0].line, 1);
  EXPECT_THAT(faults[0].message, HasSubstr("four numbers"));
  EXPECT_EQ(faults[1].line, 2);
  EXPECT_EQ(faults[1].column, 4);
  EXPECT_THAT(faults[1].message, HasSubstr("'seven' is no number"));
  EXPECT_EQ(faults[2].column, 15);
}

constexpr const char* kZemax =
    "VERS 140124 258 36214\nMODE SEQ\nNAME A singlet\nUNIT MM X W X CM MR CPMM\nENPD 8 0\n"
    "SURF 0\n  TYPE STANDARD\n  CURV 0.0 0 0 0 0 \"\"\n  DISZ INFINITY\n  DIAM 0 0 0 0 1 \"\"\n"
    "SURF 1\n  TYPE STANDARD\n  CURV 0.0\n  DISZ 3\n  DIAM 10\n"
    "SURF 2\n  STOP\n  TYPE EVENASPH\n  CURV 0.02\n  CONI -0.5\n  PARM 1 0\n  PARM 2 1e-6\n  PARM 3 "
    "-2.5E-009\n"
    "  DISZ 5\n  GLAS N-BK7 0 0 1.5168 64.17\n  DIAM 5 1 0 0 1 \"\"\n"
    "SURF 3\n  TYPE STANDARD\n  CURV -0.01\n  DISZ 70\n  DIAM 5\n"
    "SURF 4\n  TYPE STANDARD\n  CURV 0\n  DISZ 0\n  DIAM 10\n";

TEST(ZemaxFile, IsReadWithGlassAndAspheres) {
  std::vector<Fault> faults;
  const ZemaxLens read = read_zemax_lens(kZemax, faults);
  for (const Fault& fault : faults) ADD_FAILURE() << fault.message;
  EXPECT_EQ(read.lens.name, "A singlet");
  ASSERT_EQ(read.lens.surfaces.size(), 2u);  // the plane in air before it bends nothing
  const Surface& front = read.lens.surfaces[0];
  EXPECT_TRUE(front.stop);
  EXPECT_EQ(front.radius, 50);
  EXPECT_EQ(front.conic, -0.5);
  EXPECT_EQ(front.aspheric, (std::vector<double>{1e-6, -2.5e-9}));
  EXPECT_EQ(front.diameter, 10);
  EXPECT_NEAR(front.behind.eta(kLineD), 1.5168, 1e-4);
  EXPECT_NEAR(read.f_number, paraxial_of(read.lens, kLineD).focal_length() / 8, 1e-9);
}

TEST(ZemaxFile, UnitsAreKept) {
  std::string inches = kZemax;
  inches.replace(inches.find("UNIT MM"), 7, "UNIT IN");
  std::vector<Fault> faults;
  const double mm = paraxial_of(read_zemax_lens(kZemax, faults).lens, kLineD).focal_length();
  const Prescription lens = read_zemax_lens(inches, faults).lens;
  EXPECT_TRUE(faults.empty());
  EXPECT_NEAR(paraxial_of(lens, kLineD).focal_length(), 25.4 * mm, 1e-9);
  // A shape is the same in any unit.
  EXPECT_NEAR(*sag(lens.surfaces[0], 4 * 25.4),
              25.4 * *sag(read_zemax_lens(kZemax, faults).lens.surfaces[0], 4), 1e-9);
}

TEST(ZemaxFile, MayBeOfTwoBytesALetter) {
  std::string wide = "\xff\xfe";
  for (const char* c = kZemax; *c != 0; ++c) wide += {*c, '\0'};
  std::vector<Fault> faults;
  EXPECT_EQ(read_zemax_lens(wide, faults).lens.surfaces.size(), 2u);
  // Cut off within the last one.
  EXPECT_EQ(read_zemax_lens(wide.substr(0, wide.size() - 1), faults).lens.surfaces.size(), 2u);
  EXPECT_TRUE(faults.empty());
}

TEST(ZemaxFile, FaultsAreLocated) {
  std::string text = kZemax;
  text.replace(text.find("GLAS N-BK7 0 0 1.5168 64.17"), 27, "GLAS N-BK8");
  text.replace(text.find("PARM 1 0"), 8, "PARM 1 3");
  text.replace(text.find("TYPE STANDARD\n  CURV -0.01"), 13, "TYPE TOROIDAL");
  std::vector<Fault> faults;
  read_zemax_lens(text, faults);
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_THAT(faults[0].message, HasSubstr("height^2 is not supported"));
  EXPECT_EQ(faults[0].line, 21);
  EXPECT_THAT(faults[1].message, HasSubstr("there is no glass 'N-BK8'; did you mean 'N-BK7'?"));
  EXPECT_EQ(faults[1].column, 8);
  EXPECT_THAT(faults[2].message, HasSubstr("TOROIDAL are not supported"));
  faults.clear();
  read_zemax_lens("", faults);
  EXPECT_THAT(faults.at(0).message, HasSubstr("no lens"));
}

}  // namespace
}  // namespace tessera::optics
