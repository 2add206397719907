// The prescriptions that come with the scenes, against what their sources say of them.
#include "import/lens/lens_file.h"

#include <gtest/gtest.h>

#include "optics/lens_system.h"

namespace tessera::client {
namespace {

struct Published {
  const char* file;
  double focal_length;    // mm
  double back_focus = 0;  // from the last surface to the focus, mm; 0: not told
};

TEST(LensFiles, HaveThePublishedFocalLengths) {
  for (const Published& lens :
       {Published{"double-gauss.textproto", 50}, Published{"cooke-triplet.textproto", 101.181, 77.405},
        Published{"fisheye.dat", 16}, Published{"wide-angle.textproto", 28},
        Published{"telephoto.textproto", 135}, Published{"petzval.textproto", 100, 56.5}}) {
    SCOPED_TRACE(lens.file);
    const auto file = read_lens_file(std::string("scenes/lenses/") + lens.file);
    ASSERT_TRUE(file.ok()) << file.status();
    std::vector<optics::Fault> faults;
    const auto system = optics::LensSystem::focus(file->lens, {}, faults);
    for (const optics::Fault& fault : faults) ADD_FAILURE() << fault.message;
    ASSERT_TRUE(system);
    const optics::Paraxial& paraxial = system->paraxial();
    EXPECT_NEAR(paraxial.focal_length() / lens.focal_length, 1, 1e-3);
    if (lens.back_focus > 0) {
      EXPECT_NEAR(paraxial.back_focus() / lens.back_focus, 1, 1e-3);
    }
  }
}

TEST(LensFiles, TelephotoLensesAreShorterThanTheirFocalLength) {
  const auto file = read_lens_file("scenes/lenses/telephoto.textproto");
  ASSERT_TRUE(file.ok()) << file.status();
  const optics::Paraxial paraxial = optics::paraxial_of(file->lens, optics::kLineD);
  EXPECT_LT(paraxial.length + paraxial.back_focus(), 0.95 * paraxial.focal_length());
}

}  // namespace
}  // namespace tessera::client
